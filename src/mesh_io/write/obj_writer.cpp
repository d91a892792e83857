// Wavefront OBJ: text; indices start at 1 and count through the whole file.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include "base/version.hpp"
#include "files/record_stream.hpp"
#include "mesh_io/detail/placement_entry.hpp"
#include "mesh_io/write/mesh_encoding.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"
#include "mesh_io/write/partwise_writer.hpp"
#include "mesh_io/write/waiting_part.hpp"

namespace isoextract::mesh_io {
namespace {

// The first indices of the next mesh.
struct Next {
  std::uint64_t vertex = 1;
  std::uint64_t normal = 1;
};

// The distinct positions to write: vertices that are copies for different normals share one
// (MeshWriteOptions::has_vertex_copies_for_normals).
class Places {
 public:
  // Without copies each vertex has its own position. Allocates bytes(), which the caller reserves.
  Places(const mesh::Mesh& mesh, bool has_copies) : vertices_(mesh.positions.size()) {
    if (!has_copies || mesh.normals.empty()) return;
    std::vector<std::uint32_t> sorted(vertices_);
    std::iota(sorted.begin(), sorted.end(), 0U);
    const auto key = [&](std::uint32_t v) {
      const glm::vec3& p = mesh.positions[v];
      return std::tuple(p.x, p.y, p.z, v);
    };
    tbb::parallel_sort(sorted.begin(), sorted.end(), [&](auto a, auto b) { return key(a) < key(b); });
    number_.resize(vertices_);
    for (std::size_t first = 0, last = 0; first < vertices_; first = last) {
      while (last < vertices_ && mesh.positions[sorted[last]] == mesh.positions[sorted[first]]) ++last;
      join(mesh, std::span(sorted).subspan(first, last - first));
    }
    for (std::uint32_t v = 0; v < vertices_; ++v) {
      const bool is_own = number_[v] == v;
      number_[v] = is_own ? static_cast<std::uint32_t>(vertex_.size()) : number_[number_[v]];
      if (is_own) vertex_.push_back(v);
    }
  }

  static std::uint64_t bytes(const mesh::Mesh& mesh) { return 4 * mesh.positions.size() * sizeof(std::uint32_t); }

  [[nodiscard]] std::size_t size() const { return number_.empty() ? vertices_ : vertex_.size(); }
  // Returns the first vertex at a position.
  [[nodiscard]] std::size_t vertex_at(std::size_t place) const { return number_.empty() ? place : vertex_[place]; }
  [[nodiscard]] std::uint64_t of(std::uint64_t vertex) const { return number_.empty() ? vertex : number_[vertex]; }

 private:
  // Merges vertices of equal coordinates, given in ascending order. Each vertex joins the first earlier one that has no
  // copy with the same normal. Copies of one vertex differ in their normals, so equal normals belong to surfaces that
  // only touch here.
  void join(const mesh::Mesh& mesh, std::span<const std::uint32_t> same) {
    for (std::size_t i = 0; i < same.size(); ++i) {
      number_[same[i]] = same[i];
      for (std::size_t j = 0; j < i && number_[same[i]] == same[i]; ++j) {
        if (number_[same[j]] != same[j]) continue;
        const bool taken = std::ranges::any_of(same.first(i), [&](std::uint32_t other) {
          return number_[other] == same[j] && mesh.normals[other] == mesh.normals[same[i]];
        });
        if (!taken) number_[same[i]] = same[j];
      }
    }
  }

  std::size_t vertices_;
  std::vector<std::uint32_t> number_;  // the position of each vertex; empty if all are distinct
  std::vector<std::uint32_t> vertex_;  // the first vertex of each position
};

template <class Position>
Result<void> write_positions(std::size_t count, Position position, files::OutputFile& file) {
  constexpr std::size_t kLine = 2 + kMaxVectorText<typename decltype(position(0))::value_type>;
  return files::write_records(file, count, kLine, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t v = first; v < last; ++v) {
      *out++ = 'v';
      out = put_vector(out, position(v));
      *out++ = '\n';
    }
    return out;
  });
}

template <class Normal>
Result<void> write_normals(std::size_t count, Normal normal, files::OutputFile& file) {
  constexpr std::size_t kLine = 3 + kMaxVectorText<float>;
  return files::write_records(file, count, kLine, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t n = first; n < last; ++n) {
      out = put_text(out, "vn");
      out = put_vector(out, normal(n));
      *out++ = '\n';
    }
    return out;
  });
}

enum class Normals { none, of_vertices, of_faces };

// place_of(vertex) is the index of the vertex's position in its mesh.
template <class PlaceOf>
Result<void> write_faces(std::span<const glm::uvec3> triangles, PlaceOf place_of, Normals normals, const Next& next,
                         files::OutputFile& file) {
  constexpr std::size_t kCorner = 1 + kMaxNumberText<std::uint64_t> + 2 + kMaxNumberText<std::uint64_t>;
  constexpr std::size_t kLine = 1 + 3 * kCorner + 1;
  return files::write_records(file, triangles.size(), kLine, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t t = first; t < last; ++t) {
      *out++ = 'f';
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint64_t vertex = triangles[t][corner];
        *out++ = ' ';
        out = put_number(out, next.vertex + place_of(vertex));
        if (normals == Normals::none) continue;
        out = put_text(out, "//");
        out = put_number(out, next.normal + (normals == Normals::of_faces ? t : vertex));
      }
      *out++ = '\n';
    }
    return out;
  });
}

std::string header(const MeshWriteOptions& options) {
  std::string text = fmt::format("# {}\n", generator());
  if (!options.placement.empty()) text += fmt::format("# {} {}\n", kPlacementEntry, options.placement);
  return text;
}

