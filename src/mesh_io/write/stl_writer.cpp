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

// A triangle as the file has it.
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

// Writes what comes before the triangles. Fails if binary STL cannot hold as many.
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

// Writes what comes after the triangles.
Result<void> write_end(const mesh::Mesh& head, const MeshWriteOptions& options, files::OutputFile& file) {
  return options.ascii ? file.write(fmt::format("endsolid {}\n", solid_name(head))) : Result<void>();
}

// Triangles refer to vertices of the next part, so each part waits for the next one. Positions of far vertices are
// kept.
class PartwiseStlWriter final : public PartwiseWriter {
 public:
  PartwiseStlWriter(const mesh::Mesh& head, const MeshWriteOptions& options, const Context& context,
                    files::OutputFile& file)
      : head_(head), options_(options), context_(context), file_(file) {}

  Result<bool> begin(const mesh::MeshShape& shape) override {
    far_memory_ = TRY(reserve(shape.far_vertices.size() * (sizeof(std::uint32_t) + sizeof(glm::vec3))));
    far_ = shape.far_vertices;
    far_positions_.resize(far_.size());
    TRY(write_start(head_, shape.triangles, options_, file_));
    return true;
  }

  [[nodiscard]] std::vector<mesh::PartPass> passes() const override { return {{.in_order = true, .normals = false}}; }

  Result<void> take(const mesh::MeshPart& part) override {
    TRY(write_waiting(part.positions));
    // The vectors keep the room of their largest part; a larger part replaces it.
    const std::size_t vertices = std::max(part.positions.size(), positions_.capacity());
    const std::size_t triangles = std::max(part.triangles.size(), triangles_.capacity());
    const std::uint64_t bytes = vertices * sizeof(glm::vec3) + triangles * sizeof(glm::uvec3);
    if (bytes > memory_.bytes()) memory_.take(TRY(reserve(bytes - memory_.bytes())));
    if (vertices > positions_.capacity()) positions_ = {};
    if (triangles > triangles_.capacity()) triangles_ = {};
    first_vertex_ = part.first_vertex;
    positions_.assign(part.positions.begin(), part.positions.end());
    triangles_.assign(part.triangles.begin(), part.triangles.end());
    for (std::size_t f = far_place(first_vertex_); f < far_place(first_vertex_ + positions_.size()); ++f) {
      far_positions_[f] = positions_[far_[f] - first_vertex_];
    }
    return {};
  }

  Result<void> finish(Notes& /*notes*/) override {
    TRY(write_waiting({}));
    return write_end(head_, options_, file_);
  }

 private:
  [[nodiscard]] Result<Reservation> reserve(std::uint64_t bytes) const {
    return context_.reserve(bytes, file_.shown_name() + ": a part of the mesh");
  }

  // Returns the number of far vertices before a vertex.
  [[nodiscard]] std::size_t far_place(std::uint64_t vertex) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(far_, vertex) - far_.begin());
  }

  // Writes the triangles of the part that waits for the vertices in `next`.
  [[nodiscard]] Result<void> write_waiting(std::span<const glm::vec3> next) {
    const auto position = [&](std::uint32_t vertex) {
      if (vertex < first_vertex_) return far_positions_[far_place(vertex)];
      const std::uint64_t place = vertex - first_vertex_;
      return place < positions_.size() ? positions_[place] : next[place - positions_.size()];
    };
    return write_facets(
        triangles_.size(), options_.ascii,
        [&](std::size_t t) {
          const std::array corners{position(triangles_[t].x), position(triangles_[t].y), position(triangles_[t].z)};
          return Facet{face_normal(corners[0], corners[1], corners[2]), corners};
        },
        file_);
  }

  const mesh::Mesh& head_;
  MeshWriteOptions options_;
  Context context_;
  files::OutputFile& file_;
  Reservation far_memory_;
  std::vector<std::uint32_t> far_;  // vertices, ascending
  std::vector<glm::vec3> far_positions_;
  Reservation memory_;  // for the part that waits
  std::uint64_t first_vertex_ = 0;
  std::vector<glm::vec3> positions_;
  std::vector<glm::uvec3> triangles_;
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
