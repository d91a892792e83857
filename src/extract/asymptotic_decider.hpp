// Chooses the triangles of an ambiguous cell so that the surface has the topology of the trilinear interpolant of the
// cell's corners.
//
// Ambiguous faces: Nielson and Hamann, "The asymptotic decider", IEEE Visualization 1991. Tunnels through the cell: the
// same test in slices of the cell, see tunnel_cases.hpp.
//
// Ties follow the rule for samples: a value equal to iso is outside. A sample of value iso is therefore outside, and a
// saddle of value iso keeps the inside corners of its face apart. The drawn topology is that of the field at an iso
// value infinitesimally further inside, where no ties exist.
//
// Differences and products are long double, so that none overflows or underflows to zero, whatever the sample type.
// Products are rounded if the depths need more than half of the digits of long double. A saddle within rounding of iso
// may then fall on either side. The mesh is closed all the same: both cells at a face compute the same products of the
// same four values.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "extract/cell_tables.hpp"
#include "extract/cube_cell.hpp"
#include "extract/inside_test.hpp"

namespace isoextract::extract {

// Returns whether the bilinear interpolant joins the two inside corners of a face (or slice) whose corners alternate.
// Takes the depths of the corners (InsideRule::depth). Returns false for NaN, and if infinities leave the answer open.
[[nodiscard]] inline bool joins_inside(long double inside_a, long double inside_b, long double outside_a,
                                       long double outside_b) {
  return inside_a * inside_b > outside_a * outside_b;
}

using CornerValues = std::array<long double, 8>;  // InsideRule::depth of each corner

// Returns the alternating faces of a cell, as bits, whose inside corners are joined.
[[nodiscard]] inline unsigned joined_faces(const CaseTable& table, unsigned cell_case, const CornerValues& corners) {
  unsigned joined = 0;
  for (unsigned f = 0; f < 6; ++f) {
    if ((table.alternating_faces[cell_case] >> f & 1) == 0) continue;
    const auto& face = kCubeFaces[f];
    const std::size_t in = is_inside(cell_case, face[0]) ? 0 : 1;
    const std::size_t out = 1 - in;
    if (joins_inside(corners[face[in]], corners[face[in + 2]], corners[face[out]], corners[face[out + 2]])) {
      joined |= 1U << f;
    }
  }
  return joined;
}

// Returns the variant with a tunnel if the corner values make one, otherwise `variant`.
// A slice across z at height z = t / (s + t) has the corners s * lower + t * upper (up to a factor). D(z)
// (tunnel_cases.hpp) is a quadratic polynomial with Bernstein coefficients D0, D1, D2; its extremum is where s : t = D2
// - D1 : D0 - D1. Both ends of the range of alternating slices have the same decision. So a tunnel exists exactly if
// the extremum lies in the range and has the other decision.
[[nodiscard]] inline unsigned choose_tunnel_variant(const CaseTable& table, unsigned variant, const CornerValues& c) {
  const std::array<Tunnel, 2>& tunnels = table.tunnels[variant];
  if (tunnels[0].variant == 0 && tunnels[1].variant == 0) return variant;
  const long double d0 = c[0] * c[3] - c[1] * c[2];
  const long double d1 = (c[0] * c[7] + c[4] * c[3] - c[1] * c[6] - c[5] * c[2]) / 2;
  const long double d2 = c[4] * c[7] - c[5] * c[6];
  long double s = d2 - d1;
  long double t = d0 - d1;
  if (!(s * t > 0)) return variant;
  s = std::abs(s);
  t = std::abs(t);
  std::array<long double, 4> slice;
  for (std::size_t k = 0; k < 4; ++k) slice[k] = s * c[k] + t * c[k + 4];
  const auto alternate = [&](std::size_t in, std::size_t out) {
    return slice[in] > 0 && slice[3 - in] > 0 && slice[out] <= 0 && slice[3 - out] <= 0;
  };
  for (const std::size_t pattern : {0, 1}) {
    const std::size_t out = 1 - pattern;
    if (tunnels[pattern].variant == 0 || !alternate(pattern, out)) continue;
    const bool joined = joins_inside(slice[pattern], slice[3 - pattern], slice[out], slice[3 - out]);
    if (joined == tunnels[pattern].joins_inside) return tunnels[pattern].variant;
  }
  return variant;
}

// Returns the variant that a cell draws. `value(c)` returns the field at corner c; it is called only if the case is
// ambiguous.
template <class Value>
[[nodiscard]] unsigned cell_variant(const CaseTable& table, unsigned cell_case, const InsideRule& rule,
                                    const Value& value) {
  if (!table.ambiguous[cell_case]) return table.variants[cell_case];
  CornerValues corners;
  for (std::size_t c = 0; c < corners.size(); ++c) corners[c] = rule.depth(value(static_cast<int>(c)));
  return choose_tunnel_variant(table, table.variant(cell_case, joined_faces(table, cell_case, corners)), corners);
}

// Returns the variant that a cell draws, or nullopt if `holes` is set and a corner is NaN. Calls `value` for all eight
// corners, whether or not the case is ambiguous.
template <class Value>
[[nodiscard]] std::optional<unsigned> cell_variant_or_hole(const CaseTable& table, unsigned cell_case,
                                                           const InsideRule& rule, bool holes, const Value& value) {
  std::array<double, 8> corners;
  for (std::size_t c = 0; c < corners.size(); ++c) corners[c] = value(static_cast<int>(c));
  if (holes && std::ranges::any_of(corners, [](double f) { return std::isnan(f); })) return std::nullopt;
  return cell_variant(table, cell_case, rule, [&](int corner) { return corners[static_cast<std::size_t>(corner)]; });
}

}  // namespace isoextract::extract
