#include "measure/field_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "measure/detail/crossing.hpp"
#include "measure/detail/index_mesh.hpp"
#include "measure/detail/quadrature.hpp"
#include "measure/detail/reduction.hpp"

namespace isoextract::measure {
namespace {

// Looks for the isosurface from one point after the other. Like the cursor it holds: one a thread.
class SurfaceProbe {
 public:
  // `rounding`: how far out of the data a point may be, in voxels.
  SurfaceProbe(const field::Interpolant& interpolant, const field::ScalarField& field, double rounding,
               const field::Affine& world_from_index, double iso, double reach)
      : field_(interpolant), world_from_index_(world_from_index), iso_(iso), reach_(reach) {
    if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
      last_cell_ = dense->dims - 2;
      low_ = glm::dvec3(-rounding);
      high_ = glm::dvec3(dense->dims - 1) + rounding;
    }
    const glm::dmat3 inverse = glm::inverse(world_from_index.linear);
    metric_ = inverse * glm::transpose(inverse);
  }

  void measure(const glm::dvec3& index, double weight, ErrorAccumulator& into) {
    const field::Interpolated here = field_(index);
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
      found = search_in_data(index, step, residual, guess);
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
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  static double max_abs(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

  [[nodiscard]] Length length_of(const glm::dvec3& step) const {
    return {glm::length(step), glm::length(world_from_index_.linear * step)};
  }

  [[nodiscard]] bool in_data(const glm::dvec3& index) const {
    return glm::all(glm::greaterThanEqual(index, low_)) && glm::all(glm::lessThanEqual(index, high_));
  }

  // How far along `step` the faces of the data are, the nearest of those that it leads to.
  [[nodiscard]] double way_out(const glm::dvec3& index, const glm::dvec3& step) const {
    double nearest = kInfinity;
    for (int axis = 0; axis < 3; ++axis) {
      if (step[axis] == 0) continue;
      nearest = std::min(nearest, ((step[axis] > 0 ? high_ : low_)[axis] - index[axis]) / step[axis]);
    }
    return std::max(nearest, 0.0);
  }

  // Along `step`, and where that leaves the data before the surface, along the face from there.
  std::optional<Length> search_in_data(const glm::dvec3& index, const glm::dvec3& step, double residual, double guess) {
    const double out = way_out(index, step);
    const bool from_inside = in_data(index);
    if (const auto distance = search(index, step, residual, guess, reach_, std::min(reach_, out))) {
      if (from_inside || in_data(index + *distance * step)) return length_of(*distance * step);
      return std::nullopt;
    }
    if (!from_inside || out >= reach_) return std::nullopt;
    const glm::dvec3 border = glm::clamp(index + out * step, low_, high_);
    glm::dvec3 slide = step;
    for (int axis = 0; axis < 3; ++axis) {
      if (step[axis] > 0 ? border[axis] == high_[axis] : border[axis] == low_[axis]) {
        slide[axis] = 0;
      }
    }
    const double length = glm::length(slide);
    if (!(length > 0)) return std::nullopt;
    slide /= length;
    const double limit = std::min(reach_ - out, way_out(border, slide));
    const auto distance = search(border, slide, residual, guess, reach_, limit);
    return distance ? std::optional(length_of(border + *distance * slide - index)) : std::nullopt;
  }

  // On the way to a corner of the cell that is not on this side there is a crossing. Keeps the nearest.
  void look_at_corners(const glm::dvec3& index, double residual, std::optional<Length>& nearest) {
    glm::dvec3 cell = glm::floor(index);
    if (last_cell_) cell = glm::clamp(cell, glm::dvec3(0), glm::dvec3(*last_cell_));
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 way = cell + glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) - index;
      const double length = glm::length(way);
      const double value = field_(index + way).value - iso_;
      if (length == 0 || !std::isfinite(value) || (value != 0 && (value > 0) == (residual > 0))) continue;
      const auto distance = search(index, way / length, residual, length, length, length);
      if (!in_data(index) && !in_data(index + way * (distance.value_or(length) / length))) continue;
      const Length found = length_of(way * (distance.value_or(length) / length));
      if (!nearest || found.world < nearest->world) nearest = found;
    }
  }

  // The distance to the first change of sign from `index` along the unit vector `step`: just beyond the guess, or else
  // an eighth of the reach further, and so on. Nothing if there is none within `limit`, or a sample is not finite.
  std::optional<double> search(const glm::dvec3& index, const glm::dvec3& step, double residual, double guess,
                               double reach, double limit) {
    const auto at = [&](double s) { return field_(index + s * step).value - iso_; };
    double near = 0;
    double near_value = residual;
    double far = std::min({1.25 * guess, reach / 8, limit});
    for (;;) {
      const double far_value = at(far);
      if (!std::isfinite(far_value)) return std::nullopt;
      if (far_value == 0 || (far_value > 0) != (residual > 0)) {
        return find_crossing(at, near, near_value, far, far_value, 1e-9 * std::abs(residual));
      }
      if (far >= limit) return std::nullopt;
      near = far;
      near_value = far_value;
      far = std::min(far + reach / 8, limit);
    }
  }

