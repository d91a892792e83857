// How ranks divide a cap (boundary_cap.hpp): by slices of samples along z. The cap is the same for any number of ranks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "base/ranks.hpp"
#include "field/samples.hpp"

namespace isoextract::extract {

// The slices of samples [begin, end) along z that a rank has, by their index in the field. Each slice has one rank.
struct RankSlices {
  Ranks* ranks = nullptr;
  int begin = 0;
  int end = 0;
  // The vertices of the first slice, which triangles of the rank before may use; none for the first rank.
  std::uint32_t first_shared_vertex = 0;
  std::uint32_t shared_vertices = 0;
};

// Returns the samples of the box that this process has: all without `share`, and no sample if it has no slice.
[[nodiscard]] field::IndexBox own_part(const field::IndexBox& box, const std::optional<RankSlices>& share);
// Returns the slice behind those of this process, which the next rank has; no sample if there is none.
[[nodiscard]] field::IndexBox part_behind(const field::IndexBox& box, const std::optional<RankSlices>& share);
// Returns the samples of both.
[[nodiscard]] field::IndexBox used_part(const field::IndexBox& box, const std::optional<RankSlices>& share);

struct BoxFace {
  int axis;     // the axis normal to the face
  bool at_max;  // at box.max, otherwise at box.min
  int u, v;     // the axes in the face; (u, v, outward) is right-handed

  // `face` is 2 * axis, plus 1 at box.max.
  static BoxFace of(int face) {
    const int axis = face / 2;
    const bool at_max = face % 2 != 0;
    const int next = (axis + 1) % 3;
    const int after = (axis + 2) % 3;
    return at_max ? BoxFace{axis, at_max, next, after} : BoxFace{axis, at_max, after, next};
  }
};

// The rows of a cap: the samples of a face with one index along BoxFace::v. The cap has them in this order.
class CapRows {
 public:
  explicit CapRows(const field::IndexBox& box);

  [[nodiscard]] std::size_t count() const { return count_; }
  // Returns the row of a sample on a face.
  [[nodiscard]] std::size_t index(int face, const glm::ivec3& p) const {
    const int v = BoxFace::of(face).v;
    return first_[static_cast<std::size_t>(face)] + static_cast<std::size_t>(p[v] - min_[v]);
  }

 private:
  glm::ivec3 min_;
  std::array<std::size_t, 6> first_{};
  std::size_t count_ = 0;
};

// Consecutive vertices or triangles of a cap.
struct CapRun {
  std::uint64_t first = 0;  // in the whole cap
  std::size_t count = 0;
};

// The places of the vertices or of the triangles of one process in the whole cap.
struct CapPlaces {
  std::uint64_t all = 0;                     // of all processes
  std::vector<std::uint64_t> first_of_rows;  // the first one of this process in each row
  std::vector<CapRun> runs;                  // the elements of this process, in order
};

// Finds the places of a process that has `counts` elements in each row. Elements of a row have the order of the ranks.
// With `share`, all ranks call this function, and it fails as Ranks::gather() does.
[[nodiscard]] Result<CapPlaces> place_in_cap(const std::vector<std::uint32_t>& counts,
                                             const std::optional<RankSlices>& share);

}  // namespace isoextract::extract
