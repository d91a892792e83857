#include "render/picture.hpp"

#include <algorithm>
#include <utility>

namespace isoextract::render {

Result<Picture> make_picture(int width, int height, const Context& context) {
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  auto memory = TRY(context.reserve(pixels * Picture::kBytesPerPixel, "a picture"));
  Picture picture;
  picture.width = width;
  picture.height = height;
  picture.color = Buffer<glm::vec4>(pixels);
  picture.depth = Buffer<float>(pixels);
  picture.normals = Buffer<glm::vec3>(pixels);
  picture.memory = std::move(memory);
  return picture;
}

void cover_light(Picture& picture) {
  for (glm::vec4& color : picture.color) {
    color.a = std::max(color.a, std::min(std::max({color.r, color.g, color.b}), 1.0F));
  }
}

}  // namespace isoextract::render
