// The writers of the single formats. mesh_writer.cpp calls them, and opens and commits their files.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "files/output_file.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::mesh_io {

// Writes one file, mesh after mesh. `notes` receives sentences about data that the writer changes or omits.
// If a format cannot store attributes, MeshWriter notes it.
class FormatWriter {
 public:
  virtual ~FormatWriter() = default;
  // The mesh must live until finish() if MeshFormatInfo::writes_each_mesh_at_once is false; otherwise only during the
  // call. After the call, a mesh that is packed may have no arrays and no values of attributes.
  [[nodiscard]] virtual Result<void> add(const mesh::Mesh& mesh, Notes& notes) = 0;
  // Completes the file, and writes the meshes if MeshFormatInfo::writes_each_mesh_at_once is false. Call once.
  [[nodiscard]] virtual Result<void> finish(Notes& notes) = 0;
  // Returns one entry per mesh if packing was requested; all zero for a mesh without triangles.
  [[nodiscard]] virtual std::vector<PackedFacts> packed() const { return {}; }
};

// The files must outlive the writers.
[[nodiscard]] std::unique_ptr<FormatWriter> make_glb_writer(const MeshWriteOptions& options, const Context& context,
                                                            files::OutputFile& file);

// Writes a GLB of two or more unpacked meshes; `file` must be a regular one. Each mesh must live only during add(). The
// bytes are those of make_glb_writer(), but finish() moves the data to make room for the JSON. So the file has no
// hash until commit() reads it back.
[[nodiscard]] std::unique_ptr<FormatWriter> make_streamed_glb_writer(const MeshWriteOptions& options,
                                                                     const Context& context, files::OutputFile& file);

// `binary_name` is the name by which the model refers to `binary`.
[[nodiscard]] std::unique_ptr<FormatWriter> make_gltf_writer(const MeshWriteOptions& options, const Context& context,
                                                             files::OutputFile& model, files::OutputFile& binary,
                                                             const std::string& binary_name);

[[nodiscard]] std::unique_ptr<FormatWriter> make_obj_writer(const MeshWriteOptions& options, const Context& context,
                                                            files::OutputFile& file);

[[nodiscard]] std::unique_ptr<FormatWriter> make_drc_writer(const MeshWriteOptions& options, const Context& context,
                                                            files::OutputFile& file);

// PLY and STL hold one mesh per file, so their writers need no state.
[[nodiscard]] Result<void> write_ply(const mesh::Mesh& mesh, const MeshWriteOptions& options, files::OutputFile& file,
                                     Notes& notes);

[[nodiscard]] Result<void> write_stl(const mesh::Mesh& mesh, const MeshWriteOptions& options, files::OutputFile& file,
                                     Notes& notes);

}  // namespace isoextract::mesh_io
