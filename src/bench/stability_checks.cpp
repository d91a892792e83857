#include "bench/stability_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "accuracy/float_spacing.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/inside_test.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"

namespace isoextract::bench {
namespace {

using Real = long double;
using Vector = glm::vec<3, Real>;

class Checker {
 public:
  Checker(const mesh::Mesh& mesh, const field::ScalarField& field, const extract::ExtractOptions& options,
          const extract::MethodTraits& traits)
      : mesh_(mesh),
        field_(field),
        samples_(std::get<field::DenseSamples>(field.samples)),
        options_(options),
        traits_(traits),
        index_from_output_(glm::inverse(options.output_from_index.linear)),
        margin_(extract::OutputPlacement(options.output_from_index, {glm::ivec3(0), samples_.dims - 1}, field.kind,
                                         field.scale)
                    .margin()),
        whole_(0) {
    for (const glm::vec3& p : mesh.positions) {
      if (is_finite(p)) largest_ = glm::max(largest_, glm::abs(glm::dvec3(p)));
    }
    // The largest effect of float32 rounding on a coordinate, in voxels.
    for (int axis = 0; axis < 3; ++axis) {
      for (int c = 0; c < 3; ++c)
        whole_[axis] += std::abs(index_from_output_[c][axis]) * accuracy::float_spacing(largest_[c]);
      whole_[axis] += 1e-12 * samples_.dims[axis];
    }
  }

  [[nodiscard]] std::optional<GridEdge> edge(std::size_t vertex) const {
    const glm::vec3& local = mesh_.positions[vertex];
    constexpr double kCoarsest = 0.1;  // in voxels; a less exact position identifies no edge
    if (!is_finite(local) || std::max({whole_.x, whole_.y, whole_.z}) > kCoarsest) return std::nullopt;
    const Vector q = index_position(vertex);
    GridEdge edge;
    std::optional<Real> fraction;
    for (int axis = 0; axis < 3; ++axis) {
      const Real nearest = std::round(q[axis]);
      if (std::abs(q[axis] - nearest) <= whole_[axis]) {
        edge.low[axis] = static_cast<int>(nearest);
        continue;
      }
      const Real floor = std::floor(q[axis]);
      const Real own = q[axis] - floor;
      if (fraction && std::abs(*fraction - own) > 2 * std::max({whole_.x, whole_.y, whole_.z})) return std::nullopt;
      fraction = own;
      edge.low[axis] = static_cast<int>(floor);
      edge.step[axis] = 1;
    }
    if (traits_.axis_edges_only && edge.step.x + edge.step.y + edge.step.z > 1) return std::nullopt;
    return is_expected(edge) ? std::optional(edge) : std::nullopt;
  }

  [[nodiscard]] double value(const glm::ivec3& p) const {
    const auto at =
        static_cast<std::size_t>(p.x) +
        static_cast<std::size_t>(samples_.dims.x) *
            (static_cast<std::size_t>(p.y) + static_cast<std::size_t>(samples_.dims.y) * static_cast<std::size_t>(p.z));
    return field_.scale(visit_sample_type(samples_.type, [&]<class T>(std::type_identity<T>) {
      return static_cast<double>(static_cast<const T*>(samples_.data)[at]);
    }));
  }

  // Measures how far a vertex on `edge` is from its reference and its crossing.
  void compare(std::size_t vertex, const GridEdge& edge, StabilityFindings& findings) const {
    const bool on_cap = edge.step == glm::ivec3(0);
    const Real crossing = on_cap ? 0 : reference(edge);
    const Real kept = on_cap ? 0 : std::clamp<Real>(crossing, margin_, 1 - margin_);
    const auto index_of = [&](Real t) { return Vector(edge.low) + t * Vector(edge.step); };
    const Vector away = position(vertex) - placed(index_of(kept));
    const double unit = accuracy::float_spacing(std::max({largest_.x, largest_.y, largest_.z}));
    const Real farthest = std::max({std::abs(away.x), std::abs(away.y), std::abs(away.z)});
    findings.ulps = std::max(findings.ulps, static_cast<double>(farthest) / unit);
    const Vector in_voxels = index_position(vertex) - index_of(crossing);
    findings.voxels = std::max(findings.voxels, static_cast<double>(glm::length(in_voxels)));
  }

 private:
  // Returns the position relative to the frame's offset, which keeps precision in far frames.
  [[nodiscard]] Vector position(std::size_t vertex) const {
    return (Vector(mesh_.origin) - Vector(options_.output_from_index.offset)) + Vector(mesh_.positions[vertex]);
  }
  [[nodiscard]] Vector placed(const Vector& index) const {
    const glm::dmat3& m = options_.output_from_index.linear;
    return index.x * Vector(m[0]) + index.y * Vector(m[1]) + index.z * Vector(m[2]);
  }
  [[nodiscard]] Vector index_position(std::size_t vertex) const {
    const Vector p = position(vertex);
    const glm::dmat3& m = index_from_output_;
    return p.x * Vector(m[0]) + p.y * Vector(m[1]) + p.z * Vector(m[2]);
  }

  [[nodiscard]] bool is_expected(const GridEdge& edge) const {
    const glm::ivec3 high = edge.low + edge.step;
    const glm::ivec3 last = samples_.dims - 1;
    if (glm::any(glm::lessThan(edge.low, glm::ivec3(0))) || glm::any(glm::greaterThan(high, last))) return false;
    const extract::InsideRule inside{field_.kind, options_.iso};
    if (edge.step != glm::ivec3(0)) return inside(value(edge.low)) != inside(value(high));
    const bool on_boundary = glm::any(glm::equal(edge.low, glm::ivec3(0))) || glm::any(glm::equal(edge.low, last));
    return options_.cap && on_boundary && inside(value(edge.low));
  }

