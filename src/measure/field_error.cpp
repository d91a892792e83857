#include "measure/field_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "extract/edge_geometry.hpp"
#include "extract/sparse_blocks.hpp"
#include "measure/quadrature.hpp"

namespace isoextract {
namespace {

constexpr std::size_t kGrain = 1 << 13;

using Range = tbb::blocked_range<std::size_t>;

// Looks for the isosurface from one point after the other. Like the cursor it holds: one a thread.
class SurfaceProbe {
 public:
  SurfaceProbe(const Interpolant& interpolant, const Affine& world_from_index, double iso, double reach)
      : field_(interpolant), world_from_index_(world_from_index), iso_(iso), reach_(reach) {
    const glm::dmat3 inverse = glm::inverse(world_from_index.linear);
    metric_ = inverse * glm::transpose(inverse);
  }

  void measure(const glm::dvec3& index, double weight, ErrorAccumulator& into) {
    const Interpolated here = field_(index);
    const double residual = here.value - iso_;
    const double largest = max_abs(here.gradient);
    if (!std::isfinite(residual) || !std::isfinite(largest)) {
      ++into.counts.not_finite;
      return;
    }
    const glm::dvec3 world = world_from_index_(index);
    if (residual == 0) return into.add({}, weight, world);
    std::optional<Length> found;
    double guess = std::numeric_limits<double>::infinity();  // voxels
    if (largest > 0) {
      // The direction in index space of the gradient in the world. The gradient is scaled first: squares of very large
      // or very small ones leave the range of double.
      const glm::dvec3 gradient = here.gradient / largest;
      const glm::dvec3 step = glm::normalize(metric_ * gradient) * (residual > 0 ? -1.0 : 1.0);
      guess = std::abs(residual / largest / glm::dot(gradient, step));
      if (const auto distance = search(index, step, residual, guess, reach_)) found = length_of(*distance * step);
    }
    if (!found || found->voxels > 2 * guess) look_at_corners(index, residual, found);
    if (!found) {
      ++(largest > 0 ? into.counts.unreached : into.counts.flat);
      return;
    }
    if (found->voxels < guess / 2 || found->voxels > 1.5 * guess) ++into.counts.corrected;
    into.add(*found, weight, world);
  }

 private:
  static double max_abs(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

  [[nodiscard]] Length length_of(const glm::dvec3& step) const {
    return {glm::length(step), glm::length(world_from_index_.linear * step)};
  }

  // On the way to a corner of the cell that is not on this side there is a crossing. Keeps the nearest.
  void look_at_corners(const glm::dvec3& index, double residual, std::optional<Length>& nearest) {
    const glm::dvec3 cell = glm::floor(index);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 way = cell + glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) - index;
      const double length = glm::length(way);
      const double value = field_(index + way).value - iso_;
      if (length == 0 || !std::isfinite(value) || (value != 0 && (value > 0) == (residual > 0))) continue;
      const auto distance = search(index, way / length, residual, length, length);
      const Length found = length_of(way * (distance.value_or(length) / length));
      if (!nearest || found.world < nearest->world) nearest = found;
    }
  }

  // The distance to the first change of sign from `index` along the unit vector `step`: just beyond the guess, or else
  // an eighth of the reach further, and so on. Nothing if there is none within `reach`, or a sample is not finite.
  std::optional<double> search(const glm::dvec3& index, const glm::dvec3& step, double residual, double guess,
                               double reach) {
    const auto at = [&](double s) { return field_(index + s * step).value - iso_; };
    double near = 0;
    double near_value = residual;
    double far = std::min(1.25 * guess, reach / 8);
    for (;;) {
      const double far_value = at(far);
      if (!std::isfinite(far_value)) return std::nullopt;
      if (far_value == 0 || (far_value > 0) != (residual > 0)) {
        return crossing(at, near, near_value, far, far_value, std::abs(residual));
      }
      if (far >= reach) return std::nullopt;
      near = far;
      near_value = far_value;
      far = std::min(far + reach / 8, reach);
    }
  }

