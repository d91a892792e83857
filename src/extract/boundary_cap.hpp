// Caps the surface at the faces of a box of samples: the inside part of every boundary square becomes triangles.
//
// A cap vertex stands at every inside sample of the box's faces. The other corners of cap polygons are vertices that
// the surface already has on edges in these faces, so the cap is welded to the surface. A square with alternating
// corners uses the decision of the cell behind it (asymptotic_decider.hpp). For methods with edges across cell faces, a
// square is split into the same two triangles as in its cell.
//
// The vertices and the triangles of a cap come face by face, and in a face row by row. If ranks share the volume, each
// makes the elements of its slices: a piece of some rows, and other rows as a whole (cap_shares.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "extract/asymptotic_decider.hpp"
#include "extract/cap_shares.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/extractor.hpp"
#include "field/samples.hpp"

namespace isoextract::extract {

struct BoundaryCap {
  std::vector<glm::ivec3> samples;    // positions of the cap vertices, in the order of their numbers
  std::vector<glm::uvec3> triangles;  // vertex numbers; counter-clockwise seen from outside in right-handed index space
  // Where the samples and triangles are in the whole cap; if this process makes all of it, one run for each.
  CapPlaces sample_places;
  CapPlaces triangle_places;

  [[nodiscard]] bool empty() const { return samples.empty() && triangles.empty(); }
};

namespace detail {

// Calls visit(face number, box face, sample) face by face for the samples in `part` of the box. A sample on several
// faces is visited once for each.
template <class Visit>
void for_each_boundary_sample(const field::IndexBox& box, const field::IndexBox& part, const Visit& visit) {
  for (int face = 0; face < 6; ++face) {
    const BoxFace f = BoxFace::of(face);
    glm::ivec3 p;
    p[f.axis] = f.at_max ? box.max[f.axis] : box.min[f.axis];
    if (p[f.axis] < part.min[f.axis] || p[f.axis] > part.max[f.axis]) continue;
    for (p[f.v] = part.min[f.v]; p[f.v] <= part.max[f.v]; ++p[f.v]) {
      for (p[f.u] = part.min[f.u]; p[f.u] <= part.max[f.u]; ++p[f.u]) visit(face, f, p);
    }
  }
}

using Square = std::array<glm::ivec3, 4>;  // four samples, counter-clockwise seen from outside

// Calls visit(face number, box face, square) for every square of the six faces whose first corner is in `part`.
template <class Visit>
void for_each_boundary_square(const field::IndexBox& box, const field::IndexBox& part, const Visit& visit) {
  for_each_boundary_sample(box, part, [&](int face, const BoxFace& f, const glm::ivec3& p) {
    if (p[f.u] == box.max[f.u] || p[f.v] == box.max[f.v]) return;
    glm::ivec3 du(0);
    glm::ivec3 dv(0);
    du[f.u] = 1;
    dv[f.v] = 1;
    visit(face, f, Square{p, p + du, p + du + dv, p + dv});
  });
}

// The vertex number of each sample on the six faces of `box`, in `part` of it. A sample on several faces is stored with
// the first of them.
class CapVertexNumbers {
 public:
  CapVertexNumbers(const field::IndexBox& box, const field::IndexBox& part)
      : box_(box), min_(part.min), dims_(part.dims()) {
    for (int face = 0; face < 6; ++face) {
      const BoxFace f = BoxFace::of(face);
      const int plane = f.at_max ? box.max[f.axis] : box.min[f.axis];
      if (plane < part.min[f.axis] || plane > part.max[f.axis]) continue;
      numbers_[face].resize(static_cast<std::size_t>(dims_[f.u] * dims_[f.v]));
    }
  }

  [[nodiscard]] int first_face(const glm::ivec3& p) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (p[axis] == box_.min[axis]) return 2 * axis;
      if (p[axis] == box_.max[axis]) return 2 * axis + 1;
    }
    return -1;
  }

  std::uint32_t& of(const glm::ivec3& p) {
    const int face = first_face(p);
    const BoxFace f = BoxFace::of(face);
    return numbers_[face][static_cast<std::size_t>(p[f.u] - min_[f.u] + dims_[f.u] * (p[f.v] - min_[f.v]))];
  }

