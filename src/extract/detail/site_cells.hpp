// The cells of a site (8 x 8 x 8 samples): how many triangles they draw, and the triangles. Vectorised instructions are
// used where the machine has them.
#pragma once

#include <array>
#include <cstdint>

#include "extract/detail/cell_drawings.hpp"
#include "extract/site_vertices.hpp"

namespace isoextract::extract {

// Where the vertices of a site's cells are: the numbers, in `vertices`, of the site and of those at +1 along x, y, z
// (entry n is n & 1, n >> 1 & 1, n >> 2 & 1 sites away), or -1.
using NearSites = std::array<std::int32_t, 8>;

// `drawings` call edges by their numbers in `table`. `active` are the cells, by their lowest sample. `origin` is that
// of the site, for the decider.
[[nodiscard]] CellCounts count_site_cells(const CellDrawings& drawings, const glm::ivec3& origin,
                                          const SitePlanes& planes, const BlockBits& active,
                                          const CellDecider& decider);

void write_site_cells(const CaseTable& table, const CellDrawings& drawings, const glm::ivec3& origin,
                      const SitePlanes& planes, const BlockBits& active, const CellDecider& decider,
                      const SiteVertices& vertices, const NearSites& near, glm::uvec3* out);

}  // namespace isoextract::extract
