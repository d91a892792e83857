#include "accuracy/field_error.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

#include <tbb/task_arena.h>

#include "accuracy/detail/brick_members.hpp"
#include "accuracy/detail/gradient_search.hpp"
#include "accuracy/detail/quadrature.hpp"
#include "accuracy/detail/subdivided_surface.hpp"
#include "accuracy/detail/surface_foot.hpp"
#include "accuracy/detail/surface_to_mesh.hpp"
#include "accuracy/index_mesh.hpp"
#include "base/reduction.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::accuracy {
namespace {

constexpr int kBrick = 16;            // cells along an axis
constexpr int kMargin = 2;            // cells around a brick that are searched, too
constexpr double kNearEnough = 1e-5;  // voxels; a point this near ends the search

// Maps the region of `grid` to samples of `field`: whole cells within it, or all cells that it touches.
field::IndexBox region_in_field(const field::IndexBox& region, const field::ScalarField& field,
                                const field::ScalarField& grid, bool whole_cells) {
  const field::Affine field_from_grid = field.index_to_file.inverse().after(grid.index_to_file);
  const field::Box box = field::image_of(field_from_grid, {glm::dvec3(region.min), glm::dvec3(region.max)});
  constexpr double kRounding = 1e-9;
  if (!whole_cells) return {glm::ivec3(glm::floor(box.min)), glm::ivec3(glm::ceil(box.max))};
  return {glm::ivec3(glm::ceil(box.min - kRounding)), glm::ivec3(glm::floor(box.max + kRounding))};
}

// Returns the least length of a one-voxel step in the mesh's coordinates.
double shortest_step(const glm::dmat3& linear) {
  // Power iteration finds the largest length that the inverse gives a unit vector.
  const glm::dmat3 inverse = glm::inverse(linear);
  const glm::dmat3 squared = glm::transpose(inverse) * inverse;
  glm::dvec3 v(0.6, 0.64, 0.48);
  for (int round = 0; round < 200; ++round) v = glm::normalize(squared * v);
  return 1 / glm::length(inverse * v);
}

// Small surfaces get finer parts: little cost, much accuracy.
int parts_for(std::size_t triangles) {
  if (triangles <= 10'000) return 4;
  return triangles <= 100'000 ? 3 : 2;
}

struct FieldSums {
  ErrorAccumulator interior;
  ErrorAccumulator vertices;
  ErrorAccumulator storage;
  SurfaceToMeshSums back;
  std::uint64_t cap_triangles = 0;

  void merge(const FieldSums& other) {
    interior.merge(other.interior);
    vertices.merge(other.vertices);
    storage.merge(other.storage);
    back.merge(other.back);
    cap_triangles += other.cap_triangles;
  }
};

// Returns the memory in use at a time, without both meshes and the bricks.
std::uint64_t working_bytes(std::uint64_t mesh_triangles, std::uint64_t mesh_vertices, std::uint64_t surface_triangles,
                            std::uint64_t surface_vertices) {
  return (mesh_triangles + mesh_vertices) * sizeof(BrickMember) + mesh_vertices +
         mesh::TriangleTree::bytes(mesh_triangles) + mesh::TriangleTree::bytes(surface_triangles) +
         coverage_bytes(surface_vertices, surface_triangles);
}

class FieldMeasurement {
 public:
  FieldMeasurement(const mesh::Mesh& mesh, const field::ScalarField& field, const extract::ExtractOptions& extracted,
                   const FieldErrorOptions& options, const Context& context)
      : mesh_(mesh),
        field_(field),
        extracted_(extracted),
        options_(options),
        context_(context),
        chosen_(field, options.interpolation, extracted.iso),
        trilinear_(field, field::Interpolation::trilinear, extracted.iso),
        placed_(mesh, field, extracted, options.grid),
        linear_(placed_.output_from_index().linear),
        index_from_step_(glm::inverse(linear_)) {
    placed_.add_caps(options.caps);
    if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) last_cell_ = dense->dims - 2;
    shortest_ = shortest_step(linear_);
    const glm::dmat3 rows = glm::transpose(index_from_step_);
    for (int axis = 0; axis < 3; ++axis) width_[axis] = 1 / glm::length(rows[axis]);
    for (int axis = 0; axis < 3; ++axis) diagonal_ += glm::length(linear_[axis]);
  }

  Result<FieldError> run() {
    TRY(extract_surface());
    parts_ = parts_for(surface_.triangles.size());
    const auto memory = TRY(context_.reserve(working_bytes(mesh_.triangles.size(), mesh_.positions.size(),
                                                           surface_.triangles.size(), surface_.positions.size()),
                                             "the error of the mesh"));
    if (!surface_.triangles.empty()) surface_tree_.emplace(surface_.positions.span(), surface_.triangles.span());
    if (!mesh_.triangles.empty()) mesh_tree_.emplace(mesh_.positions.span(), mesh_.triangles.span());
    list_bricks();
    const auto for_bricks = TRY(context_.reserve(bricks_bytes(), "the error of the mesh"));

    const ErrorAccumulator none(placed_.voxel());
    context_.progress().begin("measuring the error", bricks_.size());
    const FieldSums sums = reduce_in_order(
        bricks_.size(), FieldSums{none, none, none, {none, 0}, 0}, &context_.progress(),
        [&](const PointRange& range, FieldSums& into) {
          for (std::size_t b = range.begin(); b != range.end(); ++b) measure_brick(bricks_[b].brick, into);
        },
        1);
    if (error_) return tl::unexpected(std::move(*error_));
    TRY(context_.check());
    FieldError result = result_of(sums);
    if (result.coverage) {
      count_components(mesh_, surface_, surface_tree_ ? &*surface_tree_ : nullptr, options_.clipped, context_,
                       *result.coverage);
    }
    return result;
  }

 private:
  // One brick, its surface, and the searches in it.
  struct Brick {
    SubdividedSurface surface;
    field::IndexBox box;  // the samples of the surface's cells
    FieldFootFinder foot;
    GradientSearch search;
    std::uint32_t near = 0;        // slot of the last nearest triangle
    std::uint32_t near_whole = 0;  // the same for the surface in whole cells
  };

  // Returns the memory of all bricks measured at a time.
  [[nodiscard]] std::uint64_t bricks_bytes() const {
    std::uint64_t most = 0;
    for (const BrickCount& brick : bricks_) most = std::max(most, brick.triangles);
    int cells = kBrick + 2 * kMargin;
    if (last_cell_) cells = std::min(cells, std::max({last_cell_->x, last_cell_->y, last_cell_->z}) + 1);
    // With its margins a brick has at most twice its cells, and about twice its triangles.
    return bricks_.size() * sizeof(BrickCount) + static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency()) *
                                                     SubdividedSurface::bytes(cells, parts_, 2 * most);
  }

