#include "extract/detail/net_face_size.hpp"

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_inverse.hpp>

#include "extract/detail/float4.hpp"
#include "extract/detail/net_faces.hpp"

namespace isoextract::extract {
namespace {

// Returns whether the map changes the ratio of lengths.
bool is_stretched(const glm::dmat3& map) {
  const glm::dmat3 squares = glm::transpose(map) * map;
  const double scale = squares[0][0];
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (std::abs(squares[column][row] - (row == column ? scale : 0)) > 1e-9 * scale) return true;
    }
  }
  return false;
}

// The coordinates of the four corners of a face.
using Corners = std::array<Float4, 3>;

// Returns the coordinates of the corners of a face across an axis, relative to the first corner.
template <int kAxis>
constexpr Corners corners_across() {
  Corners corners{};
  corners[(kAxis + 1) % 3] = Float4{0, 1, 1, 0};
  corners[(kAxis + 2) % 3] = Float4{0, 0, 1, 1};
  return corners;
}

// Returns the values of the next or the previous corner for each.
Float4 next(Float4 values) { return __builtin_shufflevector(values, values, 1, 2, 3, 0); }
Float4 previous(Float4 values) { return __builtin_shufflevector(values, values, 3, 0, 1, 2); }

// Returns 12 times the volumes below the walls between the sides of a voxel face and the sides of the moved face. A
// wall is the mean of its two divisions into triangles. Neighbors have the same walls with the opposite sign. `u`, `v`,
// `up`: the offsets of the corners along the sides and the normal.
Float4 walls_of(Float4 u, Float4 v, Float4 up) {
  const Float4 next_u = next(u);
  const Float4 next_v = next(v);
  const Float4 next_up = next(up);
  // The sides of the voxel face are +u, +v, -u and -v. The cross product of a side with an offset:
  const Float4 at_here = __builtin_shufflevector(u, v, 4, 1, 6, 3) * Float4{1, -1, -1, 1};
  const Float4 at_next = __builtin_shufflevector(next_u, next_v, 4, 1, 6, 3) * Float4{1, -1, -1, 1};
  const Float4 between = next_u * v - next_v * u;
  return next_up * at_next + up * at_here + (next_up + up) * (at_here + at_next + 2 * between);
}

}  // namespace

NetFaceSizes::NetFaceSizes(const NetArray<glm::vec3>& offsets, const glm::dmat3& output_from_index)
    : offsets_(offsets),
      output_area_(glm::inverseTranspose(output_from_index)),
      is_stretched_(is_stretched(output_from_index)) {}

template <int kAxis>
NetFaceSize NetFaceSizes::across(const NearPoints& near, int place) const {
  constexpr auto kU = static_cast<std::size_t>((kAxis + 1) % 3);
  constexpr auto kV = static_cast<std::size_t>((kAxis + 2) % 3);
  constexpr auto kUp = static_cast<std::size_t>(kAxis);
  const auto offset = [&](std::size_t n) { return load(&offsets_[near[place + NetFaces::kPoints[kUp][n]]]); };
  const Float4 a = offset(0);
  const Float4 b = offset(1);
  const Float4 c = offset(2);
  const Float4 d = offset(3);
  const Float4 xy_ab = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const Float4 xy_cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Float4 z_ab = __builtin_shufflevector(a, b, 2, 6, 2, 6);
  const Float4 z_cd = __builtin_shufflevector(c, d, 2, 6, 2, 6);
  const Corners moved{__builtin_shufflevector(xy_ab, xy_cd, 0, 1, 4, 5),
                      __builtin_shufflevector(xy_ab, xy_cd, 2, 3, 6, 7),
                      __builtin_shufflevector(z_ab, z_cd, 0, 1, 4, 5)};
  constexpr Corners kCorners = corners_across<kAxis>();
  const Corners p{kCorners[0] + moved[0], kCorners[1] + moved[1], kCorners[2] + moved[2]};
  // Twice the areas of the triangles around the corners.
  Corners side;
  Corners back;
  for (std::size_t i = 0; i < 3; ++i) {
    side[i] = next(p[i]) - p[i];
    back[i] = previous(side[i]);
  }
  const Corners around{back[1] * side[2] - back[2] * side[1], back[2] * side[0] - back[0] * side[2],
                       back[0] * side[1] - back[1] * side[0]};
  // The rule of OutlinePolygon::write_bent().
  Corners output = around;
  if (is_stretched_) {
    for (int row = 0; row < 3; ++row) {
      output[static_cast<std::size_t>(row)] =
          output_area_[0][row] * around[0] + output_area_[1][row] * around[1] + output_area_[2][row] * around[2];
    }
  }
  // Adds in an order that gives mirror images equal sizes.
  const Float4 size = output[kUp] * output[kUp] + (output[kU] * output[kU] + output[kV] * output[kV]);
  const bool is_through_apex = std::min(size[0], size[2]) < std::min(size[1], size[3]);
  // The volume is the sum of area, as seen from above, times mean height of the triangles. The voxel face has height 0.
  const Float4 height = moved[kUp];
  const Float4 both = height + next(height);
  const Float4 below = around[kUp] * (previous(height) + both);
  const float top = is_through_apex ? below[1] + below[3] : below[0] + below[2];
  const Float4 walls = walls_of(moved[kU], moved[kV], height);
  return {0.5F * glm::vec3(around[0][1] + around[0][3], around[1][1] + around[1][3], around[2][1] + around[2][3]),
          top / 6 + ((walls[0] + walls[2]) + (walls[1] + walls[3])) / 12};
}

template NetFaceSize NetFaceSizes::across<0>(const NearPoints& near, int place) const;
template NetFaceSize NetFaceSizes::across<1>(const NearPoints& near, int place) const;
template NetFaceSize NetFaceSizes::across<2>(const NearPoints& near, int place) const;

}  // namespace isoextract::extract
