// The faces of a surface net, and the shells that they form.
//
// A face is a square of four points between two voxels with different labels. A shell is a part of the surface of one
// label that is connected through its vertices: the outer surface of a body, or that of a cavity. Each face belongs to
// up to two shells, one for each of its labels.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "extract/detail/net_grid.hpp"

namespace isoextract::extract {

class NetFaces {
 public:
  static constexpr std::uint32_t kNoShell = ~std::uint32_t{0};

  struct Face {
    // The indices of the four points, counter-clockwise as seen from the upper side of the face; the first is at
    // `corner`.
    std::array<std::uint32_t, 4> points;
    // The shells of the labels on the lower and upper sides; kNoShell for voxels without a label.
    std::array<std::uint32_t, 2> shells;
  };

  // Runs in parallel; the result does not depend on the number of threads. Fails if memory runs out, if the context is
  // cancelled, and with ErrorCode::input if 32-bit numbers do not suffice. `what` starts the message about memory.
  [[nodiscard]] static Result<NetFaces> make(const NetGrid& grid, const LabelChunks& labels, const Context& context,
                                             const std::string& what);

  [[nodiscard]] std::span<const Face> faces() const { return faces_.span(); }
  [[nodiscard]] std::uint32_t shells() const { return shells_; }

  // Returns the axis that a face lies across.
  [[nodiscard]] int axis(std::size_t face) const { return axes_[face]; }

  // Calls f(number, corner of the first point) for the faces whose first point is in a chunk, in order.
  template <class F>
  void for_each_of_chunk(const NetGrid& grid, std::size_t chunk, const F& f) const {
    std::size_t number = first_of_chunk_[chunk];  // the faces are sorted by their first point
    grid.for_each_row(chunk, [&](const NetGrid::Row& row, int y, int z) {
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        const glm::ivec3 corner = grid.origins()[chunk] + glm::ivec3(bit, y, z);
        for (; number < faces_.size() && faces_[number].points[0] == k; ++number) f(number, corner);
        ++k;
      });
    });
  }

  // Returns the faces around a point.
  [[nodiscard]] std::span<const std::uint32_t> around(std::uint32_t point) const {
    return around_.span().subspan(first_around_[point], first_around_[point + 1] - first_around_[point]);
  }

 private:
  void find_sides(const NetGrid& grid, const LabelChunks& labels);
  [[nodiscard]] Result<void> list_faces(const NetGrid& grid, const LabelChunks& labels, const Context& context,
                                        const std::string& what);
  [[nodiscard]] Result<void> join_shells(const NetGrid& grid, const LabelChunks& labels, const Context& context,
                                         const std::string& what);

  Buffer<std::uint16_t> sides_;  // of each point: the faces around it, as bits numbered as in corner_fans.hpp
  Buffer<std::uint32_t> first_around_;
  Buffer<std::uint32_t> around_;
  Buffer<std::uint32_t> first_of_chunk_;
  Buffer<Face> faces_;
  Buffer<std::uint8_t> axes_;
  std::uint32_t shells_ = 0;
  std::vector<Reservation> memory_;
};

}  // namespace isoextract::extract
