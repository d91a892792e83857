// Four numbers that the compiler processes with one vector instruction.
#pragma once

#include <bit>
#include <cstring>

#include <glm/glm.hpp>

namespace isoextract::extract {

using Float4 [[gnu::vector_size(16)]] = float;
using Int4 [[gnu::vector_size(16)]] = int;

// Reads a vector and the four bytes after it.
[[nodiscard]] inline Float4 load(const void* vector) {
  Float4 loaded;
  std::memcpy(&loaded, vector, sizeof(loaded));
  return loaded;
}

// Writes the first three numbers. The compiler would take a copy of 12 bytes on a detour through memory.
inline void store(glm::vec3& vector, Float4 value) {
  using Double2 [[gnu::vector_size(16)]] = double;
  const double first_two = std::bit_cast<Double2>(value)[0];
  std::memcpy(&vector, &first_two, sizeof(first_two));
  vector.z = value[2];
}

// Clamps each number to [-reach, reach].
[[nodiscard]] inline Float4 clamp(Float4 value, float reach) {
  const Float4 most = Float4{} + reach;
  value = value < most ? value : most;
  return value > -most ? value : -most;
}

}  // namespace isoextract::extract
