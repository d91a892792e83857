// PLY (Greg Turk, 1994): a text header, then vertices and faces, binary or text.
#include <array>
#include <utility>

#include <fmt/format.h>

#include "base/version.hpp"
#include "files/record_stream.hpp"
#include "meshes/write/mesh_encoding.hpp"
#include "meshes/write/mesh_format_writers.hpp"

namespace isoextract::meshes {
namespace {

constexpr std::uint8_t kCorners = 3;

std::string header(const mesh::Mesh& mesh, const MeshWriteOptions& options) {
  const auto vector = [](std::string_view type, std::string_view prefix) {
    return fmt::format("property {0} {1}x\nproperty {0} {1}y\nproperty {0} {1}z\n", type, prefix);
  };
  const bool is_double = mesh.origin != glm::dvec3(0);
  std::string text =
      fmt::format("ply\nformat {} 1.0\ncomment {}\n", options.ascii ? "ascii" : "binary_little_endian", generator());
  text += fmt::format("element vertex {}\n", mesh.positions.size()) + vector(is_double ? "double" : "float", "");
  if (!options.flat_normals && !mesh.normals.empty()) text += vector("float", "n");
  text += fmt::format("element face {}\nproperty list uchar uint vertex_indices\n", mesh.triangles.size());
  if (options.flat_normals) text += vector("float", "n");
  return text + "end_header\n";
}

Result<void> write_binary(const mesh::Mesh& mesh, bool vertex_normals, bool face_normals, files::OutputFile& file) {
  const auto write_vertices = [&](auto position) -> Result<void> {
    using Position = decltype(position(0));
    if (std::is_same_v<Position, glm::vec3> && !vertex_normals) return file.write(std::as_bytes(mesh.positions.span()));
    const std::size_t record = sizeof(Position) + (vertex_normals ? sizeof(glm::vec3) : 0);
    return files::write_records(file, mesh.positions.size(), record,
                                [&](std::size_t first, std::size_t last, char* out) {
                                  for (std::size_t v = first; v < last; ++v) {
                                    out = put_bytes(out, position(v));
                                    if (vertex_normals) out = put_bytes(out, mesh.normals[v]);
                                  }
                                  return out;
                                });
  };
  if (auto written = visit_positions(mesh, write_vertices); !written) return written;

  const std::size_t record = sizeof(kCorners) + sizeof(glm::uvec3) + (face_normals ? sizeof(glm::vec3) : 0);
  return files::write_records(file, mesh.triangles.size(), record, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t t = first; t < last; ++t) {
      out = put_bytes(out, kCorners);
      out = put_bytes(out, mesh.triangles[t]);
      if (face_normals) out = put_bytes(out, face_normal(mesh, mesh.triangles[t]));
    }
    return out;
  });
}

Result<void> write_ascii(const mesh::Mesh& mesh, bool vertex_normals, bool face_normals, files::OutputFile& file) {
  const auto write_vertices = [&](auto position) -> Result<void> {
    using Number = typename decltype(position(0))::value_type;
    constexpr std::size_t kLine = kMaxVectorText<Number> + kMaxVectorText<float> + 1;
    return files::write_records(file, mesh.positions.size(), kLine,
                                [&](std::size_t first, std::size_t last, char* out) {
                                  for (std::size_t v = first; v < last; ++v) {
                                    // The vector's leading blank is overwritten: some readers do not expect one.
                                    char* line = out;
                                    out = put_vector(out, position(v));
                                    out = std::copy(line + 1, out, line);
                                    if (vertex_normals) out = put_vector(out, mesh.normals[v]);
                                    *out++ = '\n';
                                  }
                                  return out;
                                });
  };
  if (auto written = visit_positions(mesh, write_vertices); !written) return written;

  constexpr std::size_t kLine = 1 + kMaxVectorText<std::uint32_t> + kMaxVectorText<float> + 1;
  return files::write_records(file, mesh.triangles.size(), kLine, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t t = first; t < last; ++t) {
      *out++ = '0' + kCorners;
      out = put_vector(out, mesh.triangles[t]);
      if (face_normals) out = put_vector(out, face_normal(mesh, mesh.triangles[t]));
      *out++ = '\n';
    }
    return out;
  });
}

}  // namespace

Result<void> write_ply(const mesh::Mesh& mesh, const MeshWriteOptions& options, files::OutputFile& file) {
  if (auto written = file.write(header(mesh, options)); !written) return written;
  const bool vertex_normals = !options.flat_normals && !mesh.normals.empty();
  return (options.ascii ? write_ascii : write_binary)(mesh, vertex_normals, options.flat_normals, file);
}

}  // namespace isoextract::meshes