  // Extracts the isosurface of all samples, or of the region, in whole cells.
  Result<void> extract_surface() {
    extract::ExtractOptions options = extracted_;
    options.method = extract::Method::mc;
    options.cap = false;
    options.smooth_normals = false;
    options.edge_keys = false;
    options.output_from_index = placed_.output_from_index();
    counted_ = true;
    if (options_.grid != nullptr && extracted_.region) {
      options.region = region_in_field(*extracted_.region, field_, *options_.grid, true);
      counted_ = glm::all(glm::lessThan(options.region->min, options.region->max));
      if (!counted_) options.region = region_in_field(*extracted_.region, field_, *options_.grid, false);
    }
    region_ = options.region;
    auto extraction = TRY(extract::make_cpu_extractor()->extract(field_, options, context_));
    surface_ = std::move(extraction.mesh);
    return {};
  }

  [[nodiscard]] glm::ivec3 cell_of(const glm::dvec3& index) const {
    constexpr double kFarthest = field::kMaxSparseIndex;
    const glm::ivec3 cell(glm::floor(glm::clamp(index, glm::dvec3(-kFarthest), glm::dvec3(kFarthest))));
    return last_cell_ ? glm::clamp(cell, glm::ivec3(0), *last_cell_) : cell;
  }

  [[nodiscard]] static glm::ivec3 brick_of(const glm::ivec3& cell) {
    return glm::ivec3(glm::floor(glm::dvec3(cell) / static_cast<double>(kBrick)));
  }

