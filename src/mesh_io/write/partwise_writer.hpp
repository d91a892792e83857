// Writers of a file with one mesh, which they get in parts (mesh/mesh_sink.hpp). The file has the same bytes as one
// written from the whole mesh. In binary PLY and glTF, whose records have one size, take() writes each part to its
// place, in any order. Text and streams are written in order, and so are STL and normals of faces, which need the
// vertices of the next part. Vertices may come before the numbers of vertices and triangles are known
// (begin_early()): the first ones of a file with places.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "files/output_file.hpp"
#include "mesh/mesh.hpp"
#include "mesh/mesh_sink.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::mesh_io {

class PartwiseWriter : public mesh::MeshSink {
 public:
  // Returns the facts about the parts of a rank that rank 0 needs, if several ranks write one file and all call begin()
  // with the same shape. Rank 0 calls add_facts() for the other ranks in their order, then finish().
  [[nodiscard]] virtual std::string facts() const { return {}; }
  virtual void add_facts(std::string_view /*facts*/) {}
  // Writes the data that depend on all parts: in a GLB the bounds of the positions. Call once, after the last part.
  [[nodiscard]] virtual Result<void> finish(Notes& notes) = 0;
};

// `head` is the mesh without vertices, triangles and the values of attributes. `head` and the file must outlive the
// writer. The options must be without packing, and in glTF without flat normals.

// Makes a writer of a regular file; the PLY is binary. begin() of glTF returns false for a mesh with 16-bit
// indices, which is small.
[[nodiscard]] std::unique_ptr<PartwiseWriter> make_partwise_ply_writer(const mesh::Mesh& head,
                                                                       const MeshWriteOptions& options,
                                                                       const Context& context, files::OutputFile& file);
[[nodiscard]] std::unique_ptr<PartwiseWriter> make_partwise_glb_writer(const mesh::Mesh& head,
                                                                       const MeshWriteOptions& options,
                                                                       files::OutputFile& file);

// Makes a writer that can also write to a stream, such as a pipe. The PLY may be text.
[[nodiscard]] std::unique_ptr<PartwiseWriter> make_ordered_ply_writer(const mesh::Mesh& head,
                                                                      const MeshWriteOptions& options,
                                                                      const Context& context, files::OutputFile& file);
[[nodiscard]] std::unique_ptr<PartwiseWriter> make_ordered_glb_writer(const mesh::Mesh& head,
                                                                      const MeshWriteOptions& options,
                                                                      files::OutputFile& file);

// `binary_name` is the name by which the model refers to `binary`.
[[nodiscard]] std::unique_ptr<PartwiseWriter> make_partwise_gltf_writer(const mesh::Mesh& head,
                                                                        const MeshWriteOptions& options,
                                                                        files::OutputFile& model,
                                                                        files::OutputFile& binary,
                                                                        const std::string& binary_name);

// begin() returns false if several vertices share a position because of their normals.
[[nodiscard]] std::unique_ptr<PartwiseWriter> make_partwise_obj_writer(const mesh::Mesh& head,
                                                                       const MeshWriteOptions& options,
                                                                       const Context& context, files::OutputFile& file);
[[nodiscard]] std::unique_ptr<PartwiseWriter> make_partwise_stl_writer(const mesh::Mesh& head,
                                                                       const MeshWriteOptions& options,
                                                                       const Context& context, files::OutputFile& file);

}  // namespace isoextract::mesh_io
