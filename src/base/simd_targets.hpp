// The instruction sets that vectorized loops are compiled for, besides Highway's plain C++ for other machines. Highway
// chooses one at run time. Include this header before Highway.
//
// AVX-512 is excluded: the loops wait for memory or for earlier results, and each instruction set costs compile time.
// SVE is excluded as well: its vectors cannot be struct members, and ARM has NEON.
#pragma once

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
