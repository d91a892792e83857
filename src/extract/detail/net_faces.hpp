// The faces of a surface net, and the shells that they form.
//
// A face is a square of four points between two voxels with different labels. A shell is a part of the surface of one
// label that is connected through its vertices: the outer surface of a body, or that of a cavity. Each face belongs to
// up to two shells, one for each of its labels.
//
// Only the shells of a face are stored. Faces are sorted by their first point, then by axis, so the number of a face
// follows from these two. NearPoints has the points of a face, and NearFaces the faces around a point, for one chunk.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "extract/detail/near_points.hpp"
#include "extract/detail/net_grid.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {

struct LabelShells {
  std::int64_t label = 0;
  std::uint64_t shells = 0;
};

class NetFaces {
 public:
  static constexpr std::uint32_t kNoShell = ~std::uint32_t{0};

  // The shells of the labels on the lower and upper sides of a face; kNoShell for voxels without a label.
  using Shells = std::array<std::uint32_t, 2>;

  // By axis: the steps in places (NearPlaces) from the first point of a face to each of its four points,
  // counter-clockwise as seen from the upper side.
  static constexpr std::array<std::array<int, 4>, 3> kPoints{
      {{0, NearPlaces::kSteps[1], NearPlaces::kSteps[1] + NearPlaces::kSteps[2], NearPlaces::kSteps[2]},
       {0, NearPlaces::kSteps[2], NearPlaces::kSteps[2] + NearPlaces::kSteps[0], NearPlaces::kSteps[0]},
       {0, NearPlaces::kSteps[0], NearPlaces::kSteps[0] + NearPlaces::kSteps[1], NearPlaces::kSteps[1]}}};

  // Runs in parallel; the result does not depend on the number of threads. Fails if memory runs out, if the context is
  // cancelled, and with ErrorCode::input if 32-bit numbers do not suffice.
  [[nodiscard]] static Result<NetFaces> make(const NetGrid& grid, const LabelChunks& labels, NetMemory& memory);

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t points, std::uint64_t faces, std::uint64_t chunks) {
    return points * sizeof(std::uint16_t) + (64 * chunks + 1) * sizeof(std::uint32_t) + faces * sizeof(Shells);
  }

  [[nodiscard]] std::size_t size() const { return of_shells_.size() / 2; }
  [[nodiscard]] std::uint32_t shells() const { return static_cast<std::uint32_t>(first_nodes_.size()); }
  [[nodiscard]] Shells shells_of(std::size_t face) const { return {of_shells_[2 * face], of_shells_[2 * face + 1]}; }

  // Returns the number of shells of each label, by rising label. `grid` and `labels` are those given to make().
  [[nodiscard]] std::vector<LabelShells> count_shells(const NetGrid& grid, const LabelChunks& labels) const;

  // Returns the faces around a point, as bits numbered as in corner_fans.hpp.
  [[nodiscard]] unsigned sides(std::uint32_t point) const { return sides_[point]; }

  // Returns the axes, as bits, for which a face perpendicular to the axis has `point` as its first point.
  [[nodiscard]] unsigned own_axes(std::uint32_t point) const {
    const unsigned sides = sides_[point];
    return (sides >> 3 & 1) | (sides >> 6 & 2) | (sides >> 9 & 4);
  }

  // Returns the number of the first face whose first point is in a row; if the row has none, that of the next face.
  [[nodiscard]] std::uint32_t first_of_row(std::size_t chunk, std::size_t row) const {
    return first_of_rows_[64 * chunk + row];
  }

  // Calls f(number, axis, corner of the first point) for the faces whose first point is in a chunk, in order. The
  // corner is given relative to the lowest corner of the chunk.
  template <class F>
  void for_each_of_chunk(const NetGrid& grid, std::size_t chunk, const F& f) const {
    std::uint32_t number = first_of_row(chunk, 0);
    grid.for_each_row(chunk, [&](const NetGrid::Row& row, int y, int z) {
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        for_each_bit(own_axes(k), [&](int axis) { f(number++, axis, glm::ivec3(bit, y, z)); });
        ++k;
      });
    });
  }

 private:
  void find_sides(const NetGrid& grid, const LabelChunks& labels, const NetMemory& memory);
  [[nodiscard]] Result<void> number_faces(const NetGrid& grid, NetMemory& memory);
  void mark_labeled(const NetGrid& grid, const LabelChunks& labels, const NetMemory& memory);
  void join_shells(const NetGrid& grid, const LabelChunks& labels, const NetMemory& memory);
  [[nodiscard]] Result<void> number_shells(const NetMemory& memory);
  [[nodiscard]] glm::ivec3 voxel_at(const NetGrid& grid, std::uint32_t node) const;

  NetArray<std::uint16_t> sides_;          // of each point
  NetArray<std::uint32_t> first_of_rows_;  // 64 for each chunk, then the number of faces
  // A node is a side of a face that has a label: 2 * face + side, where the lower side is 0.
  NetArray<std::uint32_t> of_shells_;       // of each node
  std::vector<std::uint32_t> first_nodes_;  // of each shell
  std::vector<Reservation> memory_;
};

// The numbers of the faces around the points of a chunk.
class NearFaces {
 public:
  NearFaces(const NetGrid& grid, const NetFaces& faces, std::size_t chunk);

  // Returns the number of the face that is face `side` (corner_fans.hpp) around the point at a place (NearPlaces).
  [[nodiscard]] std::uint32_t number(int place, int side) const;

 private:
  void put(const NetFaces& faces, int place, std::uint32_t point, std::uint32_t first) {
    first_[static_cast<std::size_t>(place)] = first;
    axes_[static_cast<std::size_t>(place)] = static_cast<std::uint8_t>(faces.own_axes(point));
  }

  std::array<std::uint32_t, NearPlaces::kCount>
      first_{};  // number of the first of the faces whose first point is at the place
  std::array<std::uint8_t, NearPlaces::kCount> axes_{};  // the axes of these faces
};

}  // namespace isoextract::extract
