// Where the trilinear interpolant of a cell can have a tunnel: two loops of the surface around the cell's faces that
// bound one piece of surface (an annulus) instead of a disc each. Found from the case and its face decisions alone;
// whether the values make the tunnel is asked where the cell is drawn (asymptotic_decider.hpp).
//
// Slices of a cell along an axis are bilinear. Where a slice's corners alternate, its inside corners are either joined
// or apart, as the sign of D(z) = a(z) d(z) - b(z) c(z) says, a quadratic polynomial (Nielson, "On marching cubes",
// IEEE TVCG 9(3), 2003; Nielson and Hamann 1991). Going along the axis, the surface changes its connection where D has
// a root in a range of alternating slices. At both ends of the range the decision follows from the case and its faces.
// So one root is what the faces already tell, and two roots, of ends that are decided alike, are a tunnel. There are no
// other topologies: two roots at most, and a surface whose Euler number differs from that of discs by two. The axis
// does not matter to the surface, hence a tunnel must show along all three, between the same two loops.
#pragma once

#include <cstdint>
#include <vector>

namespace isoextract::extract {

using Loop = std::vector<std::uint8_t>;  // indices into CaseTable::edges, in the direction of the surface's border

struct TunnelCase {
  unsigned pattern;   // slices across z alternate with corners 0 and 3 inside (0), or 1 and 2 (1)
  bool joins_inside;  // the ends of the range have the inside corners apart, the tunnel joins them; or the other way
  std::uint8_t loop_a, loop_b;  // indices into `loops`, loop_a < loop_b

  friend bool operator==(const TunnelCase&, const TunnelCase&) = default;
};

// `joined` is the set of faces whose inside corners are joined.
[[nodiscard]] std::vector<TunnelCase> tunnel_cases(unsigned cell_case, unsigned joined, const std::vector<Loop>& loops);

}  // namespace isoextract::extract
