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

// DO(T) for every type of sample: for what is compiled once for each.
#define ISOEXTRACT_EACH_SAMPLE_TYPE(DO) \
  DO(std::uint8_t)                      \
  DO(std::int8_t)                       \
  DO(std::uint16_t)                     \
  DO(std::int16_t)                      \
  DO(std::uint32_t)                     \
  DO(std::int32_t)                      \
  DO(field::Half)                       \
  DO(float)                             \
  DO(double)
