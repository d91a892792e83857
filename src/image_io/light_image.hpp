// A picture as linear light, as image files are made from it.
#pragma once

#include <cstddef>
#include <span>

#include <glm/glm.hpp>

namespace isoextract::image_io {

// Lent. Pixel (x, y) is element x + width * y; row 0 is the upper one.
struct LightImage {
  int width = 0;                       // at least 1
  int height = 0;                      // likewise
  std::span<const glm::vec4> colour;   // red, green, blue times alpha, alpha; one a pixel
  std::span<const float> depth;        // one a pixel, or empty
  std::span<const glm::vec3> normals;  // likewise

  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

}  // namespace isoextract::image_io
