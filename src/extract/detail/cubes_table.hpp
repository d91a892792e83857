// Makes the case table of marching cubes; extractors ask case_table() for it.
#pragma once

#include "extract/cell_tables.hpp"

namespace isoextract::extract {

// Every case, with every decision of its alternating faces, and with every tunnel that the trilinear interpolant can
// have (Chernyaev's cases 4.1.2, 6.1.2, 7.4.2, 10.1.2, 12.1.2, 13.5.2 and their likes).
[[nodiscard]] CaseTable make_cubes_table();

}  // namespace isoextract::extract
