#include "accuracy/detail/window_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <tbb/task_arena.h>

#include "accuracy/detail/quadrature.hpp"
#include "accuracy/detail/surface_components.hpp"
#include "base/reduction.hpp"

namespace isoextract::accuracy {
namespace {

constexpr int kBrickMargin = 2;          // cells around a brick that are searched, too
constexpr double kNearEnough = 1e-5;     // voxels; a point this near ends the search
constexpr double kPointRounding = 1e-6;  // voxels; rounding moves the points of a triangle less

// Returns the least length of a one-voxel step in the mesh's coordinates.
double shortest_step(const glm::dmat3& linear) {
  // Power iteration finds the largest length that the inverse gives a unit vector.
  const glm::dmat3 inverse = glm::inverse(linear);
  const glm::dmat3 squared = glm::transpose(inverse) * inverse;
  glm::dvec3 v(0.6, 0.64, 0.48);
  for (int round = 0; round < 200; ++round) v = glm::normalize(squared * v);
  return 1 / glm::length(inverse * v);
}

}  // namespace

ErrorReference::ErrorReference(const field::ScalarField& of_field, const extract::ExtractOptions& of_mesh,
                               const FieldErrorOptions& how, const field::Affine& placement)
    : field(of_field),
      extracted(of_mesh),
      options(how),
      output_from_index(placement),
      chosen(of_field, how.interpolation, of_mesh.iso),
      trilinear(of_field, field::Interpolation::trilinear, of_mesh.iso),
      cells(of_field),
      shortest(shortest_step(placement.linear)),
      voxel(std::cbrt(std::abs(placement.determinant()))) {
  const glm::dmat3 rows = glm::transpose(glm::inverse(placement.linear));
  for (int axis = 0; axis < 3; ++axis) width[axis] = 1 / glm::length(rows[axis]);
  for (int axis = 0; axis < 3; ++axis) diagonal += glm::length(placement.linear[axis]);
}

void FieldSums::merge(const FieldSums& other) {
  interior.merge(other.interior);
  vertices.merge(other.vertices);
  storage.merge(other.storage);
  back.merge(other.back);
  cap_triangles += other.cap_triangles;
  needed = std::max(needed, other.needed);
}

FieldSums no_sums(const ErrorReference& reference) {
  const ErrorAccumulator none(reference.voxel);
  return {none, none, none, {none, 0, 0}, 0, 0};
}

WindowError::WindowError(const ErrorReference& reference, const SearchWindow& surface_window,
                         const SearchWindow& mesh_window, const mesh::Mesh& mesh, const mesh::Mesh& surface,
                         const Context& context)
    : reference_(reference),
      window_(surface_window),
      mesh_window_(mesh_window),
      mesh_(mesh),
      surface_(surface),
      context_(context),
      placed_(mesh, reference.field, reference.extracted, reference.options.grid),
      index_from_step_(glm::inverse(reference.output_from_index.linear)) {
  placed_.add_caps(reference.options.caps);
}

Result<void> WindowError::prepare() {
  memory_ = TRY(context_.reserve(
      bytes(mesh_.triangles.size(), mesh_.positions.size(), surface_.triangles.size(), surface_.positions.size()),
      "the error of the mesh"));
  if (!surface_.triangles.empty()) surface_tree_.emplace(surface_.positions.span(), surface_.triangles.span());
  if (!mesh_.triangles.empty()) mesh_tree_.emplace(mesh_.positions.span(), mesh_.triangles.span());
  list_bricks();
  bricks_memory_ = TRY(context_.reserve(bricks_bytes(), "the error of the mesh"));
  return {};
}

Result<FieldSums> WindowError::measure(Progress* progress) {
  FieldSums sums = reduce_in_order(
      bricks_.size(), no_sums(reference_), progress,
      [&](const PointRange& range, FieldSums& into) {
        for (std::size_t b = range.begin(); b != range.end(); ++b) measure_brick(bricks_[b].brick, into);
      },
      1);
  if (error_) return tl::unexpected(std::move(*error_));
  TRY(context_.check());
  return sums;
}

std::uint64_t WindowError::bytes(std::uint64_t mesh_triangles, std::uint64_t mesh_vertices,
                                 std::uint64_t surface_triangles, std::uint64_t surface_vertices) {
  constexpr std::uint64_t kSplit = 4;  // about one triangle of four lies in two bricks
  return (mesh_triangles + mesh_triangles / kSplit + mesh_vertices) * sizeof(BrickMember) + mesh_vertices +
         mesh::TriangleTree::bytes(mesh_triangles) + mesh::TriangleTree::bytes(surface_triangles) +
         SurfaceComponents::bytes(surface_vertices, surface_triangles);
}

std::uint64_t WindowError::bricks_bytes() const {
  std::uint64_t most = 0;
  for (const BrickCount& brick : bricks_) most = std::max(most, brick.triangles);
  int cells = kBrickCells + 2 * kBrickMargin;
  if (const auto& last = reference_.cells.last()) {
    cells = std::min(cells, std::max({last->x, last->y, last->z}) + 1);
  }
  // With its margins a brick has at most twice its cells, and about twice its triangles.
  return bricks_.size() * sizeof(BrickCount) + static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency()) *
                                                   SubdividedSurface::bytes(cells, reference_.parts, 2 * most);
}

