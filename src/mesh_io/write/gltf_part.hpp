// Lays out one mesh in the binary data of a glTF file, and writes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "files/output_file.hpp"
#include "mesh/mesh.hpp"
#include "mesh/mesh_sink.hpp"
#include "mesh/metrics.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"

namespace isoextract::mesh_io {

// Views, accessors and GLB chunks start at multiples of this many bytes.
inline constexpr std::uint64_t kGltfAlignment = 4;

[[nodiscard]] constexpr std::uint64_t gltf_aligned(std::uint64_t bytes) {
  return (bytes + kGltfAlignment - 1) / kGltfAlignment * kGltfAlignment;
}

// Replaces every byte that is not valid UTF-8 by U+FFFD, since JSON holds only Unicode.
[[nodiscard]] std::string as_utf8(const std::string& text);

// An attribute and its name in glTF: COLOR_0, or an underscore and its own name. Upper case is a mere custom in glTF,
// so names stay unchanged and read back equal.
struct GltfSemantic {
  const mesh::Attribute* attribute;
  std::string name;

  // Returns the bytes from value to value: a multiple of 4, as glTF 2.0, 3.6.2.4 requires.
  [[nodiscard]] std::size_t stride() const { return gltf_aligned(attribute->stride()); }
};

struct GltfPackedPart;

// The binary layout of one mesh: its positions, normals, each attribute in turn, then the indices; or the packed form
// of these. Refers to the mesh, which must outlive it; once `packed` is set, its arrays may be empty.
struct GltfPart {
  const mesh::Mesh* mesh = nullptr;
  mesh::MeshShape shape;                    // of the mesh
  std::optional<mesh::LocalBounds> bounds;  // of the mesh, if they do not come from its array
  std::vector<GltfSemantic> semantics;
  enum class Layout {
    nothing,  // no triangles: glTF has no empty accessors
    split,    // three vertices per triangle, position and face normal interleaved; attributes; no indices
    indexed,  // positions, normals if any, attributes, indices
  } layout = Layout::nothing;
  bool short_indices = false;
  std::shared_ptr<const GltfPackedPart> packed;  // null if not packed

  // The value 65535 means primitive restart and is no index.
  static constexpr std::size_t kMaxShortVertices = 65535;
  static constexpr std::size_t kSplitStride = 2 * sizeof(glm::vec3);

  GltfPart(const mesh::Mesh& source, bool flat_normals, Notes& notes);
  // Lays out a mesh that is not in memory, without normals of faces; `head` is this mesh without arrays and without the
  // values of its attributes. Set `bounds` before the JSON is made.
  GltfPart(const mesh::Mesh& head, const mesh::MeshShape& shape, Notes& notes);
  // Packs as options.packing asks; its box must be set if positions are quantized. Fails as pack_part() does.
  [[nodiscard]] static Result<GltfPart> make(const mesh::Mesh& source, const MeshWriteOptions& options,
                                             const Context& context, Notes& notes);

  [[nodiscard]] bool has_normals() const { return shape.has_normals; }
  [[nodiscard]] bool has_colors() const;
  [[nodiscard]] std::uint64_t vertex_count() const;
  [[nodiscard]] std::uint64_t index_bytes() const;
  [[nodiscard]] std::uint64_t bytes() const;  // of the whole part in the file, with padding
};

// Writes the value of a vertex, padded as GltfSemantic::stride() says, and returns its end.
[[nodiscard]] char* put_gltf_value(char* out, const mesh::Attribute& attribute, std::size_t vertex);

[[nodiscard]] Result<void> write_part(const GltfPart& part, files::OutputFile& file);

}  // namespace isoextract::mesh_io
