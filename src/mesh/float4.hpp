// Four floats at a time, with the vectors that GCC and Clang have for every machine.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

namespace isoextract::mesh {

using Float4 = float __attribute__((vector_size(16)));

// Reads four floats that follow each other in memory.
[[nodiscard]] inline Float4 load4(const float* from) {
  Float4 lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}

[[nodiscard]] inline Float4 splat4(float lane) { return Float4{lane, lane, lane, lane}; }

// Moves the first lane after the other three. load4() from one float before a vec3, then last_three(), reads the last
// vec3 of an array without reading beyond the array.
[[nodiscard]] inline Float4 last_three(const Float4& v) { return Float4{v[1], v[2], v[3], v[0]}; }

// Where a lane of one operand is NaN, these return the lane of b.
[[nodiscard]] inline Float4 min4(const Float4& a, const Float4& b) { return a < b ? a : b; }
[[nodiscard]] inline Float4 max4(const Float4& a, const Float4& b) { return a > b ? a : b; }

[[nodiscard]] inline Float4 magnitude4(const Float4& v) { return max4(v, -v); }

// The result of a comparison: all bits of a lane are 1 or 0.
using Mask4 = decltype(Float4{} < Float4{});

[[nodiscard]] inline bool any4(const Mask4& mask) {
  std::array<std::uint64_t, 2> bits;
  static_assert(sizeof(bits) == sizeof(mask));
  std::memcpy(bits.data(), &mask, sizeof(bits));
  return (bits[0] | bits[1]) != 0;
}
[[nodiscard]] inline bool all4(const Mask4& mask) { return !any4(~mask); }

}  // namespace isoextract::mesh
