#include "extract/detail/tunnel_cases.hpp"

#include <algorithm>
#include <array>

#include "extract/cube_cell.hpp"

namespace isoextract::extract {
namespace {

// The cell seen along an axis: four columns of two corners each. In alternating slices, two opposite columns are
// inside. A column is named by its lower corner.
class SlicedCell {
 public:
  SlicedCell(unsigned cell_case, unsigned joined, unsigned axis, unsigned pattern)
      : cell_case_(cell_case), joined_(joined), axis_(axis) {
    const unsigned u = 1U << (axis + 1) % 3;
    const unsigned v = 1U << (axis + 2) % 3;
    inside_ = pattern == 0 ? Pair{0, u | v} : Pair{u, v};
    outside_ = pattern == 0 ? Pair{u, v} : Pair{0, u | v};
  }

  // Returns whether every column has a corner on the side that the pattern requires.
  [[nodiscard]] bool can_alternate() const {
    const auto fits_somewhere = [&](unsigned column) { return fits(column, 0) || fits(column, 1); };
    return std::ranges::all_of(inside_, fits_somewhere) && std::ranges::all_of(outside_, fits_somewhere);
  }

  // Returns whether inside corners are joined at the end of the range of alternating slices toward `side`.
  [[nodiscard]] bool joined_at(unsigned side) const {
    const auto misfit = [&](unsigned column) { return !fits(column, side); };
    if (std::ranges::none_of(inside_, misfit) && std::ranges::none_of(outside_, misfit)) {
      return face_is_joined(2 * axis_ + side);
    }
    // The range ends where the last misfit column crosses iso. If that is an inside column, the inside corners are
    // apart there; if it is an outside column, they are joined. With one misfit of each kind, the side face that both
    // share tells which one is last.
    return std::ranges::any_of(outside_, [&](unsigned q) {
      return misfit(q) && std::ranges::all_of(inside_, [&](unsigned p) {
               return !misfit(p) || face_is_joined(cube_side_face(p, q, axis_));
             });
    });
  }

  // Returns the two loops whose surfaces surround the inside columns (or the outside ones) in alternating slices.
  [[nodiscard]] std::array<std::uint8_t, 2> loops_around(bool inside, const std::vector<Loop>& loops) const {
    const Pair& columns = inside ? inside_ : outside_;
    const unsigned other = (inside ? outside_ : inside_)[0];
    std::array<std::uint8_t, 2> found{loop_between(columns[0], other, loops), loop_between(columns[1], other, loops)};
    std::ranges::sort(found);
    return found;
  }

 private:
  using Pair = std::array<unsigned, 2>;

  [[nodiscard]] unsigned corner(unsigned column, unsigned side) const { return column | side << axis_; }
  [[nodiscard]] bool fits(unsigned column, unsigned side) const {
    return is_inside(cell_case_, corner(column, side)) == (std::ranges::count(inside_, column) != 0);
  }
  [[nodiscard]] bool face_is_joined(unsigned face) const { return (joined_ >> face & 1) != 0; }

  // Returns the loop that passes between two neighboring columns, one inside and one outside. Finds it by an edge that
  // it crosses: the edge between the columns at a side where both fit, else the edge along `column`.
  [[nodiscard]] std::uint8_t loop_between(unsigned column, unsigned other, const std::vector<Loop>& loops) const {
    std::uint8_t edge = cube_edge(corner(column, 0), corner(column, 1));
    for (const unsigned side : {0U, 1U}) {
      if (fits(column, side) && fits(other, side)) edge = cube_edge(corner(column, side), corner(other, side));
    }
    const auto found = std::ranges::find_if(loops, [&](const Loop& l) { return std::ranges::count(l, edge) != 0; });
    return static_cast<std::uint8_t>(found - loops.begin());
  }

  unsigned cell_case_;
  unsigned joined_;
  unsigned axis_;
  Pair inside_{};
  Pair outside_{};
};

std::vector<TunnelCase> along_axis(unsigned axis, unsigned cell_case, unsigned joined, const std::vector<Loop>& loops) {
  std::vector<TunnelCase> found;
  for (unsigned pattern = 0; pattern < 2; ++pattern) {
    const SlicedCell cell(cell_case, joined, axis, pattern);
    if (!cell.can_alternate()) continue;
    const bool ends_joined = cell.joined_at(0);
    if (cell.joined_at(1) != ends_joined) continue;
    const auto [a, b] = cell.loops_around(!ends_joined, loops);
    if (a != b) found.push_back({pattern, !ends_joined, a, b});
  }
  return found;
}

}  // namespace

std::vector<TunnelCase> tunnel_cases(unsigned cell_case, unsigned joined, const std::vector<Loop>& loops) {
  std::vector<TunnelCase> tunnels = along_axis(2, cell_case, joined, loops);
  for (const unsigned axis : {0U, 1U}) {
    const std::vector<TunnelCase> seen = along_axis(axis, cell_case, joined, loops);
    std::erase_if(tunnels, [&](const TunnelCase& t) {
      return std::ranges::none_of(seen, [&](const TunnelCase& s) {
        return s.joins_inside == t.joins_inside && s.loop_a == t.loop_a && s.loop_b == t.loop_b;
      });
    });
  }
  // If all six faces alternate (Chernyaev's case 13), a tunnel needs three faces of each decision around opposite
  // corners (13.5). It can then join inside or outside corners. The rule above would accept more, because it does not
  // check that the three axes agree.
  const bool all_alternate = cell_case == 0b01101001 || cell_case == 0b10010110;
  const auto joins_inside = [](const TunnelCase& t) { return t.joins_inside; };
  if (all_alternate && (std::ranges::all_of(tunnels, joins_inside) || std::ranges::none_of(tunnels, joins_inside))) {
    tunnels.clear();
  }
  return tunnels;
}

}  // namespace isoextract::extract
