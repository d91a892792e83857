// Formats of samples as textures of unsigned integers.
#pragma once

#include <epoxy/gl.h>

#include <string>

#include "extract/inside_test.hpp"
#include "field/sample_type.hpp"

namespace isoextract::gpu {

struct SampleFormat {
  GLenum internal;  // GL_R8UI, ...
  GLenum format;
  GLenum type;
  std::string define;  // "SAMPLE_U8"
};

[[nodiscard]] SampleFormat sample_format(field::SampleType type);

// Returns the bits of a stored number, low word first.
template <class T>
[[nodiscard]] glm::uvec2 sample_words(T sample) {
  if constexpr (std::is_same_v<T, field::Half>) return {sample.bits(), 0};
  if constexpr (std::is_same_v<T, float>) return {std::bit_cast<std::uint32_t>(sample), 0};
  if constexpr (std::is_same_v<T, double>) {
    const auto bits = std::bit_cast<std::uint64_t>(sample);
    return {static_cast<std::uint32_t>(bits), static_cast<std::uint32_t>(bits >> 32)};
  }
  if constexpr (std::is_integral_v<T>) return {static_cast<std::make_unsigned_t<T>>(sample), 0};
}

// The inside numbers as a range of ordered keys, both ends included, as computed by ordered_key() of field.glsl.
struct KeyRange {
  glm::uvec2 from;
  glm::uvec2 to;
};

template <class T>
[[nodiscard]] KeyRange inside_keys(const extract::InsideThreshold<T>& threshold) {
  using Order = extract::OrderedKey<T>;
  const auto words = [](auto key) {
    const auto wide = static_cast<std::uint64_t>(key);
    return glm::uvec2(static_cast<std::uint32_t>(wide), static_cast<std::uint32_t>(wide >> 32));
  };
  const auto key = Order::key(threshold.threshold);
  return threshold.above ? KeyRange{words(key), words(Order::kHighest)} : KeyRange{words(Order::kLowest), words(key)};
}

}  // namespace isoextract::gpu
