// meshoptimizer's bit streams as EXT_meshopt_compression has them: values of vertices and indices into bytes and back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace isoextract::mesh_io {

enum class MeshoptMode { attributes, triangles, indices };
enum class MeshoptFilter { none, octahedral, quaternion, exponential };

// In the words of the extension.
[[nodiscard]] std::string_view meshopt_word(MeshoptMode mode);

// `count` values of `stride` bytes, a multiple of four up to 256.
[[nodiscard]] std::vector<std::byte> encode_meshopt_values(std::span<const std::byte> values, std::size_t stride);
// Three a triangle; the corners of a triangle may turn.
[[nodiscard]] std::vector<std::byte> encode_meshopt_triangles(std::span<const std::uint32_t> indices,
                                                              std::size_t vertices);

struct MeshoptView {
  MeshoptMode mode = MeshoptMode::attributes;
  MeshoptFilter filter = MeshoptFilter::none;
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
};

// Whether the extension allows that.
[[nodiscard]] bool is_valid(const MeshoptView& view);

// Of bytes that may be anything, into view.count * view.stride bytes; `view` is valid. False where they are damaged.
[[nodiscard]] bool decode_meshopt(std::span<const std::byte> bytes, const MeshoptView& view, std::span<std::byte> out);

}  // namespace isoextract::mesh_io
