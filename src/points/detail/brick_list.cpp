#include "points/detail/brick_list.hpp"

#include <algorithm>
#include <utility>

namespace isoextract::points {
namespace {

glm::ivec3 step_along(int axis) {
  glm::ivec3 step(0);
  step[axis] = 1;
  return step;
}

// Calls f(brick) for the union of the list and its translate along an axis, each brick once and in order.
template <class F>
void for_each_joined(std::span<const glm::ivec3> bricks, const glm::ivec3& move, const F& f) {
  std::size_t here = 0;  // never behind `moved`: a brick sorts before its translate
  for (std::size_t moved = 0; moved < bricks.size();) {
    const glm::ivec3 there = bricks[moved] + move;
    if (here < bricks.size() && brick_before(bricks[here], there)) {
      f(bricks[here++]);
      continue;
    }
    if (here < bricks.size() && bricks[here] == there) ++here;
    f(there);
    ++moved;
  }
}

// Calls f(index) for the bricks whose two neighbors along an axis are in the list.
template <class F>
void for_each_eroded(std::span<const glm::ivec3> bricks, int axis, const F& f) {
  const glm::ivec3 step = step_along(axis);
  std::size_t below = 0;
  std::size_t above = 0;
  for (std::size_t b = 0; b < bricks.size(); ++b) {
    while (below < bricks.size() && brick_before(bricks[below], bricks[b] - step)) ++below;
    while (above < bricks.size() && brick_before(bricks[above], bricks[b] + step)) ++above;
    if (below < bricks.size() && above < bricks.size() && bricks[below] == bricks[b] - step &&
        bricks[above] == bricks[b] + step) {
      f(b);
    }
  }
}

}  // namespace

Result<BrickList> dilated(std::span<const glm::ivec3> bricks, int rings, const Context& context,
                          const std::string& label) {
  auto list = make_reserved_buffer<glm::ivec3>(bricks.size(), context, label);
  if (!list) return list;
  std::ranges::transform(bricks, (*list)->values.begin(), [&](const glm::ivec3& brick) { return brick - rings; });
  for (int axis = 2; axis >= 0; --axis) {
    // Each union doubles the width, so many rings need few of them.
    const int wanted = 2 * rings + 1;
    for (int width = 1; width < wanted;) {
      TRY(context.check());
      const int more = std::min(width, wanted - width);
      const std::span<const glm::ivec3> from = std::as_const((*list)->values).span();
      std::size_t count = 0;
      for_each_joined(from, more * step_along(axis), [&](const glm::ivec3&) { ++count; });
      auto made = make_reserved_buffer<glm::ivec3>(count, context, label);
      if (!made) return made;
      glm::ivec3* out = (*made)->values.data();
      for_each_joined(from, more * step_along(axis), [&](const glm::ivec3& brick) { *out++ = brick; });
      list = std::move(made);
      width += more;
    }
  }
  return list;
}

Result<BrickList> eroded(std::span<const glm::ivec3> bricks, const Context& context, const std::string& label) {
  BrickList list;
  for (int axis = 2; axis >= 0; --axis) {
    const std::span<const glm::ivec3> from = list ? std::as_const(list->values).span() : bricks;
    std::size_t count = 0;
    for_each_eroded(from, axis, [&](std::size_t) { ++count; });
    auto made = make_reserved_buffer<glm::ivec3>(count, context, label);
    if (!made) return made;
    glm::ivec3* out = (*made)->values.data();
    for_each_eroded(from, axis, [&](std::size_t b) { *out++ = from[b]; });
    list = std::move(*made);
  }
  return list;
}

}  // namespace isoextract::points
