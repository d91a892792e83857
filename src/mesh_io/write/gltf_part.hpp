// How one mesh lies in the binary part of a glTF file, and writing it there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "files/output_file.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"

namespace isoextract::mesh_io {

// What views, accessors and GLB chunks start at multiples of.
inline constexpr std::uint64_t kGltfAlignment = 4;

[[nodiscard]] constexpr std::uint64_t gltf_aligned(std::uint64_t bytes) {
  return (bytes + kGltfAlignment - 1) / kGltfAlignment * kGltfAlignment;
}

// JSON holds Unicode only; every byte that is no part of UTF-8 becomes U+FFFD.
[[nodiscard]] std::string as_utf8(const std::string& text);

// An attribute that is written, and what glTF calls it: COLOR_0, or its name behind an underscore. Upper case is a
// custom there, and no rule: names stay as they are, so that they come back.
struct GltfSemantic {
  const mesh::Attribute* attribute;
  std::string name;

  // Each value starts at a multiple of four bytes; glTF 2.0, 3.6.2.4.
  [[nodiscard]] std::size_t stride() const { return gltf_aligned(attribute->stride()); }
};

struct GltfPackedPart;

// A mesh's vertices, their attributes one after another, then its indices; or what an extension makes of them.
struct GltfPart {
  const mesh::Mesh* mesh = nullptr;
  std::vector<GltfSemantic> semantics;
  enum class Layout {
    nothing,  // no triangles: glTF has no empty accessors
    split,    // three vertices a triangle, position and face normal interleaved, no indices
    indexed,  // positions, normals if any, indices
  } layout = Layout::nothing;
  bool short_indices = false;
  std::shared_ptr<const GltfPackedPart> packed;  // where it is

  // 65535 restarts primitives and is no index.
  static constexpr std::size_t kMaxShortVertices = 65535;
  static constexpr std::size_t kSplitStride = 2 * sizeof(glm::vec3);

  GltfPart(const mesh::Mesh& source, bool flat_normals, Notes& notes);
  // As options.packing asks; its box is known. Fails as pack_part() does.
  [[nodiscard]] static Result<GltfPart> make(const mesh::Mesh& source, const MeshWriteOptions& options,
                                             const Context& context, Notes& notes);

  [[nodiscard]] bool has_normals() const { return !mesh->normals.empty(); }
  [[nodiscard]] bool has_colours() const;
  [[nodiscard]] std::uint64_t vertex_count() const;
  [[nodiscard]] std::uint64_t index_bytes() const;
  [[nodiscard]] std::uint64_t bytes() const;  // of all of it, in the file
};

[[nodiscard]] Result<void> write_part(const GltfPart& part, files::OutputFile& file);

}  // namespace isoextract::mesh_io