  void list_bricks() {
    triangles_ = members_by_brick(mesh_.triangles.size(), [&](std::size_t t) {
      const auto corners = placed_.corners(t);
      return brick_of(cell_of((corners[0] + corners[1] + corners[2]) / 3.0));
    });
    surface_vertices_ = placed_.surface_vertices();
    vertices_ =
        members_by_brick(mesh_.positions.size(), [&](std::size_t v) { return brick_of(cell_of(placed_.vertex(v))); });
    std::size_t most = std::size_t{1} << 16;
    const auto add = [&](const glm::ivec3& brick, std::uint64_t triangles) {
      if (!bricks_.empty() && bricks_.back().brick == brick) {
        bricks_.back().triangles += triangles;
        return;
      }
      bricks_.push_back({brick, triangles});
      if (bricks_.size() < most) return;
      merge_bricks(bricks_);
      most = std::max(most, 2 * bricks_.size());
    };
    for (const auto* members : {&triangles_, &vertices_}) {
      for (const BrickMember& member : *members) add(member.brick, 0);
    }
    // A tricubic interpolant may cross iso also next to cells with samples on both sides.
    const int around = options_.interpolation == field::Interpolation::tricubic ? 1 : 0;
    const IndexMesh surface(surface_, field_, extracted_, options_.grid);
    for (std::size_t t = 0; counted_ && t < surface_.triangles.size(); ++t) {
      const auto corners = surface.corners(t);
      const glm::ivec3 cell = cell_of((corners[0] + corners[1] + corners[2]) / 3.0);
      const glm::ivec3 low = brick_of(cell - around);
      const glm::ivec3 high = brick_of(cell + around);
      for (int z = low.z; z <= high.z; ++z) {
        for (int y = low.y; y <= high.y; ++y) {
          for (int x = low.x; x <= high.x; ++x) add({x, y, z}, 1);
        }
      }
    }
    merge_bricks(bricks_);
  }

  void measure_brick(const glm::ivec3& at, FieldSums& sums) {
    if (context_.cancelled() || failed_) return;
    field::IndexBox cells{at * kBrick - kMargin, at * kBrick + (kBrick + kMargin - 1)};
    if (last_cell_) {
      cells = {glm::max(cells.min, glm::ivec3(0)), glm::min(cells.max, *last_cell_)};
      if (cells.empty()) return;
    }
    glm::dvec3 low(-std::numeric_limits<double>::infinity());
    glm::dvec3 high(std::numeric_limits<double>::infinity());
    if (last_cell_) {
      low = glm::dvec3(0);
      high = glm::dvec3(*last_cell_ + 1);
    }
    FieldFootFinder foot(field::Interpolant::Cursor(chosen_), 0, linear_, low, high);
    const Subdivision how{field_.kind, linear_, parts_};
    // Keeps this thread from starting another brick while it waits for its own loops: each brick holds memory.
    auto made = tbb::this_task_arena::isolate([&] { return SubdividedSurface::make(foot.function(), cells, how); });
    if (!made) {
      const std::scoped_lock lock(error_mutex_);
      if (!failed_.exchange(true)) error_ = std::move(made.error());
      return;
    }
    Brick brick{std::move(*made), {cells.min, cells.max + 1}, foot, search_in(chosen_)};
    tbb::this_task_arena::isolate([&] {
      for (const BrickMember& member : members_of(triangles_, at)) measure_triangle(member.id, brick, sums);
      measure_vertices(at, brick, sums);
      if (counted_ && mesh_tree_) measure_from_surface(at, brick, sums);
    });
  }

  [[nodiscard]] GradientSearch search_in(const field::Interpolant& interpolant) const {
    return {interpolant, field_, linear_, shortest_};
  }

