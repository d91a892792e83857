// Comparing runs of samples with iso: one bit a sample. Vectorised; InsideClassifier (inside_test.hpp) says the same in
// plain words.
#pragma once

#include <cstddef>
#include <cstdint>

#include "extract/inside_test.hpp"

namespace isoextract::extract {

// Bit b of bits[w] is set where sample 64 * w + b is inside; bits beyond `count` are zero. Writes (count + 63) / 64
// words; one word more must be there, and may change. Returns how many samples are NaN.
template <class T>
std::uint64_t classify_samples(const T* samples, std::size_t count, const InsideThreshold<T>& threshold,
                               std::uint64_t* bits);

}  // namespace isoextract::extract
