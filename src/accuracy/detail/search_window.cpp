#include "accuracy/detail/search_window.hpp"

#include <span>

namespace isoextract::accuracy {
namespace {

// Adds boxes that divide `box` along z, y or x. `bricks` are those of the box with triangles, sorted along `axis`.
void divide_along(int axis, const BrickBox& box, std::span<const BrickCount> bricks, std::uint64_t most,
                  std::vector<WindowBricks>& boxes) {
  BrickBox open = box;  // begins where the last complete box ends
  std::uint64_t in_open = 0;
  std::size_t first = 0;  // of the bricks in `open`
  const auto close = [&](std::size_t end, int last) {
    BrickBox part = open;
    part.max[axis] = last;
    const auto members = bricks.subspan(first, end - first);
    const bool is_one_layer = !members.empty() && members.front().brick[axis] == members.back().brick[axis];
    if (in_open > most && axis > 0 && is_one_layer) {
      divide_along(axis - 1, part, members, most, boxes);
    } else {
      boxes.push_back({part, members.size()});
    }
    open.min[axis] = last + 1;
    in_open = 0;
    first = end;
  };
  for (std::size_t begin = 0; begin < bricks.size();) {
    const int layer = bricks[begin].brick[axis];
    std::size_t end = begin;
    std::uint64_t in_layer = 0;
    for (; end < bricks.size() && bricks[end].brick[axis] == layer; ++end) in_layer += bricks[end].triangles;
    if (in_open > 0 && in_open + in_layer > most) close(begin, layer - 1);
    in_open += in_layer;
    begin = end;
  }
  close(bricks.size(), box.max[axis]);
}

}  // namespace

std::vector<WindowBricks> divide_bricks(const std::vector<BrickCount>& bricks, std::uint64_t most) {
  std::vector<WindowBricks> boxes;
  divide_along(2, BrickBox(), bricks, most, boxes);
  return boxes;
}

}  // namespace isoextract::accuracy
