// Which instruction sets vectorised loops are compiled for, besides Highway's plain C++ for machines that have none of
// them. Highway chooses among them when the program runs. To be included before Highway.
//
// AVX-512 is left out: the loops wait for memory or for one another, and each set costs compile time. So is SVE: its
// vectors cannot be members of structs, and ARM has NEON.
#pragma once

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
