// The windows in which the error of a large mesh is measured, one after the other. A window is a box of bricks with a
// margin. Points in its bricks are measured to the triangles in the bricks and the margin.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "accuracy/detail/brick_members.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::accuracy {

inline constexpr int kBrickCells = 16;  // cells along an axis

// Returns the brick of a cell, which is given by its lowest sample.
[[nodiscard]] inline glm::ivec3 brick_of(const glm::ivec3& cell) {
  return glm::ivec3(glm::floor(glm::dvec3(cell) / static_cast<double>(kBrickCells)));
}

// Finds the cells of points in index space. Points outside dense data belong to the nearest cell.
class CellFinder {
 public:
  explicit CellFinder(const field::ScalarField& field) {
    if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) last_cell_ = dense->dims - 2;
  }

  // Returns the last cell of dense data; nothing for sparse data, which have no bounds.
  [[nodiscard]] const std::optional<glm::ivec3>& last() const { return last_cell_; }

  [[nodiscard]] glm::ivec3 cell(const glm::dvec3& index) const {
    constexpr double kFarthest = field::kMaxSparseIndex;
    const glm::ivec3 cell(glm::floor(glm::clamp(index, glm::dvec3(-kFarthest), glm::dvec3(kFarthest))));
    return last_cell_ ? glm::clamp(cell, glm::ivec3(0), *last_cell_) : cell;
  }
  [[nodiscard]] glm::ivec3 brick(const glm::dvec3& index) const { return brick_of(cell(index)); }

 private:
  std::optional<glm::ivec3> last_cell_;
};

// Bricks that belong to a window; with their margin they make a SearchWindow.
struct BrickBox {
  static constexpr int kUnbounded = 1 << 26;  // farther than the brick of any cell

  glm::ivec3 min{-kUnbounded};
  glm::ivec3 max{kUnbounded};  // belongs to the box

  [[nodiscard]] bool contains(const glm::ivec3& brick) const {
    return glm::all(glm::greaterThanEqual(brick, min)) && glm::all(glm::lessThanEqual(brick, max));
  }
  // Returns the samples at the corners of the box's cells, and those up to `margin` cells beyond, without those outside
  // `all`.
  [[nodiscard]] field::IndexBox samples(int margin, const field::IndexBox& all) const {
    const glm::i64vec3 low = glm::i64vec3(min) * std::int64_t{kBrickCells} - std::int64_t{margin};
    const glm::i64vec3 high = (glm::i64vec3(max) + std::int64_t{1}) * std::int64_t{kBrickCells} + std::int64_t{margin};
    return {glm::ivec3(glm::max(low, glm::i64vec3(all.min))), glm::ivec3(glm::min(high, glm::i64vec3(all.max)))};
  }
};

// The samples of a window, and the distance up to which a search in it is complete.
class SearchWindow {
 public:
  // `width` is the width of a cell between opposite faces. No triangle reaches beyond `all`.
  SearchWindow(const BrickBox& bricks, int margin, const field::IndexBox& all, const glm::dvec3& width)
      : bricks_(bricks), margin_(margin), samples_(bricks.samples(margin, all)), all_(all), width_(width) {}

  [[nodiscard]] const BrickBox& bricks() const { return bricks_; }
  [[nodiscard]] int margin() const { return margin_; }  // cells
  [[nodiscard]] const field::IndexBox& samples() const { return samples_; }
  [[nodiscard]] bool is_whole() const { return samples_ == all_; }

  // Returns the distance of `index` from the nearest face of the window beyond which there may be triangles; infinity
  // if there is none.
  [[nodiscard]] double distance_inside(const glm::dvec3& index) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (samples_.min[axis] > all_.min[axis]) {
        nearest = std::min(nearest, (index[axis] - samples_.min[axis]) * width_[axis]);
      }
      if (samples_.max[axis] < all_.max[axis]) {
        nearest = std::min(nearest, (samples_.max[axis] - index[axis]) * width_[axis]);
      }
    }
    return nearest;
  }
  // Returns 0 if the nearest triangle of `index`, found in the window at `distance`, is the nearest of all; otherwise
  // `distance`, within which the nearest one is.
  [[nodiscard]] double needed(const glm::dvec3& index, double distance) const {
    return distance > distance_inside(index) ? distance : 0;
  }

 private:
  BrickBox bricks_;
  int margin_;
  field::IndexBox samples_;
  field::IndexBox all_;
  glm::dvec3 width_;
};

struct WindowBricks {
  BrickBox box;
  std::size_t count = 0;  // bricks in the box that have triangles
};

// Divides all bricks into boxes, in rising order along z, then y, then x. A box has at most `most` triangles if it can
// be divided, and two neighbors along the axis of their division have more. `bricks` are sorted by merge_bricks().
[[nodiscard]] std::vector<WindowBricks> divide_bricks(const std::vector<BrickCount>& bricks, std::uint64_t most);

}  // namespace isoextract::accuracy
