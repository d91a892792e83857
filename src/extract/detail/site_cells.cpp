#include "extract/detail/site_cells.hpp"

#include <bit>

#include "base/simd_targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "extract/detail/site_cells.cpp"  // included once for each instruction set
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isoextract::extract {
namespace HWY_NAMESPACE {

// Returns the case of the cell at bit `cell` of plane x.
HWY_INLINE unsigned cell_case(const SitePlanes& planes, std::size_t x, int cell) {
  unsigned bits = 0;
  for (std::size_t half = 0; half < 2; ++half) {
    for (std::size_t s = 0; s < 4; ++s) {
      bits |= static_cast<unsigned>(planes[x + half][s] >> cell & 1) << (half + 2 * s);
    }
  }
  return bits;
}

HWY_INLINE glm::ivec3 position(std::size_t x, int cell) { return {static_cast<int>(x), cell >> 3, cell & 7}; }

CellCounts count_any(const CellDrawings& drawings, const glm::ivec3& origin, const SitePlanes& planes,
                     const BlockBits& active, const VariantChooser& decider) {
  CellCounts counts;
  for (std::size_t x = 0; x < active.size(); ++x) {
    for (std::uint64_t rest = active[x]; rest != 0; rest &= rest - 1) {
      const int cell = std::countr_zero(rest);
      counts.add(drawings.of(cell_case(planes, x, cell), decider, origin, position(x, cell)));
    }
  }
  return counts;
}

void write_any(const CaseTable& table, const CellDrawings& drawings, const glm::ivec3& origin, const SitePlanes& planes,
               const BlockBits& active, const VariantChooser& decider, const SiteVertices& vertices,
               const NearSites& near, glm::uvec3* out) {
  // An edge: the sample that owns it, as a step from the cell, and the index of its direction in the table.
  struct Edge {
    int step;  // axis bits
    int offset;
    std::size_t direction;
  };
  std::array<Edge, 19> edges;
  for (std::size_t e = 0; e < table.edges.size(); ++e) {
    const int corner = table.edges[e].corner;
    const int direction = table.edges[e].direction;
    edges[e] = {corner, (corner & 1) << 6 | (corner & 2) << 2 | corner >> 2, table.index_of(direction)};
  }
  std::array<std::uint32_t, 19> numbers;
  for (std::size_t x = 0; x < active.size(); ++x) {
    for (std::uint64_t rest = active[x]; rest != 0; rest &= rest - 1) {
      const int cell = std::countr_zero(rest);
      const int offset = static_cast<int>(x) << 6 | cell;
      const unsigned bits = cell_case(planes, x, cell);
      const auto drawing = drawings.of(bits, decider, origin, position(x, cell));
      // The axes along which the cell is the last of the site: its edges there belong to the next site.
      const int last = (x == 7 ? 1 : 0) | (cell >> 3 == 7 ? 2 : 0) | ((cell & 7) == 7 ? 4 : 0);
      for (std::uint32_t crossed = drawings.crossed_edges(bits); crossed != 0; crossed &= crossed - 1) {
        const auto e = static_cast<std::size_t>(std::countr_zero(crossed));
        const int past = edges[e].step & last;
        const int back = (past & 1) << 9 | (past & 2) << 5 | (past & 4) << 1;
        const auto site = static_cast<std::size_t>(near[static_cast<std::size_t>(past)]);
        numbers[e] = vertices.at(site, edges[e].direction, offset + edges[e].offset - back);
      }
      out = drawings.write(drawing, numbers, out);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace isoextract::extract
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isoextract::extract {

HWY_EXPORT(count_any);
HWY_EXPORT(write_any);

CellCounts count_site_cells(const CellDrawings& drawings, const glm::ivec3& origin, const SitePlanes& planes,
                            const BlockBits& active, const VariantChooser& decider) {
  return HWY_DYNAMIC_DISPATCH(count_any)(drawings, origin, planes, active, decider);
}

void write_site_cells(const CaseTable& table, const CellDrawings& drawings, const glm::ivec3& origin,
                      const SitePlanes& planes, const BlockBits& active, const VariantChooser& decider,
                      const SiteVertices& vertices, const NearSites& near, glm::uvec3* out) {
  HWY_DYNAMIC_DISPATCH(write_any)(table, drawings, origin, planes, active, decider, vertices, near, out);
}

}  // namespace isoextract::extract
#endif
