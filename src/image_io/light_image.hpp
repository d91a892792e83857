// The picture that the image writers take: linear light with optional depth and normals.
#pragma once

#include <cstddef>
#include <span>

#include <glm/glm.hpp>

namespace isoextract::image_io {

// Does not own its data. Pixel (x, y) is element x + width * y; row 0 is the top row.
struct LightImage {
  int width = 0;                       // at least 1
  int height = 0;                      // at least 1
  std::span<const glm::vec4> color;    // premultiplied red, green, blue, and alpha; one per pixel
  std::span<const float> depth;        // one per pixel, or empty
  std::span<const glm::vec3> normals;  // one per pixel, or empty

  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

}  // namespace isoextract::image_io