  // Measures from `index` to the nearest isosurface point in the brick, and in all data if that may be nearer.
  void measure_point(const glm::dvec3& index, double weight, Brick& brick, ErrorAccumulator& into) const {
    if (placed_.is_outside(index)) {
      ++into.counts.outside;
      return;
    }
    const auto first = brick.search(index);
    if (!first) {
      ++into.counts.not_finite;
      return;
    }
    std::optional<glm::dvec3> step = first->step;
    const bool done = step && (first->is_nearest || glm::length(*step) <= kNearEnough);
    if (!done) search_in_brick(index, brick, step);
    if (!step || brick.foot.length(*step) > distance_inside(index, brick.box)) search_all_data(index, brick, step);
    if (!step) {
      ++into.counts.unreached;
      return;
    }
    const double voxels = glm::length(*step);
    if (voxels < first->guess / 2 || voxels > 1.5 * first->guess) ++into.counts.corrected;
    into.add({voxels, brick.foot.length(*step)}, weight, placed_.output_from_index()(index));
  }

  // Returns the distance of a point from the nearest face of `box`, leaving out faces on the data boundary.
  [[nodiscard]] double distance_inside(const glm::dvec3& index, const field::IndexBox& box) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (!last_cell_ || box.min[axis] > 0) nearest = std::min(nearest, (index[axis] - box.min[axis]) * width_[axis]);
      if (!last_cell_ || box.max[axis] <= (*last_cell_)[axis]) {
        nearest = std::min(nearest, (box.max[axis] - index[axis]) * width_[axis]);
      }
    }
    return nearest;
  }

  void search_in_brick(const glm::dvec3& index, Brick& brick, std::optional<glm::dvec3>& step) const {
    if (brick.surface.mesh().triangles.empty()) return;
    const auto found = brick.surface.tree().nearest(brick.surface.local(index), brick.near);
    brick.near = found.slot;
    keep_nearer_foot(index, brick.surface.index(found.point), diagonal_ / parts_, brick.foot, step);
  }

  void search_all_data(const glm::dvec3& index, Brick& brick, std::optional<glm::dvec3>& step) const {
    if (!surface_tree_) return;
    const field::Affine& output = placed_.output_from_index();
    const glm::dvec3 p = linear_ * index + (output.offset - surface_.origin);
    const auto found = surface_tree_->nearest(p, brick.near_whole);
    brick.near_whole = found.slot;
    keep_nearer_foot(index, index_from_step_ * (found.point - p) + index, diagonal_, brick.foot, step);
  }

  // Replaces `step` by the way to the foot of `index` found from `near`, if that is shorter.
  static void keep_nearer_foot(const glm::dvec3& index, const glm::dvec3& near, double reach, FieldFootFinder& foot,
                               std::optional<glm::dvec3>& step) {
    glm::dvec3 point = near;
    if (const auto landed = foot.land(near, reach)) point = foot.approach(index, *landed, reach);
    if (!step || foot.length(point - index) < foot.length(*step)) step = point - index;
  }

  void measure_triangle(std::size_t triangle, Brick& brick, FieldSums& sums) const {
    const auto corners = placed_.corners(triangle);
    if (placed_.is_cap(corners)) {
      ++sums.cap_triangles;
      return;
    }
    const double area = glm::length(placed_.area_vector(corners)) / 2;
    for_each_point(corners, kLongestSide, [&](const TrianglePoint& point) {
      measure_point(point.in(corners), point.share * area, brick, sums.interior);
    });
  }

  void measure_vertices(const glm::ivec3& at, Brick& brick, FieldSums& sums) const {
    const bool edges = options_.vertices_on_edges && options_.grid == nullptr;
    GradientSearch trilinear = search_in(trilinear_);
    for (const BrickMember& member : members_of(vertices_, at)) {
      if (surface_vertices_[member.id] == 0) continue;
      const glm::dvec3 index = placed_.vertex(member.id);
      measure_point(index, 1, brick, sums.vertices);
      if (!edges || !placed_.on_axis_edge(index)) continue;
      const auto stored = trilinear(index);
      if (!stored) {
        ++sums.storage.counts.not_finite;
      } else if (!stored->step) {
        ++sums.storage.counts.unreached;
      } else {
        sums.storage.add({glm::length(*stored->step), glm::length(linear_ * *stored->step)}, 1,
                         placed_.output_from_index()(index));
      }
    }
  }

  void measure_from_surface(const glm::ivec3& at, Brick& brick, FieldSums& sums) const {
    const SurfaceToMesh back(mesh_, *mesh_tree_, placed_, options_.clipped);
    const auto counts = [&](const glm::dvec3& center) {
      const glm::ivec3 cell = cell_of(center);
      return brick_of(cell) == at && (!region_ || (glm::all(glm::greaterThanEqual(cell, region_->min)) &&
                                                   glm::all(glm::lessThan(cell, region_->max))));
    };
    back.measure(brick.surface, brick.foot, diagonal_ / parts_, counts, sums.back);
  }

  [[nodiscard]] FieldError result_of(const FieldSums& sums) const {
    FieldError result;
    result.interpolation = options_.interpolation;
    result.parts = parts_;
    result.interior = sums.interior.result();
    result.vertices = sums.vertices.result();
    result.interior.include_max(result.vertices);
    result.storage = sums.storage.result();
    result.cap_triangles = sums.cap_triangles;
    if (!counted_) return result;
    SurfaceCoverage& coverage = result.coverage.emplace();
    coverage.distances = sums.back.distances.result();
    const double world = std::max(sums.back.at_most, coverage.distances.max.world);
    coverage.max_at_most = {std::max(world / shortest_, coverage.distances.max.voxels), world};
    return result;
  }

  const mesh::Mesh& mesh_;
  const field::ScalarField& field_;
  const extract::ExtractOptions& extracted_;
  const FieldErrorOptions& options_;
  const Context& context_;
  field::Interpolant chosen_;
  field::Interpolant trilinear_;
  IndexMesh placed_;
  glm::dmat3 linear_;
  glm::dmat3 index_from_step_;
  std::optional<glm::ivec3> last_cell_;  // dense data only
  glm::dvec3 width_{0.0};                // cell width between opposite faces, in the mesh's units
  double shortest_ = 0;                  // least length of a one-voxel step, in the mesh's units
  double diagonal_ = 0;                  // upper bound of the distance of two points of a cell
  int parts_ = 0;

  mesh::Mesh surface_;                     // the isosurface in whole cells
  std::optional<field::IndexBox> region_;  // the region it was extracted from
  bool counted_ = true;                    // whether coverage is measured in that region
  std::optional<mesh::TriangleTree> surface_tree_;
  std::optional<mesh::TriangleTree> mesh_tree_;
  std::vector<BrickMember> triangles_;
  std::vector<BrickMember> vertices_;
  std::vector<std::uint8_t> surface_vertices_;
  std::vector<BrickCount> bricks_;

  std::atomic<bool> failed_{false};
  std::mutex error_mutex_;
  std::optional<Error> error_;
};

// Returns the memory of the two interpolants.
std::uint64_t interpolants_bytes(const field::ScalarField& field) { return 2 * field::Interpolant::bytes(field); }

}  // namespace

Result<FieldError> measure_field_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                                       const extract::ExtractOptions& extracted, const FieldErrorOptions& options,
                                       const Context& context) {
  const auto memory = TRY(context.reserve(interpolants_bytes(field), "the error of the mesh"));
  return FieldMeasurement(mesh, field, extracted, options, context).run();
}

std::uint64_t field_error_bytes(const field::ScalarField& field, std::uint64_t mesh_triangles,
                                std::uint64_t surface_triangles) {
  const std::uint64_t surface_vertices = surface_triangles / 2;
  return interpolants_bytes(field) + surface_triangles * sizeof(glm::uvec3) + surface_vertices * sizeof(glm::vec3) +
         working_bytes(mesh_triangles, mesh_triangles / 2, surface_triangles, surface_vertices);
}

}  // namespace isoextract::accuracy
