// Numbers and points as people read them in messages: with few digits, and 0 in place of -0.
#pragma once

#include <string>

#include <fmt/format.h>
#include <glm/glm.hpp>

namespace isoextract {

// Returns "0.25" or "1e+30", with at most `digits` digits.
[[nodiscard]] inline std::string number_text(double value, int digits = 6) {
  return fmt::format("{:.{}g}", value + 0.0, digits);  // the sum turns -0 into 0
}

// Returns "1, 2.5, 0".
[[nodiscard]] inline std::string vector_text(const glm::dvec3& v, int digits = 6) {
  return fmt::format("{}, {}, {}", number_text(v.x, digits), number_text(v.y, digits), number_text(v.z, digits));
}

// Returns "(1, 2.5, 0)".
[[nodiscard]] inline std::string point_text(const glm::dvec3& v, int digits = 6) {
  return fmt::format("({})", vector_text(v, digits));
}

}  // namespace isoextract
