// STL (3D Systems, 1989): triangles without connectivity, each with its normal; float32 only.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/version.hpp"
#include "files/record_stream.hpp"
#include "mesh/metrics.hpp"
#include "mesh_io/detail/placement_entry.hpp"
#include "mesh_io/detail/stl_layout.hpp"
#include "mesh_io/write/mesh_encoding.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"
#include "mesh_io/write/partwise_writer.hpp"
#include "mesh_io/write/waiting_part.hpp"

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

// A triangle as stored in the file.
struct Facet {
  glm::vec3 normal;
  std::array<glm::vec3, 3> corners;
};

char* put_binary(char* out, const Facet& facet) {
  constexpr std::uint16_t kNoAttributes = 0;
  return put_bytes(put_bytes(out, facet), kNoAttributes);
}
constexpr std::size_t kBinaryFacet = sizeof(Facet) + sizeof(std::uint16_t);
static_assert(kBinaryFacet == 50);

constexpr std::string_view kFacetText = "facet normal";
constexpr std::string_view kLoopText = "\n outer loop\n";
constexpr std::string_view kVertexText = "  vertex";
constexpr std::string_view kEndText = " endloop\nendfacet\n";
constexpr std::size_t kAsciiFacet = kFacetText.size() + kMaxVectorText<float> + kLoopText.size() +
                                    3 * (kVertexText.size() + kMaxVectorText<float> + 1) + kEndText.size();

char* put_ascii(char* out, const Facet& facet) {
  out = put_vector(put_text(out, kFacetText), facet.normal);
  out = put_text(out, kLoopText);
  for (const glm::vec3& corner : facet.corners) {
    out = put_vector(put_text(out, kVertexText), corner);
    *out++ = '\n';
  }
  return put_text(out, kEndText);
}

// Writes facet(t) for `count` triangles.
template <class FacetOf>
Result<void> write_facets(std::size_t count, bool ascii, FacetOf facet, files::OutputFile& file) {
  return files::write_records(file, count, ascii ? kAsciiFacet : kBinaryFacet,
                              [&](std::size_t first, std::size_t last, char* out) {
                                for (std::size_t t = first; t < last; ++t) {
                                  out = ascii ? put_ascii(out, facet(t)) : put_binary(out, facet(t));
                                }
                                return out;
                              });
}

std::string solid_name(const mesh::Mesh& mesh) {
  return mesh.name.empty() ? std::string("isoextract") : one_line(mesh.name);
}

// Writes the header. Fails if binary STL cannot hold that many triangles.
Result<void> write_start(const mesh::Mesh& head, std::uint64_t triangles, const MeshWriteOptions& options,
                         files::OutputFile& file) {
  if (options.ascii) return file.write(fmt::format("solid {}\n", solid_name(head)));
  constexpr std::uint64_t kMaxTriangles = std::numeric_limits<std::uint32_t>::max();
  if (triangles > kMaxTriangles) {
    return fail(ErrorCode::output,
                fmt::format("{}: the mesh has {} triangles, binary STL holds at most {}", file.shown_name(), triangles,
                            kMaxTriangles),
                {Remedy::set, Setting::mesh_format, "ply"});
  }
  const std::array<char, kStlHeaderBytes> header = binary_header(options.placement);
  const auto count = static_cast<std::uint32_t>(triangles);
  TRY(file.write(std::as_bytes(std::span(header))));
  return file.write(std::as_bytes(std::span(&count, 1)));
}

// Writes the end line of text.
Result<void> write_end(const mesh::Mesh& head, const MeshWriteOptions& options, files::OutputFile& file) {
  return options.ascii ? file.write(fmt::format("endsolid {}\n", solid_name(head))) : Result<void>();
}

class PartwiseStlWriter final : public PartwiseWriter {
 public:
  PartwiseStlWriter(const mesh::Mesh& head, const MeshWriteOptions& options, const Context& context,
                    files::OutputFile& file)
      : head_(head), options_(options), file_(file), waiting_(context, file.shown_name()) {}

  Result<bool> begin(const mesh::MeshShape& shape) override {
    TRY(waiting_.begin(shape));
    TRY(write_start(head_, shape.triangles, options_, file_));
    return true;
  }

  [[nodiscard]] std::vector<mesh::PartPass> passes() const override { return {{.in_order = true, .normals = false}}; }

  Result<void> take(const mesh::MeshPart& part) override {
    TRY(write_waiting(part.positions));
    return waiting_.keep(part);
  }

  Result<void> finish(Notes& /*notes*/) override {
    TRY(write_waiting({}));
    return write_end(head_, options_, file_);
  }

 private:
  // Writes the triangles of the part that waits for the vertices in `next`.
  [[nodiscard]] Result<void> write_waiting(std::span<const glm::vec3> next) {
    return write_facets(
        waiting_.triangles().size(), options_.ascii,
        [&](std::size_t t) {
          const std::array corners = waiting_.corners(t, next);
          return Facet{face_normal(corners[0], corners[1], corners[2]), corners};
        },
        file_);
  }

  const mesh::Mesh& head_;
  MeshWriteOptions options_;
  files::OutputFile& file_;
  WaitingPart waiting_;
};

}  // namespace

std::unique_ptr<PartwiseWriter> make_partwise_stl_writer(const mesh::Mesh& head, const MeshWriteOptions& options,
                                                         const Context& context, files::OutputFile& file) {
  return std::make_unique<PartwiseStlWriter>(head, options, context, file);
}

Result<void> write_stl(const mesh::Mesh& mesh, const MeshWriteOptions& options, files::OutputFile& file, Notes& notes) {
  TRY(write_start(mesh, mesh.triangles.size(), options, file));
  if (auto note = precision_note(mesh)) notes.push_back(std::move(*note));
  TRY(with_world_positions(mesh, [&](auto position) {
    return write_facets(
        mesh.triangles.size(), options.ascii,
        [&](std::size_t t) {
          const glm::uvec3& triangle = mesh.triangles[t];
          return Facet{
              face_normal(mesh, triangle),
              {glm::vec3(position(triangle.x)), glm::vec3(position(triangle.y)), glm::vec3(position(triangle.z))}};
        },
        file);
  }));
  return write_end(mesh, options, file);
}

}  // namespace isoextract::mesh_io
