// Builds the case table of marching cubes; extractors get it from case_table().
#pragma once

#include "extract/cell_tables.hpp"

namespace isoextract::extract {

// Returns the table of all cases, with all decisions of their alternating faces and all tunnels that the trilinear
// interpolant can have (Chernyaev's cases 4.1.2, 6.1.2, 7.4.2, 10.1.2, 12.1.2, 13.5.2 and their symmetric copies).
[[nodiscard]] CaseTable make_cubes_table();

}  // namespace isoextract::extract
