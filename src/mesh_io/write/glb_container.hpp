// The container of binary glTF (glTF 2.0, chapter 4): a header, a chunk of JSON, and one of data unless there is none.
#pragma once

#include <cstdint>
#include <string>

#include "base/error.hpp"
#include "mesh_io/write/gltf_part.hpp"

namespace isoextract::mesh_io {

inline constexpr std::uint64_t kGlbHeadBytes = 3 * sizeof(std::uint32_t);
inline constexpr std::uint64_t kGlbChunkHeadBytes = 2 * sizeof(std::uint32_t);

// Of the whole file. `json_bytes` is a multiple of kGltfAlignment, here and below.
[[nodiscard]] constexpr std::uint64_t glb_bytes(std::uint64_t json_bytes, std::uint64_t binary_bytes) {
  return kGlbHeadBytes + kGlbChunkHeadBytes + json_bytes + (binary_bytes > 0 ? kGlbChunkHeadBytes + binary_bytes : 0);
}

// What comes before the JSON.
[[nodiscard]] std::string glb_start(std::uint64_t json_bytes, std::uint64_t binary_bytes);

// What comes before the data.
[[nodiscard]] std::string glb_binary_head(std::uint64_t binary_bytes);

// With spaces, as the container wants it.
void pad_glb_json(std::string& json);

}  // namespace isoextract::mesh_io
