#include "edit/half_space_clip.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "edit/detail/cut_cap.hpp"
#include "mesh/attributes.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::edit {
namespace {

constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

bool comes_before(const glm::vec3& p, const glm::vec3& q) { return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z); }

// Returns the key of an edge: its vertices, the smaller first.
std::uint64_t key_of(std::uint32_t a, std::uint32_t b) { return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b); }

class PlaneCut {
 public:
  PlaneCut(const mesh::Mesh& mesh, const mesh::HalfSpace& kept, const ClipOptions& options)
      : mesh_(mesh),
        kept_side_(kept),
        closing_(options.closing),
        on_plane_(mesh::on_plane_tolerance(mesh::farthest_coordinate(mesh.positions.span()))),
        snap_(std::max(options.snap, on_plane_)),
        depth_(mesh.positions.size()) {
    for_each_range(depth_.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        const double depth = kept.depth(mesh.position(v));
        depth_[v] = std::abs(depth) <= snap_ ? 0 : depth;
      }
    });
  }

  // Bytes for arrays beside the mesh, before the number of cut edges is known.
  [[nodiscard]] static std::uint64_t bytes(const mesh::Mesh& mesh) {
    return mesh.positions.size() * (sizeof(double) + sizeof(std::uint32_t));
  }

  [[nodiscard]] bool cuts() const {
    return std::ranges::any_of(depth_, [](double depth) { return depth < 0; });
  }

  // Counts the remaining triangles and numbers the vertices.
  void plan() {
    new_of_old_.assign(depth_.size(), kUnused);
    for (const glm::uvec3& t : mesh_.triangles) {
      const Polygon polygon = clip(t);
      if (polygon.size == 0) continue;
      triangles_ += polygon.size - 2;
      if (polygon.cut) ++cut_;
      for (std::size_t i = 0; i < polygon.size; ++i) {
        const Corner& corner = polygon.corners[i];
        if (corner.a == corner.b) {
          new_of_old_[corner.a] = 0;
        } else {
          edges_.push_back(key_of(corner.a, corner.b));
        }
      }
    }
    std::ranges::sort(edges_);
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
    for (std::uint32_t& number : new_of_old_) {
      if (number != kUnused) number = kept_++;
    }
  }

  [[nodiscard]] std::uint64_t cut() const { return cut_; }
  // Vertices within this distance count as on the plane, new ones included.
  [[nodiscard]] double on_plane() const { return on_plane_; }
  [[nodiscard]] std::uint64_t result_bytes() const {
    const std::uint64_t edge_key = mesh_.edges.empty() ? 0 : sizeof(mesh::EdgeKey);
    return (kept_ + edges_.size()) * (mesh::vertex_bytes(mesh_) - edge_key) + triangles_ * sizeof(glm::uvec3);
  }

  [[nodiscard]] mesh::Mesh make() const {
    mesh::Mesh result;
    result.name = mesh_.name;
    result.origin = mesh_.origin;
    result.material = mesh_.material;
    const std::size_t vertices = kept_ + edges_.size();
    result.positions = Buffer<glm::vec3>(vertices);
    if (!mesh_.normals.empty()) result.normals = Buffer<glm::vec3>(vertices);
    for (std::size_t v = 0; v < new_of_old_.size(); ++v) {
      if (new_of_old_[v] == kUnused) continue;
      result.positions[new_of_old_[v]] = depth_[v] == 0 ? snapped(v) : mesh_.positions[v];
      if (!mesh_.normals.empty()) result.normals[new_of_old_[v]] = mesh_.normals[v];
    }
    for (std::size_t e = 0; e < edges_.size(); ++e) put_crossing(edges_[e], kept_ + e, result);
    for (const mesh::Attribute& attribute : mesh_.attributes) result.attributes.push_back(clipped(attribute));
    result.triangles = Buffer<glm::uvec3>(triangles_);
    glm::uvec3* out = result.triangles.data();
    for (const glm::uvec3& t : mesh_.triangles) out = put_triangles(clip(t), result, out);
    return result;
  }

 private:
  // Returns the position of a vertex near the plane, moved onto it up to rounding.
  [[nodiscard]] glm::vec3 snapped(std::size_t v) const {
    const double depth = kept_side_.depth(mesh_.position(v));
    if (std::abs(depth) <= on_plane_) return mesh_.positions[v];
    return glm::dvec3(mesh_.positions[v]) - depth * kept_side_.normal;
  }

  // A vertex (a == b), or the crossing on the edge from a to b.
  struct Corner {
    std::uint32_t a, b;
  };
  struct Polygon {
    std::array<Corner, 4> corners{};
    std::size_t size = 0;
    bool cut = false;
  };

  [[nodiscard]] Polygon clip(const glm::uvec3& t) const {
    Polygon polygon;
    const glm::dvec3 depth(depth_[t.x], depth_[t.y], depth_[t.z]);
    const bool out = depth.x < 0 || depth.y < 0 || depth.z < 0;
    if (out && !(depth.x > 0 || depth.y > 0 || depth.z > 0)) return polygon;
    if (closing_ == CutClosing::capped && depth == glm::dvec3(0) && !faces_out(t)) return polygon;
    polygon.cut = out;
    for (int i = 0; i < 3; ++i) {
      const int next = i == 2 ? 0 : i + 1;
      if (depth[i] >= 0) polygon.corners[polygon.size++] = {t[i], t[i]};
      if ((depth[i] < 0 && depth[next] > 0) || (depth[i] > 0 && depth[next] < 0)) {
        polygon.corners[polygon.size++] = {t[i], t[next]};
      }
    }
    return polygon;
  }

  // Returns whether a triangle in the plane bounds a solid on the kept side.
  [[nodiscard]] bool faces_out(const glm::uvec3& t) const {
    const glm::dvec3 a(mesh_.positions[t.x]);
    const glm::dvec3 across = glm::cross(glm::dvec3(mesh_.positions[t.y]) - a, glm::dvec3(mesh_.positions[t.z]) - a);
    return glm::dot(across, kept_side_.normal) < 0;
  }

  [[nodiscard]] std::uint32_t number_of(const Corner& corner) const {
    if (corner.a == corner.b) return new_of_old_[corner.a];
    const auto found = std::ranges::lower_bound(edges_, key_of(corner.a, corner.b));
    return kept_ + static_cast<std::uint32_t>(found - edges_.begin());
  }

  [[nodiscard]] mesh::EdgePoint crossing_of(std::uint64_t edge) const {
    auto a = static_cast<std::uint32_t>(edge >> 32);
    auto b = static_cast<std::uint32_t>(edge & kUnused);
    // Orders ends by position, not by number: other meshes with this edge, and both sides of the plane, get the same
    // point.
    if (comes_before(mesh_.positions[b], mesh_.positions[a])) std::swap(a, b);
    return {a, b, depth_[a] / (depth_[a] - depth_[b])};
  }

  void put_crossing(std::uint64_t edge, std::size_t at, mesh::Mesh& result) const {
    const mesh::EdgePoint crossing = crossing_of(edge);
    const glm::dvec3 from(mesh_.positions[crossing.from]);
    result.positions[at] = glm::vec3(from + crossing.t * (glm::dvec3(mesh_.positions[crossing.to]) - from));
    if (!mesh_.normals.empty()) result.normals[at] = mesh::interpolated_normal(mesh_.normals, crossing);
  }

  [[nodiscard]] mesh::Attribute clipped(const mesh::Attribute& old) const {
    mesh::Attribute result = old.without_values();
    const std::size_t stride = old.stride();
    result.values = Buffer<std::byte>((kept_ + edges_.size()) * stride);
    for (std::size_t v = 0; v < new_of_old_.size(); ++v) {
      if (new_of_old_[v] != kUnused) std::ranges::copy(old.at(v), result.values.data() + new_of_old_[v] * stride);
    }
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      mesh::set_interpolated(result, kept_ + e, old, crossing_of(edges_[e]));
    }
    return result;
  }

  // Splits a quadrilateral along its shorter diagonal.
  glm::uvec3* put_triangles(const Polygon& polygon, const mesh::Mesh& result, glm::uvec3* out) const {
    if (polygon.size == 0) return out;
    std::array<std::uint32_t, 4> v{};
    for (std::size_t i = 0; i < polygon.size; ++i) v[i] = number_of(polygon.corners[i]);
    if (polygon.size == 3) {
      *out++ = {v[0], v[1], v[2]};
      return out;
    }
    const auto apart = [&](std::size_t i, std::size_t j) {
      return glm::length(result.positions[v[i]] - result.positions[v[j]]);
    };
    const std::size_t first = apart(1, 3) < apart(0, 2) ? 1 : 0;
    *out++ = {v[first], v[first + 1], v[first + 2]};
    *out++ = {v[first], v[first + 2], v[(first + 3) % 4]};
    return out;
  }

  const mesh::Mesh& mesh_;
  const mesh::HalfSpace& kept_side_;
  CutClosing closing_;
  double on_plane_;
  double snap_;
  std::vector<double> depth_;
  std::vector<std::uint32_t> new_of_old_;
  std::vector<std::uint64_t> edges_;  // edges that the plane cuts, sorted
  std::uint32_t kept_ = 0;
  std::uint64_t triangles_ = 0;
  std::uint64_t cut_ = 0;
};

}  // namespace

