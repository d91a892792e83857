#include "extract/detail/cell_drawings.hpp"

#include "extract/cube_cell.hpp"

namespace isoextract::extract {

CellDrawings::CellDrawings(const CaseTable& table, bool mirrored, bool decide_all, std::span<const std::uint8_t> names)
    : directions_(static_cast<int>(table.directions.size())) {
  const auto name = [&](std::uint8_t edge) { return names.empty() ? edge : names[edge]; };
  for (const CellTriangle& t : table.triangles) {
    triangles_.push_back({name(t[0]), name(t[mirrored ? 2 : 1]), name(t[mirrored ? 1 : 2]), 0});
  }
  for (std::size_t v = 0; v + 1 < table.first.size(); ++v) {
    by_variant_.push_back({table.first[v], static_cast<std::uint8_t>(table.first[v + 1] - table.first[v])});
  }
  for (unsigned c = 0; c < by_case_.size(); ++c) {
    by_case_[c] = by_variant_[table.variants[c]];
    by_case_[c].decided = decide_all || table.ambiguous[c];
    for (std::size_t e = 0; e < table.edges.size(); ++e) {
      const unsigned low = table.edges[e].corner;
      const unsigned high = low | table.edges[e].direction;
      if (is_inside(c, low) != is_inside(c, high)) crossed_edges_[c] |= 1U << e;
    }
  }
}

}  // namespace isoextract::extract
