// Encodes and decodes vertex values and indices as the bit streams of meshoptimizer (EXT_meshopt_compression).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace isoextract::mesh_io {

enum class MeshoptMode { attributes, triangles, indices };
enum class MeshoptFilter { none, octahedral, quaternion, exponential };

// Returns the extension's name of the mode.
[[nodiscard]] std::string_view meshopt_word(MeshoptMode mode);

// Encodes values of `stride` bytes each; `stride` is a multiple of 4, at most 256.
[[nodiscard]] std::vector<std::byte> encode_meshopt_values(std::span<const std::byte> values, std::size_t stride);
// Encodes three indices per triangle. Decoding may return a triangle's corners rotated.
[[nodiscard]] std::vector<std::byte> encode_meshopt_triangles(std::span<const std::uint32_t> indices,
                                                              std::size_t vertices);

struct MeshoptView {
  MeshoptMode mode = MeshoptMode::attributes;
  MeshoptFilter filter = MeshoptFilter::none;
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
};

// Returns whether the extension allows this combination of mode, filter, count and stride.
[[nodiscard]] bool is_valid(const MeshoptView& view);

// Decodes untrusted bytes into `out`, which has view.count * view.stride bytes. Requires is_valid(view). Returns false
// if the bytes are damaged.
[[nodiscard]] bool decode_meshopt(std::span<const std::byte> bytes, const MeshoptView& view, std::span<std::byte> out);

}  // namespace isoextract::mesh_io
