// A picture as it was computed: linear light, premultiplied, with depth and normals.
#pragma once

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "base/memory_budget.hpp"

namespace isoextract::render {

// Pixel (x, y) is element x + width * y; row 0 is the upper one.
struct Picture {
  int width = 0;
  int height = 0;
  Buffer<glm::vec4> colour;  // red, green, blue times alpha, alpha; not clamped: highlights exceed 1
  Buffer<float> depth;       // along the view axis in world units: of the first thing behind which no more than half
                             // of the light is left (a surface, or the middle of a volume's step); where there is none,
                             // of the nearest surface; +infinity where there is none of these either
  Buffer<glm::vec3> normals;  // of the surface whose depth it is, in the world, unit length and towards the eye; 0
                              // where the depth is no surface's
  Reservation memory;         // of the three

  [[nodiscard]] std::size_t pixels() const { return colour.size(); }
  static constexpr std::size_t kBytesPerPixel = sizeof(glm::vec4) + sizeof(float) + sizeof(glm::vec3);
};

// One whose pixels are not written yet. Fails with ErrorCode::input where the memory is not there.
[[nodiscard]] Result<Picture> make_picture(int width, int height, const Context& context);

}  // namespace isoextract::render
