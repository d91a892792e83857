// Color maps: numbers from 0 to 1 as colors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/glm.hpp>

#include "base/words.hpp"

namespace isoextract::edit {

enum class Colormap { viridis, plasma, magma, inferno, cividis, turbo, coolwarm, gray };
constexpr auto words_of(Colormap /*type*/) {
  return std::array{Word{Colormap::viridis, "viridis"},   Word{Colormap::plasma, "plasma"},
                    Word{Colormap::magma, "magma"},       Word{Colormap::inferno, "inferno"},
                    Word{Colormap::cividis, "cividis"},   Word{Colormap::turbo, "turbo"},
                    Word{Colormap::coolwarm, "coolwarm"}, Word{Colormap::gray, "gray"}};
}

inline constexpr std::size_t kColormapPoints = 86;

// 0xRRGGBB in sRGB, at equal distances from 0 to 1 (colormap_tables.cpp).
[[nodiscard]] const std::array<std::uint32_t, kColormapPoints>& colormap_points(Colormap map);

// sRGB, each channel from 0 to 1; linear between the points. Below 0 it is the first color, above 1 the last, and NaN
// is a grey of one half.
[[nodiscard]] glm::dvec3 color_at(Colormap map, double place);

}  // namespace isoextract::edit
