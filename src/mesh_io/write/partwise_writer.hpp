// Writers of one mesh whose parts come in any order, from several threads (mesh/mesh_sink.hpp). Each part goes to its
// place in the file at once. The file has the same bytes as one written from the whole mesh.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "base/note.hpp"
#include "files/output_file.hpp"
#include "mesh/mesh.hpp"
#include "mesh/mesh_sink.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::mesh_io {

class PartwiseWriter : public mesh::MeshSink {
 public:
  // Returns what a rank must tell rank 0 about its parts, if several write one file and all call begin() with the same
  // shape. Rank 0 adds the facts of the others in their order, and finishes.
  [[nodiscard]] virtual std::string facts() const { return {}; }
  virtual void add_facts(std::string_view /*facts*/) {}
  // Writes what is known only after the last part. Call once.
  [[nodiscard]] virtual Result<void> finish(Notes& notes) = 0;
};

// `head` is the mesh without its arrays; it has no attributes. `head` and the file must outlive the writer.
[[nodiscard]] std::unique_ptr<PartwiseWriter> make_partwise_ply_writer(const mesh::Mesh& head,
                                                                       const MeshWriteOptions& options,
                                                                       files::OutputFile& file);
// Declines meshes whose indices have 16 bits: they are small.
[[nodiscard]] std::unique_ptr<PartwiseWriter> make_partwise_glb_writer(const mesh::Mesh& head,
                                                                       const MeshWriteOptions& options,
                                                                       files::OutputFile& file);

}  // namespace isoextract::mesh_io
