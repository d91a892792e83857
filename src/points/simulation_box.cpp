#include "points/simulation_box.hpp"

#include <fmt/format.h>

namespace isoextract::points {
namespace {

std::string vector_text(const glm::dvec3& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x, v.y, v.z); }

}  // namespace

std::string box_text(const SimulationBox& box) {
  if (box.is_upright()) {
    return fmt::format("{} .. {}", vector_text(box.origin), vector_text(box.world_from_fractions()(glm::dvec3(1))));
  }
  return fmt::format("origin {}, edges a {}, b {}, c {}", vector_text(box.origin), vector_text(box.edges[0]),
                     vector_text(box.edges[1]), vector_text(box.edges[2]));
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
