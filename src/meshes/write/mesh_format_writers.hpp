// The writers behind mesh_writer.hpp, one file a format. They write and leave opening and committing to write_meshes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "files/output_file.hpp"
#include "mesh/mesh.hpp"
#include "meshes/mesh_writer.hpp"

namespace isoextract::meshes {

// What a format could not hold is added here, one sentence each.
using Notes = std::vector<std::string>;

[[nodiscard]] Result<void> write_glb(std::span<const mesh::Mesh> meshes, const MeshWriteOptions& options,
                                     files::OutputFile& file, Notes& notes);

// `binary_name` is the file name of `binary`, as the model refers to it.
[[nodiscard]] Result<void> write_gltf(std::span<const mesh::Mesh> meshes, const MeshWriteOptions& options,
                                      files::OutputFile& model, files::OutputFile& binary,
                                      const std::string& binary_name, Notes& notes);

[[nodiscard]] Result<void> write_ply(const mesh::Mesh& mesh, const MeshWriteOptions& options, files::OutputFile& file,
                                     Notes& notes);

[[nodiscard]] Result<void> write_obj(std::span<const mesh::Mesh> meshes, const MeshWriteOptions& options,
                                     files::OutputFile& file);

[[nodiscard]] Result<void> write_stl(const mesh::Mesh& mesh, const MeshWriteOptions& options, files::OutputFile& file,
                                     Notes& notes);

}  // namespace isoextract::meshes
