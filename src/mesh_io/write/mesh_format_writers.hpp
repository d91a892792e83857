// The writers behind mesh_writer.hpp, one file a format. They write and leave opening and committing to it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "files/output_file.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::mesh_io {

// What a format could not hold is added here, one sentence each.
using Notes = std::vector<std::string>;

// A file that is being written, one mesh after another.
class FormatWriter {
 public:
  virtual ~FormatWriter() = default;
  // The mesh has to outlive the call only where MeshFormatInfo::writes_as_they_come is false: then until finish().
  [[nodiscard]] virtual Result<void> add(const mesh::Mesh& mesh, Notes& notes) = 0;
  // What comes after the last mesh. Called once.
  [[nodiscard]] virtual Result<void> finish(Notes& notes) = 0;
  // One a mesh, where they were to be packed; of one without triangles nothing is packed.
  [[nodiscard]] virtual std::vector<PackedFacts> packed() const { return {}; }
};

// The files outlive the writer.
[[nodiscard]] std::unique_ptr<FormatWriter> make_glb_writer(const MeshWriteOptions& options, const Context& context,
                                                            files::OutputFile& file);

// `binary_name` is the file name of `binary`, as the model refers to it.
[[nodiscard]] std::unique_ptr<FormatWriter> make_gltf_writer(const MeshWriteOptions& options, const Context& context,
                                                             files::OutputFile& model, files::OutputFile& binary,
                                                             const std::string& binary_name);

[[nodiscard]] std::unique_ptr<FormatWriter> make_obj_writer(const MeshWriteOptions& options, const Context& context,
                                                            files::OutputFile& file);

[[nodiscard]] std::unique_ptr<FormatWriter> make_drc_writer(const MeshWriteOptions& options, const Context& context,
                                                            files::OutputFile& file);

// Formats of one mesh a file need no state.
[[nodiscard]] Result<void> write_ply(const mesh::Mesh& mesh, const MeshWriteOptions& options, files::OutputFile& file,
                                     Notes& notes);

[[nodiscard]] Result<void> write_stl(const mesh::Mesh& mesh, const MeshWriteOptions& options, files::OutputFile& file,
                                     Notes& notes);

}  // namespace isoextract::mesh_io
