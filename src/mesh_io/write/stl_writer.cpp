// STL (3D Systems, 1989): triangles without connectivity, each with its normal; float32 only.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "base/version.hpp"
#include "files/record_stream.hpp"
#include "mesh/metrics.hpp"
#include "mesh_io/detail/placement_entry.hpp"
#include "mesh_io/detail/stl_layout.hpp"
#include "mesh_io/write/mesh_encoding.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"

namespace isoextract::mesh_io {
namespace {

// Returns a note if rounding world coordinates to float32 may move them by a thousandth of an edge or more.
std::optional<Note> precision_note(const mesh::Mesh& mesh) {
  if (mesh.origin == glm::dvec3(0)) return std::nullopt;
  const mesh::Bounds bounds = mesh::measure_bounds(mesh);
  double farthest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    farthest = std::max({farthest, std::abs(bounds.min[axis]), std::abs(bounds.max[axis])});
  }
  const float nearest_float = static_cast<float>(farthest);
  const float step = std::nextafter(nearest_float, std::numeric_limits<float>::infinity()) - nearest_float;
  constexpr double kSmallPart = 1e-3;
  if (step / 2 < kSmallPart * mesh::typical_edge(mesh)) return std::nullopt;
  return Note{NoteId::rounded_positions,
              fmt::format("STL stores only float32 coordinates: at {:.9g}, the largest, neighboring values are {:.3g} "
                          "apart; glb, gltf, ply and obj store the full precision",
                          farthest, step)};
}

// The header must not start with "solid", or readers would take the file for text. It starts with the program's name.
std::array<char, kStlHeaderBytes> binary_header(const std::string& placement) {
  std::string text(generator());
  if (!placement.empty()) text += fmt::format(" {} ", kPlacementEntry);
  text += text.size() + placement.size() <= kStlHeaderBytes ? std::string_view(placement) : kPlacementOmitted;
  std::array<char, kStlHeaderBytes> header{};
  put_text(header.data(), text);
  return header;
}

template <class Position>
Result<void> write_binary(const mesh::Mesh& mesh, Position position, const std::string& placement,
                          files::OutputFile& file) {
  const std::array<char, kStlHeaderBytes> header = binary_header(placement);
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  auto written = file.write(std::as_bytes(std::span(header)));
  if (written) written = file.write(std::as_bytes(std::span(&count, 1)));
  if (!written) return written;

  constexpr std::uint16_t kNoAttributes = 0;
  constexpr std::size_t kRecord = 4 * sizeof(glm::vec3) + sizeof(kNoAttributes);
  return files::write_records(file, mesh.triangles.size(), kRecord,
                              [&](std::size_t first, std::size_t last, char* out) {
                                for (std::size_t t = first; t < last; ++t) {
                                  const glm::uvec3 triangle = mesh.triangles[t];
                                  out = put_bytes(out, face_normal(mesh, triangle));
                                  for (int corner = 0; corner < 3; ++corner)
                                    out = put_bytes(out, glm::vec3(position(triangle[corner])));
                                  out = put_bytes(out, kNoAttributes);
                                }
                                return out;
                              });
}

template <class Position>
Result<void> write_ascii(const mesh::Mesh& mesh, Position position, files::OutputFile& file) {
  const std::string name = mesh.name.empty() ? std::string("isoextract") : one_line(mesh.name);
  auto written = file.write(fmt::format("solid {}\n", name));
  if (!written) return written;

  constexpr std::string_view kFacet = "facet normal";
  constexpr std::string_view kLoop = "\n outer loop\n";
  constexpr std::string_view kVertex = "  vertex";
  constexpr std::string_view kEnd = " endloop\nendfacet\n";
  constexpr std::size_t kText = kFacet.size() + kMaxVectorText<float> + kLoop.size() +
                                3 * (kVertex.size() + kMaxVectorText<float> + 1) + kEnd.size();
  written =
      files::write_records(file, mesh.triangles.size(), kText, [&](std::size_t first, std::size_t last, char* out) {
        for (std::size_t t = first; t < last; ++t) {
          const glm::uvec3 triangle = mesh.triangles[t];
          out = put_vector(put_text(out, kFacet), face_normal(mesh, triangle));
          out = put_text(out, kLoop);
          for (int corner = 0; corner < 3; ++corner) {
            out = put_vector(put_text(out, kVertex), glm::vec3(position(triangle[corner])));
            *out++ = '\n';
          }
          out = put_text(out, kEnd);
        }
        return out;
      });
  if (!written) return written;
  return file.write(fmt::format("endsolid {}\n", name));
}

}  // namespace

Result<void> write_stl(const mesh::Mesh& mesh, const MeshWriteOptions& options, files::OutputFile& file, Notes& notes) {
  constexpr std::uint64_t kMaxTriangles = std::numeric_limits<std::uint32_t>::max();
  if (!options.ascii && mesh.triangles.size() > kMaxTriangles) {
    return fail(ErrorCode::output,
                fmt::format("{}: the mesh has {} triangles, binary STL holds at most {}", file.shown_name(),
                            mesh.triangles.size(), kMaxTriangles),
                {Remedy::set, Setting::mesh_format, "ply"});
  }
  if (auto note = precision_note(mesh)) notes.push_back(std::move(*note));
  return with_world_positions(mesh, [&](auto position) {
    return options.ascii ? write_ascii(mesh, position, file) : write_binary(mesh, position, options.placement, file);
  });
}

}  // namespace isoextract::mesh_io