Result<ClipFigures> clip_to_half_spaces(mesh::Mesh& mesh, std::span<const mesh::HalfSpace> kept,
                                        const ClipOptions& options, const Context& context) {
  ClipFigures facts{mesh.triangles.size(), 0, 0, 0, 0};
  context.progress().begin("cutting the mesh", kept.size());
  for (const mesh::HalfSpace& half_space : kept) {
    TRY(context.check());
    const std::string what = "cutting the mesh at a clip plane";
    const auto working = TRY(context.reserve(PlaneCut::bytes(mesh), what));
    PlaneCut cut(mesh, half_space, options);
    if (cut.cuts()) {
      cut.plan();
      auto memory = TRY(context.reserve(cut.result_bytes(), what));
      facts.triangles_cut += cut.cut();
      mesh::Mesh result = cut.make();
      result.memory = std::move(memory);
      const double on_plane = cut.on_plane();
      mesh = std::move(result);
      if (options.closing == CutClosing::capped) {
        const auto cap = TRY(cap_cut(mesh, half_space, on_plane, context));
        facts.cap_triangles += cap.triangles;
        facts.overlapping_cap_triangles += cap.turned;
      }
    }
    context.progress().advance(1);
  }
  facts.triangles_after = mesh.triangles.size();
  return facts;
}

}  // namespace isoextract::edit
