// The container of binary glTF (glTF 2.0, chapter 4): a header, a JSON chunk and, if there is data, a binary chunk.
#pragma once

#include <cstdint>
#include <string>

#include "base/error.hpp"
#include "mesh_io/write/gltf_part.hpp"

namespace isoextract::mesh_io {

inline constexpr std::uint64_t kGlbHeadBytes = 3 * sizeof(std::uint32_t);
inline constexpr std::uint64_t kGlbChunkHeadBytes = 2 * sizeof(std::uint32_t);

// Returns the size of the whole file. Here and below, `json_bytes` is a multiple of kGltfAlignment.
[[nodiscard]] constexpr std::uint64_t glb_bytes(std::uint64_t json_bytes, std::uint64_t binary_bytes) {
  return kGlbHeadBytes + kGlbChunkHeadBytes + json_bytes + (binary_bytes > 0 ? kGlbChunkHeadBytes + binary_bytes : 0);
}

// Returns the bytes before the JSON: the header of the file and of the JSON chunk.
[[nodiscard]] std::string glb_start(std::uint64_t json_bytes, std::uint64_t binary_bytes);

// Returns the bytes before the data: the header of the binary chunk.
[[nodiscard]] std::string glb_binary_head(std::uint64_t binary_bytes);

// Pads the JSON with spaces to a multiple of kGltfAlignment, as the container requires.
void pad_glb_json(std::string& json);

}  // namespace isoextract::mesh_io
