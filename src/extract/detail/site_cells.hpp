// The cells of a site (8x8x8 samples): counts and writes their triangles. Vectorized where the CPU allows it.
#pragma once

#include <array>
#include <cstdint>

#include "extract/detail/cell_drawings.hpp"
#include "extract/site_vertices.hpp"

namespace isoextract::extract {

// The numbers, in `vertices`, of a site and of the sites at +1 along x, y, z; -1 if there is no such site. Entry n is n
// & 1, n >> 1 & 1, n >> 2 & 1 sites away.
using NearSites = std::array<std::int32_t, 8>;

// Returns the counts over the `active` cells, which are given by their lowest sample. `drawings` name edges by their
// numbers in `table`. `origin` is the origin of the site, for the decider.
[[nodiscard]] CellCounts count_site_cells(const CellDrawings& drawings, const glm::ivec3& origin,
                                          const SitePlanes& planes, const BlockBits& active,
                                          const VariantChooser& decider);

// Writes the triangles of the active cells to `out`, which must have room for as many as were counted.
void write_site_cells(const CaseTable& table, const CellDrawings& drawings, const glm::ivec3& origin,
                      const SitePlanes& planes, const BlockBits& active, const VariantChooser& decider,
                      const SiteVertices& vertices, const NearSites& near, glm::uvec3* out);

}  // namespace isoextract::extract
