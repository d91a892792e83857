#include "extract/detail/corner_fans.hpp"

namespace isoextract::extract {
namespace {

// The other two axes, the lower one first.
constexpr int lower_other(int axis) { return axis == 0 ? 1 : 0; }
constexpr int higher_other(int axis) { return axis == 2 ? 1 : 2; }

constexpr bool holds(int pattern, int voxel) { return (pattern >> voxel & 1) != 0; }

// Returns the face across `axis` on sides `b` and `c` of the other two axes.
constexpr int face_number(int axis, int b, int c) { return axis * 4 + (b | c << 1); }

class FanFinder {
 public:
  constexpr explicit FanFinder(int pattern) : pattern_(pattern) {
    for (int f = 0; f < 12; ++f) group_[static_cast<std::size_t>(f)] = f;
  }

  constexpr CornerFans find() {
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 2; ++side) join_at_edge(axis, side);
    }
    CornerFans found;
    std::array<int, 12> number{};
    for (int f = 0; f < 12; ++f) {
      if (!is_face(f)) continue;
      const int first = group_[static_cast<std::size_t>(f)];
      if (first == f) number[static_cast<std::size_t>(f)] = found.fans++;
      found.of_face[static_cast<std::size_t>(f)] = static_cast<std::uint8_t>(number[static_cast<std::size_t>(first)]);
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 2; ++side) {
        if (is_doubled(axis, side))
          found.doubled[static_cast<std::size_t>(side)] |= static_cast<std::uint8_t>(1 << axis);
      }
    }
    return found;
  }

 private:
  // Returns the voxel at sides `b` and `c` of the other axes around the edge that leaves the corner along `axis` to
  // `side`.
  static constexpr int voxel_at(int axis, int side, int b, int c) {
    return side << axis | b << lower_other(axis) | c << higher_other(axis);
  }

  [[nodiscard]] constexpr bool is_face(int f) const {
    const int axis = f / 4;
    const int low = (f & 1) << lower_other(axis) | (f >> 1 & 1) << higher_other(axis);
    return holds(pattern_, low) != holds(pattern_, low | 1 << axis);
  }

  // Returns the face at the edge that separates the two voxels that differ along `across`; `level` is their side along
  // the third axis.
  static constexpr int face_at(int axis, int side, int across, int level) {
    const int third = 3 - axis - across;
    const int b = lower_other(across) == axis ? side : level;
    const int c = higher_other(across) == third ? level : side;
    return face_number(across, b, c);
  }

  constexpr void join(int f, int g) {
    const int a = group_[static_cast<std::size_t>(f)];
    const int b = group_[static_cast<std::size_t>(g)];
    const int low = a < b ? a : b;
    for (int& group : group_) {
      if (group == a || group == b) group = low;
    }
  }

  [[nodiscard]] constexpr bool is_diagonal(int axis, int side) const {
    const bool corner = holds(pattern_, voxel_at(axis, side, 0, 0));
    return corner == holds(pattern_, voxel_at(axis, side, 1, 1)) &&
           corner != holds(pattern_, voxel_at(axis, side, 1, 0)) &&
           corner != holds(pattern_, voxel_at(axis, side, 0, 1));
  }

  // Returns the two faces of the voxel at sides `b` and `c` that meet at the edge.
  static constexpr std::array<int, 2> faces_of(int axis, int side, int b, int c) {
    return {face_at(axis, side, lower_other(axis), c), face_at(axis, side, higher_other(axis), b)};
  }

  constexpr void join_at_edge(int axis, int side) {
    if (is_diagonal(axis, side)) {
      for (int b = 0; b < 2; ++b) {
        const int c = holds(pattern_, voxel_at(axis, side, b, 0)) ? 0 : 1;
        const std::array<int, 2> faces = faces_of(axis, side, b, c);
        join(faces[0], faces[1]);
      }
      return;
    }
    int first = -1;
    for (const int across : {lower_other(axis), higher_other(axis)}) {
      for (int level = 0; level < 2; ++level) {
        const int f = face_at(axis, side, across, level);
        if (!is_face(f)) continue;
        if (first >= 0) join(first, f);
        first = f;
      }
    }
  }

  [[nodiscard]] constexpr bool is_doubled(int axis, int side) const {
    if (!is_diagonal(axis, side)) return false;
    const auto group = [&](int f) { return group_[static_cast<std::size_t>(f)]; };
    return group(face_at(axis, side, lower_other(axis), 0)) == group(face_at(axis, side, lower_other(axis), 1));
  }

  int pattern_;
  std::array<int, 12> group_{};
};

constexpr std::array<CornerFans, 256> make_corner_fans() {
  std::array<CornerFans, 256> table{};
  for (int pattern = 0; pattern < 256; ++pattern) {
    table[static_cast<std::size_t>(pattern)] = FanFinder(pattern).find();
  }
  return table;
}

constexpr std::array<CornerFans, 256> kCornerFans = make_corner_fans();

}  // namespace

const std::array<CornerFans, 256>& corner_fans() { return kCornerFans; }

}  // namespace isoextract::extract
