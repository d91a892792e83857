// Color maps: they turn numbers from 0 to 1 into colors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/glm.hpp>

#include "base/enum_words.hpp"

namespace isoextract::edit {

enum class Colormap { viridis, plasma, magma, inferno, cividis, turbo, coolwarm, gray };
constexpr auto words_of(Colormap /*type*/) {
  return std::array{Word{Colormap::viridis, "viridis"},   Word{Colormap::plasma, "plasma"},
                    Word{Colormap::magma, "magma"},       Word{Colormap::inferno, "inferno"},
                    Word{Colormap::cividis, "cividis"},   Word{Colormap::turbo, "turbo"},
                    Word{Colormap::coolwarm, "coolwarm"}, Word{Colormap::gray, "gray"}};
}

inline constexpr std::size_t kColormapPoints = 86;

// Returns the map's colors as 0xRRGGBB in sRGB, equally spaced from 0 to 1 (colormap_tables.cpp).
[[nodiscard]] const std::array<std::uint32_t, kColormapPoints>& colormap_points(Colormap map);

// Returns the color at `place`, 0 to 1 along the map, as sRGB channels from 0 to 1. Interpolates the sRGB channels of
// the two nearest points linearly. A `place` below 0 gives the first color, above 1 the last, NaN gray (0.5).
[[nodiscard]] glm::dvec3 color_at(Colormap map, double place);

}  // namespace isoextract::edit