 private:
  field::IndexBox box_;
  glm::ivec3 min_;
  glm::i64vec3 dims_;
  std::array<std::vector<std::uint32_t>, 6> numbers_;
};

}  // namespace detail

// Returns the cap of `box`, or the share of one rank in it. The callbacks take samples by index:
// - inside(p): whether the sample is inside;
// - edge_vertex(p, direction): the surface vertex on the crossed edge from sample p along the axis bits `direction`;
// - depth(p): InsideRule::depth of the sample;
// - missing(p): whether the sample is missing (NaN); squares with a missing corner are left out.
// Cap vertices are numbered from `first_number`. `whole_squares` is MethodTraits::axis_edges_only; if false, each
// square is split into two triangles first. With `share`, all ranks call this function, and it fails as Ranks::gather()
// does; the callbacks get samples of its slices and of the one behind.
template <class Inside, class EdgeVertex, class Depth, class Missing>
Result<BoundaryCap> make_boundary_cap(const field::IndexBox& box, const std::optional<RankSlices>& share,
                                      bool whole_squares, std::uint32_t first_number, const Inside& inside,
                                      const EdgeVertex& edge_vertex, const Depth& depth, const Missing& missing) {
  BoundaryCap cap;
  const field::IndexBox own = own_part(box, share);
  const field::IndexBox behind = part_behind(box, share);
  detail::CapVertexNumbers numbers(box, used_part(box, share));

  // Adds the inside part of a polygon of samples. Each run of inside corners, with the crossings before and after it,
  // is a convex polygon. It becomes a fan around the crossing before the run, or around a corner if all corners are
  // inside.
  const auto fill = [&](std::span<const glm::ivec3> corners) {
    const std::size_t count = corners.size();
    std::array<bool, 4> in{};
    for (std::size_t c = 0; c < count; ++c) in[c] = inside(corners[c]);
    const auto crossing = [&](std::size_t c) {
      const glm::ivec3& a = corners[c];
      const glm::ivec3& b = corners[(c + 1) % count];
      const glm::ivec3 low = glm::min(a, b);  // edges lead upward along each of their axes
      return edge_vertex(low, step_direction(glm::max(a, b) - low));
    };
    const auto fan = [&](std::span<const std::uint32_t> ring) {
      for (std::size_t i = 1; i + 1 < ring.size(); ++i) cap.triangles.push_back({ring[0], ring[i], ring[i + 1]});
    };
    std::array<std::uint32_t, 6> ring{};
    if (std::all_of(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(count), [](bool b) { return b; })) {
      for (std::size_t c = 0; c < count; ++c) ring[c] = numbers.of(corners[c]);
      fan({ring.data(), count});
      return;
    }
    const bool alternating = count == 4 && in[0] == in[2] && in[1] == in[3];
    const std::size_t a = in[0] ? 0 : 1;  // an inside corner, if the square alternates
    const std::size_t b = 1 - a;
    if (alternating && in[0] != in[1] &&
        joins_inside(depth(corners[a]), depth(corners[a + 2]), depth(corners[b]), depth(corners[b + 2]))) {
      // The fan starts at a corner, so that no diagonal joins two crossings: the cell behind may draw such a diagonal.
      fan(std::array{numbers.of(corners[a]), crossing(a), crossing(a + 1), numbers.of(corners[a + 2]), crossing(a + 2),
                     crossing((a + 3) % 4)});
      return;
    }
    for (std::size_t start = 0; start < count; ++start) {
      if (in[start] || !in[(start + 1) % count]) continue;
      std::size_t size = 0;
      ring[size++] = crossing(start);
      std::size_t c = (start + 1) % count;
      for (; in[c]; c = (c + 1) % count) ring[size++] = numbers.of(corners[c]);
      ring[size++] = crossing((c + count - 1) % count);
      fan({ring.data(), size});
    }
  };

  const CapRows rows(box);
  std::vector<std::uint32_t> counts(rows.count());
  detail::for_each_boundary_sample(box, own, [&](int face, const BoxFace&, const glm::ivec3& p) {
    if (numbers.first_face(p) != face || !inside(p)) return;
    ++counts[rows.index(face, p)];
    cap.samples.push_back(p);
  });
  cap.sample_places = TRY(place_in_cap(counts, share));
  std::vector<std::uint64_t> next = cap.sample_places.first_of_rows;
  const auto number = [&](int face, const glm::ivec3& p) {
    numbers.of(p) = first_number + static_cast<std::uint32_t>(next[rows.index(face, p)]++);
  };
  for (const glm::ivec3& p : cap.samples) number(numbers.first_face(p), p);
  // The next rank has these samples, but squares between the ranks use them.
  detail::for_each_boundary_sample(box, behind, [&](int face, const BoxFace&, const glm::ivec3& p) {
    if (numbers.first_face(p) == face && inside(p)) number(face, p);
  });

  std::ranges::fill(counts, 0U);
  detail::for_each_boundary_square(box, own, [&](int face, const BoxFace&, const detail::Square& square) {
    if (std::any_of(square.begin(), square.end(), missing)) return;
    const std::size_t before = cap.triangles.size();
    if (whole_squares) {
      fill(square);
    } else {
      fill(std::array{square[0], square[1], square[2]});
      fill(std::array{square[0], square[2], square[3]});
    }
    counts[rows.index(face, square.front())] += static_cast<std::uint32_t>(cap.triangles.size() - before);
  });
  cap.triangle_places = TRY(place_in_cap(counts, share));
  return cap;
}

