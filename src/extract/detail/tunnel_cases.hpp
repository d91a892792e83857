// Finds the cases where the trilinear interpolant of a cell can have a tunnel. Two loops of the surface around the
// cell's faces then bound one annulus instead of a disc each. The case and its face decisions are enough to find the
// possible tunnels; asymptotic_decider.hpp tests the values when a cell is drawn.
//
// Slices of a cell along an axis are bilinear. If the corners of a slice alternate, its inside corners are joined or
// apart. The sign of D(z) = a(z) d(z) - b(z) c(z), a quadratic polynomial, tells which (Nielson, "On marching cubes",
// IEEE TVCG 9(3), 2003; Nielson and Hamann 1991). Along the axis, the surface changes its connection at each root of D
// within a range of alternating slices.
//
// The case and its faces fix the decision at both ends of the range. So a single root is already known from the faces.
// Two roots, with equal decisions at both ends, are a tunnel. No other topology is possible: D has at most two roots,
// and the surface's Euler number differs from that of discs by two. The surface does not depend on the axis, so a
// tunnel must appear along all three axes, between the same two loops.
#pragma once

#include <cstdint>
#include <vector>

namespace isoextract::extract {

using Loop = std::vector<std::uint8_t>;  // indices into CaseTable::edges, in the direction of the surface's boundary

struct TunnelCase {
  unsigned pattern;   // 0: alternating slices across z have corners 0 and 3 inside; 1: corners 1 and 2
  bool joins_inside;  // true: inside corners are apart at the ends of the range and the tunnel joins them; false: the
                      // reverse
  std::uint8_t loop_a, loop_b;  // indices into `loops`, loop_a < loop_b

  friend bool operator==(const TunnelCase&, const TunnelCase&) = default;
};

// Returns the possible tunnels of a case. `joined` has bit f set if the inside corners of face f are joined; `loops`
// are the loops of this variant.
[[nodiscard]] std::vector<TunnelCase> tunnel_cases(unsigned cell_case, unsigned joined, const std::vector<Loop>& loops);

}  // namespace isoextract::extract
