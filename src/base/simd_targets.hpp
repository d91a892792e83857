// The instruction sets that vectorized loops are compiled for, besides Highway's plain C++ for other machines. Highway
// chooses one at run time. Include this header before Highway.
//
// AVX-512 is excluded: the loops wait for memory or for earlier results, and each instruction set costs compile time.
// SVE is excluded as well: its vectors cannot be struct members, and ARM has NEON.
//
// The vectorized loops are classify_samples, cell_rows, site_cells and vertex_batch in extract, spline_sums in points,
// and slab_batch in render. Each has a scalar version in the code (InsideClassifier, edge_crossing, OutputPlacement) or
// in a test. Tests compare the two bit for bit with every instruction set of the machine:
// `tests/unit/extract/vectorized_test.cpp`, `points/kernel_test.cpp` and `render/vectorized_test.cpp`. Only the
// exponentials of rays may differ, in the last digits of a double. Sums keep their order, and the compiler fuses no
// operations (-ffp-contract=off), because the GPU and the tests rely on equal bits. Measure changes of the loops
// in extract with build/bench/extraction_benchmark, one input at a time, on a quiet machine.
#pragma once

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