// Returns whether the cell behind a boundary square has no missing sample (missing(p) is true for none of its eight).
template <class Missing>
[[nodiscard]] bool has_complete_cell_behind(const BoxFace& face, const detail::Square& square, const Missing& missing) {
  glm::ivec3 inward(0);
  inward[face.axis] = face.at_max ? -1 : 1;
  return std::ranges::none_of(square, [&](const glm::ivec3& p) { return missing(p) || missing(p + inward); });
}

// Returns whether any cell at the faces of the box draws triangles that reach the face. Cells with a missing sample
// draw nothing. Returns true if a square has inside and outside corners, and the cell behind it has no missing sample.
template <class Inside, class Missing>
[[nodiscard]] bool draws_at_boundary(const field::IndexBox& box, const Inside& inside, const Missing& missing) {
  bool found = false;
  detail::for_each_boundary_square(box, box, [&](int, const BoxFace& face, const detail::Square& square) {
    if (found) return;
    const auto in = std::ranges::count_if(square, inside);
    found = in != 0 && in != std::ssize(square) && has_complete_cell_behind(face, square, missing);
  });
  return found;
}

// Returns whether a cell at the faces of the box draws triangles at one crossed edge. This edge goes from `p` along
// `axis` and lies in a face of the box.
template <class Missing>
[[nodiscard]] bool draws_beside_edge(const field::IndexBox& box, const glm::ivec3& p, int axis,
                                     const Missing& missing) {
  glm::ivec3 along(0);
  along[axis] = 1;
  for (int number = 0; number < 6; ++number) {
    const auto face = BoxFace::of(number);
    if (face.axis == axis || p[face.axis] != (face.at_max ? box.max : box.min)[face.axis]) continue;
    const int other = 3 - axis - face.axis;
    glm::ivec3 beside(0);
    beside[other] = 1;
    if (p[other] < box.max[other] &&
        has_complete_cell_behind(face, {p, p + along, p + along + beside, p + beside}, missing)) {
      return true;
    }
    if (p[other] > box.min[other] &&
        has_complete_cell_behind(face, {p, p + along, p + along - beside, p - beside}, missing)) {
      return true;
    }
  }
  return false;
}

// Returns the sum of the outward axes of the faces that contain `p`, as a covector in index space.
[[nodiscard]] inline glm::dvec3 boundary_normal(const field::IndexBox& box, const glm::ivec3& p) {
  return glm::dvec3(glm::equal(p, box.max)) - glm::dvec3(glm::equal(p, box.min));
}

}  // namespace isoextract::extract
