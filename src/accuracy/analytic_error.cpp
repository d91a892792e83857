#include "accuracy/analytic_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "accuracy/detail/quadrature.hpp"
#include "accuracy/detail/surface_foot.hpp"
#include "accuracy/index_mesh.hpp"
#include "base/reduction.hpp"
#include "field/demo_field.hpp"
#include "mesh/metrics.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::accuracy {
namespace {

// The nearest point of the surface and the gradient there.
struct Foot {
  glm::dvec3 point{0.0};
  glm::dvec3 gradient{0.0};
  bool found = false;
};

// Returns the spacing of a formula's samples, in the formula's units.
double formula_spacing(const field::ScalarField& field) {
  return 2.0 / (std::get<field::DenseSamples>(field.samples).dims.x - 1);
}

// The surface of a formula in the cube [-1, 1]^3, as triangles.
class FormulaMesh {
 public:
  // Extracts the surface from the field's samples, or from more samples if the field has few.
  static Result<FormulaMesh> make(const field::AnalyticField& formula, const field::ScalarField& field, double iso,
                                  const Context& context) {
    constexpr int kCells = 128;
    const int cells = std::get<field::DenseSamples>(field.samples).dims.x - 1;
    const int parts = (kCells + cells / 2) / cells;
    const std::string name = fmt::format("{}{}?size={}", field::kDemoPrefix, formula.name, parts * cells + 1);
    if (parts <= 1) return of_samples(field, name, iso, context);
    const auto finer = TRY(field::make_demo_field(name, context));
    return of_samples(finer, name, iso, context);
  }

  [[nodiscard]] std::optional<glm::dvec3> nearest(const glm::dvec3& p, std::uint32_t& hint) const {
    if (!tree_) return std::nullopt;
    const mesh::TriangleTree::Nearest found = tree_->nearest(p - origin_, hint);
    hint = found.slot;
    return found.point + origin_;
  }
  [[nodiscard]] double spacing() const { return spacing_; }

 private:
  static Result<FormulaMesh> of_samples(const field::ScalarField& field, const std::string& name, double iso,
                                        const Context& context) {
    FormulaMesh made;
    made.spacing_ = formula_spacing(field);
    extract::ExtractOptions options;
    options.iso = iso;
    options.output_from_index = {glm::dmat3(made.spacing_), glm::dvec3(-1)};
    auto extraction = TRY(extract::make_cpu_extractor()->extract(field, options, context));
    const mesh::Mesh& mesh = extraction.mesh;
    if (mesh.triangles.empty()) return made;
    made.memory_ =
        TRY(context.reserve(mesh::TriangleTree::bytes(mesh.triangles.size()), name + ": the surface of its formula"));
    made.origin_ = mesh.origin;
    made.tree_.emplace(mesh.positions.span(), mesh.triangles.span());
    return made;
  }

  Reservation memory_;
  glm::dvec3 origin_{0.0};
  double spacing_ = 0;
  std::optional<mesh::TriangleTree> tree_;
};

class ClosestPoint {
 public:
  // `mesh` is null if distances are known in closed form.
  ClosestPoint(const field::AnalyticField& field, double iso, const FormulaMesh* mesh)
      : field_(field), iso_(iso), mesh_(mesh) {}

  // `hint` is input and output: pass on the value of the last call, if possible for a near point.
  [[nodiscard]] Foot operator()(const glm::dvec3& p, std::uint32_t& hint) const {
    const auto near = mesh_ != nullptr ? mesh_->nearest(p, hint) : std::nullopt;
    if (!near) return iterate(p, p);
    const auto at = [&](const glm::dvec3& q) { return field_.value_and_gradient(q); };
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    FootFinder on_surface(at, iso_, glm::dmat3(1.0), glm::dvec3(-kInfinity), glm::dvec3(kInfinity));
    const double reach = 2 * mesh_->spacing();
    Foot foot;
    glm::dvec3 start = *near;
    if (const auto landed = on_surface.land(*near, reach)) {
      start = on_surface.approach(p, *landed, reach);
      foot = {start, field_.value_and_gradient(start).gradient, true};
    }
    take(p, iterate(p, start), foot);
    return foot;
  }

