// Four numbers that the compiler processes with one vector instruction.
#pragma once

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

inline void store(glm::vec3& vector, Float4 value) { std::memcpy(&vector, &value, sizeof(vector)); }

// Clamps each number to [-reach, reach].
[[nodiscard]] inline Float4 clamp(Float4 value, float reach) {
  const Float4 most = Float4{} + reach;
  value = value < most ? value : most;
  return value > -most ? value : -most;
}

}  // namespace isoextract::extract