  // The zero between a and b, by regula falsi with the Illinois rule (Dowell and Jarratt, BIT 11, 1971).
  template <class F>
  static double crossing(const F& at, double a, double value_a, double b, double value_b, double residual) {
    constexpr double kTolerance = 1e-9;
    for (int round = 0; round < 100; ++round) {
      const double c = b - value_b * ((b - a) / (value_b - value_a));
      if (!(c > std::min(a, b) && c < std::max(a, b))) return b;
      const double value_c = at(c);
      if (std::abs(value_c) <= kTolerance * residual || !std::isfinite(value_c)) return c;
      if ((value_c > 0) != (value_b > 0)) {
        a = b;
        value_a = value_b;
      } else {
        value_a /= 2;
      }
      b = c;
      value_b = value_c;
      if (std::abs(b - a) <= kTolerance * std::abs(b)) return b;
    }
    return b;
  }

  Interpolant::Cursor field_;
  const Affine& world_from_index_;
  glm::dmat3 metric_;  // from gradients in index space to index-space steps along the world's gradient
  double iso_;
  double reach_;
};

// Runs body(range, sums) over [0, count) and merges the sums in a fixed order.
template <class Sums, class Body>
Sums reduce(std::size_t count, const Sums& none, Progress* progress, const Body& body) {
  return tbb::parallel_deterministic_reduce(
      Range(0, count, kGrain), none,
      [&](const Range& range, Sums sums) {
        body(range, sums);
        if (progress != nullptr) progress->advance(range.size());
        return sums;
      },
      [](Sums a, const Sums& b) {
        a.merge(b);
        return a;
      });
}

struct TriangleSums {
  ErrorAccumulator interior;
  std::uint64_t cap_triangles = 0;

  void merge(const TriangleSums& other) {
    interior.merge(other.interior);
    cap_triangles += other.cap_triangles;
  }
};

struct VertexSums {
  ErrorAccumulator all;
  ErrorAccumulator storage;

  void merge(const VertexSums& other) {
    all.merge(other.all);
    storage.merge(other.storage);
  }
};

class FieldMeasurement {
 public:
  FieldMeasurement(const Mesh& mesh, const ScalarField& field, const ExtractOptions& extracted,
                   const FieldErrorOptions& options)
      : mesh_(mesh),
        extracted_(extracted),
        options_(options),
        chosen_(field, options.interpolation),
        trilinear_(field, Interpolation::trilinear),
        index_from_local_(glm::inverse(extracted.output_from_index.linear)),
        local_offset_(mesh.origin - extracted.output_from_index.offset),
        voxel_(std::cbrt(std::abs(extracted.output_from_index.determinant()))) {
    const auto* sparse = std::get_if<SparseSamples>(&field.samples);
    const IndexBox samples = sparse != nullptr ? stored_box(*sparse) : field.extents();
    // Half of what keeps vertices off the ends of their edges: closer than that only rounding brings them.
    tolerance_ = Placement(extracted.output_from_index, samples, field.kind, field.scale).margin() / 2;
    if (!extracted.cap) return;
    if (sparse == nullptr || extracted.region) cap_ = samples;
    if (extracted.region && cap_) {
      cap_ = sparse != nullptr
                 ? *extracted.region
                 : IndexBox{glm::max(samples.min, extracted.region->min), glm::min(samples.max, extracted.region->max)};
    }
  }

  FieldError run() {
    FieldError result;
    result.interpolation = options_.interpolation;
    if (options_.progress != nullptr) {
      options_.progress->begin("measuring the error", mesh_.triangles.size() + mesh_.positions.size());
    }
    const ErrorAccumulator none(voxel_);
    TriangleSums triangles = reduce(mesh_.triangles.size(), TriangleSums{none}, options_.progress,
                                    [&](const Range& range, TriangleSums& sums) { measure_triangles(range, sums); });
    result.interior = triangles.interior.result();
    result.cap_triangles = triangles.cap_triangles;
    if (result.cap_triangles > 0) find_surface_vertices();
    const VertexSums vertices = reduce(mesh_.positions.size(), VertexSums{none, none}, options_.progress,
                                       [&](const Range& range, VertexSums& sums) { measure_vertices(range, sums); });
    result.vertices = vertices.all.result();
    result.storage = vertices.storage.result();
    return result;
  }