 private:
  static void take(const glm::dvec3& p, const Foot& other, Foot& foot) {
    if (other.found && (!foot.found || glm::length(other.point - p) < glm::length(foot.point - p))) foot = other;
  }

  // Replaces a guess q by the foot of p on the plane where the linear approximation at q has the iso value. Fixed
  // point: q is on the surface and p - q is normal to the surface. Converges by the factor |p - q| / radius of
  // curvature a step.
  [[nodiscard]] Foot iterate(const glm::dvec3& p, glm::dvec3 q) const {
    constexpr int kMaxSteps = 50;
    constexpr double kTolerance = 1e-10;
    for (int step = 0; step < kMaxSteps; ++step) {
      const field::Dual here = field_.value_and_gradient(q);
      const double squared = glm::dot(here.gradient, here.gradient);
      if (!(squared > 0)) return {};
      const double residual = here.value - iso_ + glm::dot(here.gradient, p - q);
      const glm::dvec3 next = p - here.gradient * (residual / squared);
      const double moved = glm::length(next - q);
      q = next;
      if (mesh_ == nullptr || moved <= kTolerance) return {q, here.gradient, true};
    }
    return {};
  }

  const field::AnalyticField& field_;
  double iso_;
  const FormulaMesh* mesh_;
};

class AngleAccumulator {
 public:
  void add(const glm::dvec3& a, const glm::dvec3& b, double weight) {
    const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
    ++points_;
    weight_ += weight;
    squares_ += weight * angle * angle;
    max_ = std::max(max_, angle);
  }
  void merge(const AngleAccumulator& other) {
    points_ += other.points_;
    weight_ += other.weight_;
    squares_ += other.squares_;
    max_ = std::max(max_, other.max_);
  }
  [[nodiscard]] AngleStatistics result() const {
    constexpr double kDegrees = 180 / std::numbers::pi;
    return {points_, weight_ > 0 ? kDegrees * std::sqrt(squares_ / weight_) : 0, kDegrees * max_};
  }

 private:
  std::uint64_t points_ = 0;
  double weight_ = 0;
  double squares_ = 0;
  double max_ = 0;
};

struct FormulaSums {
  ErrorAccumulator distance;
  AngleAccumulator smooth;
  AngleAccumulator flat;
  double area = 0;
  std::uint64_t cap_triangles = 0;

  void merge(const FormulaSums& other) {
    distance.merge(other.distance);
    smooth.merge(other.smooth);
    flat.merge(other.flat);
    area += other.area;
    cap_triangles += other.cap_triangles;
  }
};

// Returns whether the map is a rotation or reflection times a scale, up to rounding.
bool is_similarity(const glm::dmat3& linear) {
  const glm::dmat3 product = glm::transpose(linear) * linear;
  const double square = (product[0][0] + product[1][1] + product[2][2]) / 3;
  const glm::dmat3 rest = product - glm::dmat3(square);
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (std::abs(rest[column][row]) > 1e-9 * square) return false;
    }
  }
  return true;
}

class AnalyticMeasurement {
 public:
  // `placed` is `mesh` in the index space of `field`.
  AnalyticMeasurement(const mesh::Mesh& mesh, const IndexMesh& placed, const field::ScalarField& field,
                      const extract::ExtractOptions& extracted, const field::AnalyticField& formula,
                      const FormulaMesh* formula_mesh, const Context& context)
      : mesh_(mesh),
        extracted_(extracted),
        context_(context),
        placed_(placed),
        closest_(formula, extracted.iso, formula_mesh),
        closed_form_(formula_mesh == nullptr),
        step_(formula_spacing(field)),
        unit_(placed_.voxel() / step_),
        // Gradients are covectors; for a similarity the inverse transpose is the map itself up to scale.
        normal_map_((field.kind == field::FieldKind::density ? -1.0 : 1.0) / placed_.voxel() *
                    placed_.output_from_index().linear) {}