void WindowError::list_bricks() {
  const CellFinder& cells = reference_.cells;
  const BrickBox& wanted = window_.bricks();
  triangles_ = members_by_brick(mesh_.triangles.size(), [&](std::size_t t, const auto& add) {
    const auto corners = placed_.corners(t);
    // Reused by all triangles of a thread.
    thread_local std::vector<glm::ivec3> touched;
    touched.assign(1, cells.brick((corners[0] + corners[1] + corners[2]) / 3.0));
    const auto touch = [&](const glm::ivec3& brick) {
      if (touched.back() != brick) touched.push_back(brick);
    };
    const auto reaches_several = [&](const glm::dvec3& low, const glm::dvec3& high) {
      const glm::ivec3 brick = cells.brick(low - kPointRounding);
      if (brick != cells.brick(high + kPointRounding)) return true;
      touch(brick);
      return false;
    };
    for_each_wanted_point(corners, kLongestSide, reaches_several,
                          [&](const TrianglePoint& point) { touch(cells.brick(point.in(corners))); });
    const auto key = [](const glm::ivec3& brick) { return std::tuple(brick.z, brick.y, brick.x); };
    std::ranges::sort(touched, {}, key);
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    for (const glm::ivec3& brick : touched) {
      if (wanted.contains(brick)) add(brick);
    }
  });
  surface_vertices_ = placed_.surface_vertices();
  vertices_ = members_by_brick(mesh_.positions.size(), [&](std::size_t v, const auto& add) {
    const glm::ivec3 brick = cells.brick(placed_.vertex(v));
    if (wanted.contains(brick)) add(brick);
  });
  std::size_t most = std::size_t{1} << 16;
  const auto add = [&](const glm::ivec3& brick, std::uint64_t triangles) {
    if (!wanted.contains(brick)) return;
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
  const int around = reference_.options.interpolation == field::Interpolation::tricubic ? 1 : 0;
  const IndexMesh surface(surface_, reference_.field, reference_.extracted, reference_.options.grid);
  for (std::size_t t = 0; reference_.counted && t < surface_.triangles.size(); ++t) {
    const auto corners = surface.corners(t);
    const glm::ivec3 cell = cells.cell((corners[0] + corners[1] + corners[2]) / 3.0);
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

void WindowError::measure_brick(const glm::ivec3& at, FieldSums& sums) {
  if (context_.cancelled() || failed_ || is_too_small_) return;
  field::IndexBox cells{at * kBrickCells - kBrickMargin, at * kBrickCells + (kBrickCells + kBrickMargin - 1)};
  glm::dvec3 low(-std::numeric_limits<double>::infinity());
  glm::dvec3 high(std::numeric_limits<double>::infinity());
  if (const auto& last = reference_.cells.last()) {
    cells = {glm::max(cells.min, glm::ivec3(0)), glm::min(cells.max, *last)};
    if (cells.empty()) return;
    low = glm::dvec3(0);
    high = glm::dvec3(*last + 1);
  }
  const glm::dmat3& linear = reference_.output_from_index.linear;
  FieldFootFinder foot(field::Interpolant::Cursor(reference_.chosen), 0, linear, low, high);
  const Subdivision how{reference_.field.kind, linear, reference_.parts};
  // Keeps this thread from starting another brick while it waits for its own loops: each brick holds memory.
  auto made = tbb::this_task_arena::isolate([&] { return SubdividedSurface::make(foot.function(), cells, how); });
  if (!made) {
    const std::scoped_lock lock(error_mutex_);
    if (!failed_.exchange(true)) error_ = std::move(made.error());
    return;
  }
  Brick brick{at, std::move(*made), {cells.min, cells.max + 1}, foot, search_in(reference_.chosen)};
  tbb::this_task_arena::isolate([&] {
    for (const BrickMember& member : members_of(triangles_, at)) measure_triangle(member.id, brick, sums);
    measure_vertices(brick, sums);
    if (reference_.counted && reference_.has_mesh) measure_from_surface(brick, sums);
  });
  if (sums.needed > 0 || sums.back.needed > 0) is_too_small_ = true;
}

GradientSearch WindowError::search_in(const field::Interpolant& interpolant) const {
  return {interpolant, reference_.field, reference_.output_from_index.linear, reference_.shortest};
}

double WindowError::measure_point(const glm::dvec3& index, double weight, Brick& brick, ErrorAccumulator& into) const {
  if (placed_.is_outside(index)) {
    ++into.counts.outside;
    return 0;
  }
  const auto first = brick.search(index);
  if (!first) {
    ++into.counts.not_finite;
    return 0;
  }
  std::optional<glm::dvec3> step = first->step;
  const bool done = step && (first->is_nearest || glm::length(*step) <= kNearEnough);
  if (!done) search_in_brick(index, brick, step);
  double needed = 0;
  if (!step || brick.foot.length(*step) > distance_inside(index, brick.box)) needed = search_window(index, brick, step);
  if (!step) {
    ++into.counts.unreached;
    return needed;
  }
  const double voxels = glm::length(*step);
  if (voxels < first->guess / 2 || voxels > 1.5 * first->guess) ++into.counts.corrected;
  into.add({voxels, brick.foot.length(*step)}, weight, reference_.output_from_index(index));
  return needed;
}

double WindowError::distance_inside(const glm::dvec3& index, const field::IndexBox& box) const {
  const auto& last = reference_.cells.last();
  double nearest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double width = reference_.width[axis];
    if (!last || box.min[axis] > 0) nearest = std::min(nearest, (index[axis] - box.min[axis]) * width);
    if (!last || box.max[axis] <= (*last)[axis]) nearest = std::min(nearest, (box.max[axis] - index[axis]) * width);
  }
  return nearest;
}

void WindowError::search_in_brick(const glm::dvec3& index, Brick& brick, std::optional<glm::dvec3>& step) const {
  if (brick.surface.mesh().triangles.empty()) return;
  const auto found = brick.surface.tree().nearest(brick.surface.local(index), brick.near);
  brick.near = found.slot;
  keep_nearer_foot(index, brick.surface.index(found.point), reference_.diagonal / reference_.parts, brick.foot, step);
}

double WindowError::search_window(const glm::dvec3& index, Brick& brick, std::optional<glm::dvec3>& step) const {
  if (!surface_tree_) return window_.needed(index, std::numeric_limits<double>::infinity());
  const field::Affine& output = reference_.output_from_index;
  const glm::dvec3 p = output.linear * index + (output.offset - surface_.origin);
  const auto found = surface_tree_->nearest(p, brick.near_whole);
  brick.near_whole = found.slot;
  keep_nearer_foot(index, index_from_step_ * (found.point - p) + index, reference_.diagonal, brick.foot, step);
  return window_.needed(index, std::sqrt(found.distance_squared));
}

void WindowError::keep_nearer_foot(const glm::dvec3& index, const glm::dvec3& near, double reach, FieldFootFinder& foot,
                                   std::optional<glm::dvec3>& step) {
  glm::dvec3 point = near;
  if (const auto landed = foot.land(near, reach)) point = foot.approach(index, *landed, reach);
  if (!step || foot.length(point - index) < foot.length(*step)) step = point - index;
}

void WindowError::measure_triangle(std::size_t triangle, Brick& brick, FieldSums& sums) const {
  const auto corners = placed_.corners(triangle);
  const CellFinder& cells = reference_.cells;
  if (placed_.is_cap(corners)) {
    sums.cap_triangles += cells.brick((corners[0] + corners[1] + corners[2]) / 3.0) == brick.at ? 1 : 0;
    return;
  }
  const double area = glm::length(placed_.area_vector(corners)) / 2;
  const auto meets_brick = [&](const glm::dvec3& low, const glm::dvec3& high) {
    return glm::all(glm::lessThanEqual(cells.brick(low - kPointRounding), brick.at)) &&
           glm::all(glm::greaterThanEqual(cells.brick(high + kPointRounding), brick.at));
  };
  for_each_wanted_point(corners, kLongestSide, meets_brick, [&](const TrianglePoint& point) {
    const glm::dvec3 index = point.in(corners);
    if (cells.brick(index) != brick.at) return;
    sums.needed = std::max(sums.needed, measure_point(index, point.share * area, brick, sums.interior));
  });
}

void WindowError::measure_vertices(Brick& brick, FieldSums& sums) const {
  const FieldErrorOptions& options = reference_.options;
  const bool edges = options.vertices_on_edges && options.grid == nullptr;
  GradientSearch trilinear = search_in(reference_.trilinear);
  for (const BrickMember& member : members_of(vertices_, brick.at)) {
    if (surface_vertices_[member.id] == 0) continue;
    const glm::dvec3 index = placed_.vertex(member.id);
    sums.needed = std::max(sums.needed, measure_point(index, 1, brick, sums.vertices));
    if (!edges || !placed_.on_axis_edge(index)) continue;
    const auto stored = trilinear(index);
    if (!stored) {
      ++sums.storage.counts.not_finite;
    } else if (!stored->step) {
      ++sums.storage.counts.unreached;
    } else {
      sums.storage.add({glm::length(*stored->step), glm::length(reference_.output_from_index.linear * *stored->step)},
                       1, reference_.output_from_index(index));
    }
  }
}

void WindowError::measure_from_surface(Brick& brick, FieldSums& sums) const {
  const auto& region = reference_.region;
  const auto counts = [&](const glm::dvec3& center) {
    const glm::ivec3 cell = reference_.cells.cell(center);
    return brick_of(cell) == brick.at && (!region || (glm::all(glm::greaterThanEqual(cell, region->min)) &&
                                                      glm::all(glm::lessThan(cell, region->max))));
  };
  const SurfaceToMesh back(mesh_, mesh_tree_ ? &*mesh_tree_ : nullptr, placed_, reference_.options.clipped,
                           mesh_window_);
  back.measure(brick.surface, brick.foot, reference_.diagonal / reference_.parts, counts, sums.back);
}

}  // namespace isoextract::accuracy