  [[nodiscard]] Real reference(const GridEdge& edge) const {
    const Real f0 = value(edge.low);
    const Real f1 = value(edge.low + edge.step);
    const bool finite0 = std::isfinite(f0);
    const bool finite1 = std::isfinite(f1);
    if (finite0 && finite1) return (static_cast<Real>(options_.iso) - f0) / (f1 - f0);
    if (finite0 == finite1 || std::isnan(f0) || std::isnan(f1)) return 0.5;
    return finite0 ? 0 : 1;
  }

  const mesh::Mesh& mesh_;
  const field::ScalarField& field_;
  const field::DenseSamples& samples_;
  const extract::ExtractOptions& options_;
  const extract::MethodTraits& traits_;
  glm::dmat3 index_from_output_;
  double margin_;
  glm::dvec3 largest_{0.0};  // largest absolute local coordinates of the mesh
  glm::dvec3 whole_;         // voxels; a coordinate this close to an integer counts as one
};

std::uint64_t repeated_triangles(const mesh::Mesh& mesh) {
  std::set<std::array<std::uint32_t, 3>> seen;
  for (const glm::uvec3& triangle : mesh.triangles) {
    std::array<std::uint32_t, 3> corners{triangle.x, triangle.y, triangle.z};
    std::sort(corners.begin(), corners.end());
    seen.insert(corners);
  }
  return mesh.triangles.size() - seen.size();
}

}  // namespace

void StabilityFindings::add(const StabilityFindings& other) {
  vertices += other.vertices;
  triangles += other.triangles;
  not_finite += other.not_finite;
  off_edge += other.off_edge;
  repeated += other.repeated;
  zero_area += other.zero_area;
  open_edges += other.open_edges;
  unsound += other.unsound;
  edges_checked = edges_checked && other.edges_checked;
  crossings_checked = crossings_checked && other.crossings_checked;
  ulps = std::max(ulps, other.ulps);
  voxels = std::max(voxels, other.voxels);
}

StabilityFindings empty_findings(const extract::MethodTraits& traits) {
  StabilityFindings findings;
  findings.edges_checked = traits.vertices_on_edges;
  findings.crossings_checked = traits.vertices_on_edges && traits.follows_interpolant;
  return findings;
}

std::vector<std::optional<GridEdge>> grid_edges(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                const extract::ExtractOptions& options,
                                                const extract::MethodTraits& traits) {
  const Checker checker(mesh, field, options, traits);
  std::vector<std::optional<GridEdge>> edges;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) edges.push_back(checker.edge(v));
  return edges;
}

StabilityFindings check_stability(const mesh::Mesh& mesh, const field::ScalarField& field,
                                  const extract::ExtractOptions& options, const extract::MethodTraits& traits) {
  StabilityFindings findings = empty_findings(traits);
  findings.vertices = mesh.positions.size();
  findings.triangles = mesh.triangles.size();
  if (mesh.positions.empty()) return findings;
  const Checker checker(mesh, field, options, traits);
  std::set<std::array<int, 6>> taken;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::vec3& p = mesh.positions[v];
    bool finite = is_finite(p);
    if (!mesh.normals.empty()) finite = finite && std::abs(glm::length(glm::dvec3(mesh.normals[v])) - 1) < 1e-5;
    if (!finite) {
      ++findings.not_finite;
      continue;
    }
    if (!findings.edges_checked) continue;
    const auto edge = checker.edge(v);
    if (!edge) {
      ++findings.off_edge;
      continue;
    }
    const bool is_new =
        taken.insert({edge->low.x, edge->low.y, edge->low.z, edge->step.x, edge->step.y, edge->step.z}).second;
    // A hole may split a vertex in two.
    if (!is_new && options.nan != extract::NanPolicy::hole) ++findings.repeated;
    if (findings.crossings_checked) checker.compare(v, *edge, findings);
  }
  const mesh::Topology topology = mesh::measure_topology(mesh);
  findings.repeated += repeated_triangles(mesh);
  findings.zero_area = mesh::measure_size(mesh).zero_area_triangles;
  findings.open_edges = topology.open_edges;
  findings.unsound = topology.nonmanifold_edges + topology.misoriented_edges + topology.nonmanifold_vertices +
                     topology.unused_vertices + topology.repeated_index_triangles;
  return findings;
}

std::vector<std::string> failures(const StabilityFindings& findings, bool must_be_closed, double ulps, double voxels) {
  std::vector<std::string> words;
  const auto count = [&](std::uint64_t number, std::string_view what) {
    if (number > 0) words.push_back(fmt::format("{} {}", number, what));
  };
  count(findings.not_finite, "vertices with coordinates that are not finite or normals not of length 1");
  count(findings.off_edge, "vertices outside their edge");
  count(findings.repeated, "duplicate vertices or triangles");
  count(findings.zero_area, "zero-area triangles");
  if (must_be_closed) count(findings.open_edges, "boundary edges");
  count(findings.unsound, "non-manifold, misoriented or unused elements");
  if (!(findings.ulps <= ulps))
    words.push_back(fmt::format("an error of {:.3g} ulps (limit {:.3g})", findings.ulps, ulps));
  if (!(findings.voxels <= voxels)) {
    words.push_back(fmt::format("an error of {:.3g} voxels (limit {:.3g})", findings.voxels, voxels));
  }
  return words;
}

}  // namespace isoextract::bench