  field::Interpolant::Cursor field_;
  const field::Affine& world_from_index_;
  glm::dmat3 metric_;  // from gradients in index space to index-space steps along the world's gradient
  double iso_;
  double reach_;
  std::optional<glm::ivec3> last_cell_;  // dense data only; sparse data have no border
  glm::dvec3 low_{-kInfinity};
  glm::dvec3 high_{kInfinity};
};

struct InteriorSums {
  ErrorAccumulator interior;
  std::uint64_t cap_triangles = 0;

  void merge(const InteriorSums& other) {
    interior.merge(other.interior);
    cap_triangles += other.cap_triangles;
  }
};

struct VertexErrorSums {
  ErrorAccumulator all;
  ErrorAccumulator storage;

  void merge(const VertexErrorSums& other) {
    all.merge(other.all);
    storage.merge(other.storage);
  }
};

class FieldMeasurement {
 public:
  FieldMeasurement(const mesh::Mesh& mesh, const field::ScalarField& field, const extract::ExtractOptions& extracted,
                   const FieldErrorOptions& options, const Context& context)
      : mesh_(mesh),
        field_(field),
        extracted_(extracted),
        options_(options),
        context_(context),
        chosen_(field, options.interpolation),
        trilinear_(field, field::Interpolation::trilinear),
        placed_(mesh, field, extracted, options.grid) {
    placed_.add_capped_cuts(options.cuts);
  }

  FieldError run() {
    FieldError result;
    result.interpolation = options_.interpolation;
    context_.progress().begin("measuring the error", mesh_.triangles.size() + mesh_.positions.size());
    const ErrorAccumulator none(placed_.voxel());
    const auto triangles =
        reduce_in_order(mesh_.triangles.size(), InteriorSums{none}, &context_.progress(),
                        [&](const PointRange& range, InteriorSums& sums) { measure_triangles(range, sums); });
    result.interior = triangles.interior.result();
    result.cap_triangles = triangles.cap_triangles;
    surface_vertices_ = placed_.surface_vertices();
    const auto vertices =
        reduce_in_order(mesh_.positions.size(), VertexErrorSums{none, none}, &context_.progress(),
                        [&](const PointRange& range, VertexErrorSums& sums) { measure_vertices(range, sums); });
    result.vertices = vertices.all.result();
    result.storage = vertices.storage.result();
    return result;
  }

 private:
  [[nodiscard]] SurfaceProbe probe(const field::Interpolant& interpolant) const {
    return {interpolant, field_, placed_.tolerance(), placed_.output_from_index(), extracted_.iso, options_.reach};
  }

  void measure_triangles(const PointRange& range, InteriorSums& sums) const {
    SurfaceProbe surface = probe(chosen_);
    for (std::size_t t = range.begin(); t != range.end(); ++t) {
      const auto corners = placed_.corners(t);
      if (placed_.is_cap(corners)) {
        ++sums.cap_triangles;
        continue;
      }
      const double area = glm::length(placed_.area_vector(corners)) / 2;
      for (const TrianglePoint& point : kTrianglePoints) {
        surface.measure(point.in(corners), point.share * area, sums.interior);
      }
    }
  }

  void measure_vertices(const PointRange& range, VertexErrorSums& sums) const {
    const bool edges = options_.vertices_on_edges && options_.grid == nullptr;
    SurfaceProbe chosen = probe(chosen_);
    SurfaceProbe trilinear = probe(trilinear_);
    for (std::size_t v = range.begin(); v != range.end(); ++v) {
      if (surface_vertices_[v] == 0) continue;
      const glm::dvec3 index = placed_.vertex(v);
      chosen.measure(index, 1, sums.all);
      if (edges && placed_.on_axis_edge(index)) trilinear.measure(index, 1, sums.storage);
    }
  }

  const mesh::Mesh& mesh_;
  const field::ScalarField& field_;
  const extract::ExtractOptions& extracted_;
  const FieldErrorOptions& options_;
  const Context& context_;
  field::Interpolant chosen_;
  field::Interpolant trilinear_;
  IndexMesh placed_;
  std::vector<std::uint8_t> surface_vertices_;
};

}  // namespace

FieldError measure_field_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                               const extract::ExtractOptions& extracted, const FieldErrorOptions& options,
                               const Context& context) {
  return FieldMeasurement(mesh, field, extracted, options, context).run();
}

}  // namespace isoextract::measure
