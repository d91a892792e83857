#include "edit/colormap.hpp"

#include <algorithm>
#include <cmath>

namespace isoextract::edit {

glm::dvec3 color_at(Colormap map, double place) {
  if (std::isnan(place)) return glm::dvec3(0.5);
  constexpr auto kLast = kColormapPoints - 1;
  const auto& points = colormap_points(map);
  const double at = std::clamp(place, 0.0, 1.0) * static_cast<double>(kLast);
  const std::size_t below = std::min(static_cast<std::size_t>(at), kLast - 1);
  const auto color = [](std::uint32_t rgb) {
    return glm::dvec3(rgb >> 16 & 0xFF, rgb >> 8 & 0xFF, rgb & 0xFF) / 255.0;
  };
  const double t = at - static_cast<double>(below);
  return (1 - t) * color(points[below]) + t * color(points[below + 1]);
}

}  // namespace isoextract::edit
