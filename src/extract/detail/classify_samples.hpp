// Compares runs of samples with the iso value: one bit a sample. Vectorized; InsideClassifier (inside_test.hpp) is the
// readable version of the same test.
#pragma once

#include <cstddef>
#include <cstdint>

#include "extract/inside_test.hpp"

namespace isoextract::extract {

// Sets bit b of bits[w] if sample 64 * w + b is inside; bits from `count` on are zero. Writes (count + 63) / 64 words;
// one more word must exist and may change. Returns the number of NaN samples.
template <class T>
std::uint64_t classify_samples(const T* samples, std::size_t count, const InsideThreshold<T>& threshold,
                               std::uint64_t* bits);

}  // namespace isoextract::extract

// Expands DO(T) for every sample type, for templates that are compiled once a type.
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
