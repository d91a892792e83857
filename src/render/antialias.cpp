#include "render/antialias.hpp"

#include <algorithm>

namespace isoextract::render {
namespace {

// Returns the picture with its width and height divided by `across`. Colors are means, which is right for premultiplied
// light.
Result<Picture> reduced(const Picture& fine, int across, const Context& context) {
  auto made = make_picture(fine.width / across, fine.height / across, context);
  if (!made) return made;
  Picture& coarse = *made;
  const float share = 1.0F / static_cast<float>(across * across);
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) {
      glm::vec4 sum{0.0F};
      const auto index = [&](int column, int row) {
        return static_cast<std::size_t>(across * x + column) +
               static_cast<std::size_t>(fine.width) * static_cast<std::size_t>(across * y + row);
      };
      std::size_t nearest = index(0, 0);
      for (int row = 0; row < across; ++row) {
        for (int column = 0; column < across; ++column) {
          const std::size_t i = index(column, row);
          sum += fine.color[i];
          if (fine.depth[i] < fine.depth[nearest]) nearest = i;
        }
      }
      const std::size_t at =
          static_cast<std::size_t>(x) + static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(y);
      coarse.color[at] = share * sum;
      coarse.depth[at] = fine.depth[nearest];
      coarse.normals[at] = fine.normals[nearest];
    }
  }
  return made;
}

}  // namespace

Result<Rendered> draw_antialiased(Renderer& renderer, const Scene& scene, const Camera& camera,
                                  const RenderOptions& options, int across, const Context& context) {
  const int longest = std::max({options.size.width, options.size.height, 1});
  const int fitting = std::clamp(PictureSize::kMaxSide / longest, 1, across);
  if (fitting == 1) return renderer.draw(scene, camera, options, context);
  RenderOptions fine = options;
  fine.size = {fitting * options.size.width, fitting * options.size.height};
  auto rendered = renderer.draw(scene, camera, fine, context);
  if (!rendered) return rendered;
  rendered->picture = TRY(reduced(rendered->picture, fitting, context));
  return rendered;
}

}  // namespace isoextract::render