  AnalyticError run() {
    AnalyticError result;
    result.closed_form = closed_form_;
    result.unit = unit_;
    context_.progress().begin("measuring the true error", mesh_.triangles.size() + mesh_.positions.size());
    const ErrorAccumulator none(placed_.voxel());
    const auto triangles =
        reduce_in_order(mesh_.triangles.size(), FormulaSums{none, {}, {}}, &context_.progress(),
                        [&](const PointRange& range, FormulaSums& sums) { measure_triangles(range, sums); });
    result.interior = triangles.distance.result();
    result.smooth_normals = triangles.smooth.result();
    result.flat_normals = triangles.flat.result();
    result.area = triangles.area;
    result.cap_triangles = triangles.cap_triangles;
    const std::vector<std::uint8_t> used = placed_.surface_vertices();
    result.vertices = reduce_in_order(mesh_.positions.size(), none, &context_.progress(),
                                      [&](const PointRange& range, ErrorAccumulator& sums) {
                                        std::uint32_t hint = 0;
                                        for (std::size_t v = range.begin(); v != range.end(); ++v) {
                                          if (used[v] != 0) measure_point(placed_.vertex(v), 1, hint, sums);
                                        }
                                      })
                          .result();
    result.interior.include_max(result.vertices);
    if (!extracted_.region && (extracted_.cap || result.closed_form)) result.volume = mesh::measure_size(mesh_).volume;
    return result;
  }

 private:
  // Adds the distance of a point in index space. Returns the true outward normal at its foot, zero if there is none.
  glm::dvec3 measure_point(const glm::dvec3& index, double weight, std::uint32_t& hint, ErrorAccumulator& sums) const {
    if (placed_.is_outside(index)) {
      ++sums.counts.outside;
      return glm::dvec3(0);
    }
    const glm::dvec3 p = step_ * index - 1.0;
    const Foot foot = closest_(p, hint);
    if (!foot.found) {
      ++sums.counts.unreached;
      return glm::dvec3(0);
    }
    const double distance = glm::length(foot.point - p);
    sums.add({distance / step_, distance * unit_}, weight, placed_.output_from_index()(index));
    return glm::normalize(normal_map_ * foot.gradient);
  }

  void measure_triangles(const PointRange& range, FormulaSums& sums) const {
    std::uint32_t hint = 0;
    for (std::size_t t = range.begin(); t != range.end(); ++t) {
      const auto corners = placed_.corners(t);
      if (placed_.is_cap(corners)) {
        ++sums.cap_triangles;
        continue;
      }
      const glm::uvec3 triangle = mesh_.triangles[t];
      const glm::dvec3 along = placed_.area_vector(corners);
      const double area = glm::length(along) / 2;
      sums.area += area;
      for_each_point(corners, kLongestSide, [&](const TrianglePoint& point) {
        const glm::dvec3 normal = measure_point(point.in(corners), point.share * area, hint, sums.distance);
        if (normal == glm::dvec3(0)) return;
        if (area > 0) sums.flat.add(along, normal, point.share * area);
        if (mesh_.normals.empty()) return;
        const glm::dvec3 smooth =
            point.in({glm::dvec3(mesh_.normals[triangle.x]), glm::dvec3(mesh_.normals[triangle.y]),
                      glm::dvec3(mesh_.normals[triangle.z])});
        sums.smooth.add(smooth, normal, point.share * area);
      });
    }
  }

  const mesh::Mesh& mesh_;
  const extract::ExtractOptions& extracted_;
  const Context& context_;
  const IndexMesh& placed_;
  ClosestPoint closest_;
  bool closed_form_;
  double step_;  // spacing of the samples, in the formula's units
  double unit_;
  glm::dmat3 normal_map_;
};

}  // namespace

Result<std::optional<AnalyticError>> measure_analytic_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                            const extract::ExtractOptions& extracted,
                                                            const field::ScalarField* grid, const CapPlanes& caps,
                                                            const Context& context) {
  const field::AnalyticField* formula = field::find_formula(field);
  if (formula == nullptr) return std::nullopt;
  IndexMesh placed(mesh, field, extracted, grid);
  placed.add_caps(caps);
  if (!is_similarity(placed.output_from_index().linear)) return std::nullopt;
  std::optional<FormulaMesh> formula_mesh;
  if (!formula->is_distance || !formula->size(extracted.iso)) {
    formula_mesh = TRY(FormulaMesh::make(*formula, field, extracted.iso, context));
  }
  return AnalyticMeasurement(mesh, placed, field, extracted, *formula, formula_mesh ? &*formula_mesh : nullptr, context)
      .run();
}

}  // namespace isoextract::accuracy