// Returns the line with the name of a mesh; empty without a name.
std::string name_line(const mesh::Mesh& mesh) {
  return mesh.name.empty() ? std::string() : fmt::format("o {}\n", one_line(mesh.name));
}

class ObjWriter final : public FormatWriter {
 public:
  ObjWriter(const MeshWriteOptions& options, const Context& context, files::OutputFile& file)
      : flat_normals_(options.flat_normals),
        has_copies_(options.has_vertex_copies_for_normals),
        context_(context),
        file_(file),
        header_(header(options)) {}

  Result<void> add(const mesh::Mesh& mesh, Notes& /*notes*/) override {
    const auto memory = TRY(context_.reserve(has_copies_ ? Places::bytes(mesh) : 0, "the places of its vertices"));
    const Places places(mesh, has_copies_);
    const Normals normals = flat_normals_           ? Normals::of_faces
                            : !mesh.normals.empty() ? Normals::of_vertices
                                                    : Normals::none;
    const auto write_all_normals = [&]() -> Result<void> {
      if (normals == Normals::of_faces) {
        return write_normals(
            mesh.triangles.size(), [&](std::size_t t) { return face_normal(mesh, mesh.triangles[t]); }, file_);
      }
      return write_normals(
          mesh.normals.size(), [&](std::size_t v) { return mesh.normals[v]; }, file_);
    };
    auto written = write_header();
    if (written) written = file_.write(name_line(mesh));
    if (written) {
      written = with_world_positions(mesh, [&](auto position) {
        return write_positions(
            places.size(), [&](std::size_t v) { return position(places.vertex_at(v)); }, file_);
      });
    }
    if (written) written = write_all_normals();
    const auto place_of = [&](std::uint64_t vertex) { return places.of(vertex); };
    if (written) written = write_faces(mesh.triangles.span(), place_of, normals, next_, file_);
    next_.vertex += places.size();
    next_.normal += normals == Normals::of_faces ? mesh.triangles.size() : mesh.normals.size();
    return written;
  }

  Result<void> finish(Notes& /*notes*/) override { return write_header(); }

 private:
  // Writes the header before the first mesh; also if there is no mesh.
  Result<void> write_header() { return file_.write(std::exchange(header_, {})); }

  bool flat_normals_;
  bool has_copies_;
  Context context_;
  files::OutputFile& file_;
  std::string header_;
  Next next_;
};

// With face normals, a part waits for the next part, whose vertices its normals need.
class PartwiseObjWriter final : public PartwiseWriter {
 public:
  PartwiseObjWriter(const mesh::Mesh& head, const MeshWriteOptions& options, const Context& context,
                    files::OutputFile& file)
      : head_(head), options_(options), file_(file), waiting_(context, file.shown_name()) {}

  Result<bool> begin(const mesh::MeshShape& shape) override {
    if (shape.has_normals && options_.has_vertex_copies_for_normals) return false;
    normals_ = options_.flat_normals ? Normals::of_faces : shape.has_normals ? Normals::of_vertices : Normals::none;
    if (options_.flat_normals) TRY(waiting_.begin(shape));
    TRY(file_.write(header(options_) + name_line(head_)));
    return true;
  }

  [[nodiscard]] std::vector<mesh::PartPass> passes() const override {
    std::vector<mesh::PartPass> all{{.in_order = true, .normals = false, .triangles = false}};
    if (normals_ == Normals::of_vertices) all.push_back({.in_order = true, .positions = false, .triangles = false});
    if (normals_ == Normals::of_faces) all.push_back({.in_order = true, .normals = false});
    all.push_back({.in_order = true, .positions = false, .normals = false});
    return all;
  }

  Result<void> begin_pass(std::size_t pass) override {
    if (normals_ != Normals::of_faces) return {};
    writes_face_normals_ = pass == 1;
    return pass == 2 ? write_face_normals({}) : Result<void>();
  }

  Result<void> take(const mesh::MeshPart& part) override {
    if (writes_face_normals_) {
      TRY(write_face_normals(part.positions));
      return waiting_.keep(part);
    }
    TRY(write_positions(
        part.positions.size(), [&](std::size_t v) { return part.positions[v]; }, file_));
    TRY(write_normals(
        part.normals.size(), [&](std::size_t v) { return part.normals[v]; }, file_));
    Next next;
    if (normals_ == Normals::of_faces) next.normal += part.first_triangle;
    return write_faces(
        part.triangles, [](std::uint64_t vertex) { return vertex; }, normals_, next, file_);
  }

  Result<void> finish(Notes& /*notes*/) override { return {}; }

 private:
  // Writes the normals of the part that waits for the vertices in `next`.
  [[nodiscard]] Result<void> write_face_normals(std::span<const glm::vec3> next) {
    return write_normals(
        waiting_.triangles().size(),
        [&](std::size_t t) {
          const std::array corners = waiting_.corners(t, next);
          return face_normal(corners[0], corners[1], corners[2]);
        },
        file_);
  }

  const mesh::Mesh& head_;
  MeshWriteOptions options_;
  files::OutputFile& file_;
  WaitingPart waiting_;
  Normals normals_ = Normals::none;
  bool writes_face_normals_ = false;  // true in the second pass
};

}  // namespace

std::unique_ptr<PartwiseWriter> make_partwise_obj_writer(const mesh::Mesh& head, const MeshWriteOptions& options,
                                                         const Context& context, files::OutputFile& file) {
  return std::make_unique<PartwiseObjWriter>(head, options, context, file);
}

std::unique_ptr<FormatWriter> make_obj_writer(const MeshWriteOptions& options, const Context& context,
                                              files::OutputFile& file) {
  return std::make_unique<ObjWriter>(options, context, file);
}

}  // namespace isoextract::mesh_io
