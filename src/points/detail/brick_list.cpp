#include "points/detail/brick_list.hpp"

#include <optional>
#include <vector>

namespace isoextract::points {
namespace {

glm::ivec3 step_along(int axis) {
  glm::ivec3 step(0);
  step[axis] = 1;
  return step;
}

// f(brick) for those of the lists moved by -rings .. rings along an axis, each once and in order.
template <class F>
void for_each_dilated(std::span<const glm::ivec3> bricks, int axis, int rings, const F& f) {
  const glm::ivec3 step = step_along(axis);
  std::vector<std::size_t> next(static_cast<std::size_t>(2 * rings) + 1, 0);
  for (;;) {
    std::optional<glm::ivec3> least;
    for (int r = -rings; r <= rings; ++r) {
      const std::size_t n = next[static_cast<std::size_t>(r + rings)];
      if (n == bricks.size()) continue;
      const glm::ivec3 moved = bricks[n] + r * step;
      if (!least || brick_before(moved, *least)) least = moved;
    }
    if (!least) return;
    f(*least);
    for (int r = -rings; r <= rings; ++r) {
      std::size_t& n = next[static_cast<std::size_t>(r + rings)];
      if (n != bricks.size() && bricks[n] + r * step == *least) ++n;
    }
  }
}

// f(number) for the bricks whose two neighbours along an axis are in the list.
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
  BrickList list;
  for (int axis = 2; axis >= 0; --axis) {
    const std::span<const glm::ivec3> from = list ? std::as_const(list->values).span() : bricks;
    std::size_t count = 0;
    for_each_dilated(from, axis, rings, [&](const glm::ivec3&) { ++count; });
    auto made = make_reserved_buffer<glm::ivec3>(count, context, label);
    if (!made) return made;
    glm::ivec3* out = (*made)->values.data();
    for_each_dilated(from, axis, rings, [&](const glm::ivec3& brick) { *out++ = brick; });
    list = std::move(*made);
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