 private:
  [[nodiscard]] SurfaceProbe probe(const Interpolant& interpolant) const {
    return {interpolant, extracted_.output_from_index, extracted_.iso, options_.reach};
  }

  // The two large numbers of a far-away frame are subtracted first.
  [[nodiscard]] glm::dvec3 index_of(std::uint32_t vertex) const {
    return index_from_local_ * (glm::dvec3(mesh_.positions[vertex]) + local_offset_);
  }

  // All corners in one face of the capped box.
  [[nodiscard]] bool is_cap(const std::array<glm::dvec3, 3>& corners) const {
    if (!cap_) return false;
    for (int axis = 0; axis < 3; ++axis) {
      for (const int face : {cap_->min[axis], cap_->max[axis]}) {
        if (std::ranges::all_of(corners, [&](const glm::dvec3& p) { return std::abs(p[axis] - face) < tolerance_; })) {
          return true;
        }
      }
    }
    return false;
  }

  [[nodiscard]] std::array<glm::dvec3, 3> corners_of(std::size_t triangle) const {
    const glm::uvec3 t = mesh_.triangles[triangle];
    return {index_of(t.x), index_of(t.y), index_of(t.z)};
  }

  void measure_triangles(const Range& range, TriangleSums& sums) const {
    SurfaceProbe surface = probe(chosen_);
    for (std::size_t t = range.begin(); t != range.end(); ++t) {
      const auto [a, b, c] = corners_of(t);
      if (is_cap({a, b, c})) {
        ++sums.cap_triangles;
        continue;
      }
      const glm::dmat3& linear = extracted_.output_from_index.linear;
      const double area = glm::length(glm::cross(linear * (b - a), linear * (c - a))) / 2;
      for (const auto& [weights, share] : kTrianglePoints) {
        surface.measure(weights.x * a + weights.y * b + weights.z * c, share * area, sums.interior);
      }
    }
  }

  void measure_vertices(const Range& range, VertexSums& sums) const {
    SurfaceProbe chosen = probe(chosen_);
    SurfaceProbe trilinear = probe(trilinear_);
    for (std::size_t v = range.begin(); v != range.end(); ++v) {
      if (!surface_vertices_.empty() && surface_vertices_[v] == 0) continue;
      const glm::dvec3 index = index_of(static_cast<std::uint32_t>(v));
      chosen.measure(index, 1, sums.all);
      if (on_axis_edge(index)) trilinear.measure(index, 1, sums.storage);
    }
  }

  [[nodiscard]] bool on_axis_edge(const glm::dvec3& index) const {
    int on_samples = 0;
    for (int axis = 0; axis < 3; ++axis) {
      on_samples += std::abs(index[axis] - std::round(index[axis])) < tolerance_ ? 1 : 0;
    }
    return on_samples >= 2;
  }

  // Those that only caps use stand on samples.
  void find_surface_vertices() {
    surface_vertices_.assign(mesh_.positions.size(), 0);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (is_cap(corners_of(t))) continue;
      for (int corner = 0; corner < 3; ++corner) surface_vertices_[mesh_.triangles[t][corner]] = 1;
    }
  }

  const Mesh& mesh_;
  const ExtractOptions& extracted_;
  const FieldErrorOptions& options_;
  Interpolant chosen_;
  Interpolant trilinear_;
  glm::dmat3 index_from_local_;
  glm::dvec3 local_offset_;
  double voxel_;
  double tolerance_ = 0;
  std::optional<IndexBox> cap_;
  std::vector<std::uint8_t> surface_vertices_;  // empty: all
};

}  // namespace

FieldError measure_field_error(const Mesh& mesh, const ScalarField& field, const ExtractOptions& extracted,
                               const FieldErrorOptions& options) {
  return FieldMeasurement(mesh, field, extracted, options).run();
}

}  // namespace isoextract
