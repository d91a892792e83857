#include "points/simulation_box.hpp"

#include <fmt/format.h>

#include "base/number_text.hpp"

namespace isoextract::points {

std::string box_text(const SimulationBox& box) {
  if (box.is_upright()) {
    return fmt::format("{} .. {}", point_text(box.origin), point_text(box.world_from_fractions()(glm::dvec3(1))));
  }
  return fmt::format("origin {}, edges a {}, b {}, c {}", point_text(box.origin), point_text(box.edges[0]),
                     point_text(box.edges[1]), point_text(box.edges[2]));
}

std::string periodic_text(const SimulationBox& box) {
  std::string text;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!box.periodic[k]) continue;
    if (!text.empty()) text += ", ";
    text += (box.is_upright() ? "xyz" : "abc")[k];
  }
  return text.empty() ? "none" : text;
}

}  // namespace isoextract::points
