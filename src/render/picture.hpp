// A rendered picture: premultiplied linear light, with depth and normals.
#pragma once

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "base/memory_budget.hpp"

namespace isoextract::render {

// Pixel (x, y) is element x + width * y; row 0 is the top row.
struct Picture {
  int width = 0;
  int height = 0;
  Buffer<glm::vec4> color;  // premultiplied red, green, blue, and alpha; not clamped, so highlights exceed 1
  // Depth along the view axis in world units: of the first surface fragment, or of the middle of the first slab, at
  // which the transmittance falls to 1/2 or less. If the transmittance stays above 1/2: of the nearest surface
  // fragment; +infinity without one.
  Buffer<float> depth;
  // Unit normal of the surface at that depth, in the world, toward the eye; 0 if no surface lies there.
  Buffer<glm::vec3> normals;
  Reservation memory;  // of the three buffers

  [[nodiscard]] std::size_t pixels() const { return color.size(); }
  static constexpr std::size_t kBytesPerPixel = sizeof(glm::vec4) + sizeof(float) + sizeof(glm::vec3);
};

// Makes a picture with uninitialized pixels. Fails with ErrorCode::out_of_memory if memory is short.
[[nodiscard]] Result<Picture> make_picture(int width, int height, const Context& context);

// Raises the alpha of each pixel to its brightest channel, at most 1. Files with straight alpha cannot hold light where
// the picture is transparent: the raised alpha keeps it, and over black the picture looks the same.
void cover_light(Picture& picture);

}  // namespace isoextract::render
