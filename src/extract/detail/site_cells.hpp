// The cells of a site (8x8x8 samples): counts and writes their triangles. Vectorized where the CPU allows it.
#pragma once

#include <array>
#include <cstdint>

#include "extract/detail/cell_drawings.hpp"
#include "extract/site_vertices.hpp"

namespace isoextract::extract {

// The numbers, in SiteVertices, of a site and its upper neighbors; -1 if there is no such site. Bits 0, 1 and 2 of the
// index are the steps along x, y and z.
using NearSites = std::array<std::int32_t, 8>;

// Returns the counts over the `active` cells, which are given by their lowest sample. `decider` chooses the variants of
// ambiguous cells; it needs `origin`, the lowest sample of the site.
[[nodiscard]] CellCounts count_site_cells(const CellDrawings& drawings, const glm::ivec3& origin,
                                          const SitePlanes& planes, const BlockBits& active,
                                          const VariantChooser& decider);

// Writes the triangles of the active cells to `out`, which must have room for all counted triangles. `drawings` must
// name edges by their numbers in `table`.
void write_site_cells(const CaseTable& table, const CellDrawings& drawings, const glm::ivec3& origin,
                      const SitePlanes& planes, const BlockBits& active, const VariantChooser& decider,
                      const SiteVertices& vertices, const NearSites& near, glm::uvec3* out);

}  // namespace isoextract::extract
