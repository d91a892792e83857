#include "render/preview.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "render/antialias.hpp"
#include "render/picture_text.hpp"

namespace isoextract::render {
namespace {

constexpr int kRaysAcross = 2;  // of a pixel

// A light from the upper left, and a weaker one from the right, so that no side is black.
const std::vector<Light>& preview_lights() {
  static const std::vector<Light> lights{Light{{-0.4, 0.6, 0.7}, true, glm::dvec3(0.9)},
                                         Light{{0.8, 0.1, 0.4}, true, glm::dvec3(0.25)}};
  return lights;
}

void draw_scale_bar(Picture& picture, const ScaleBar& bar, const glm::vec3& color) {
  const int dot = std::max(1, picture.height / 360);
  const int margin = 8 * dot;
  const glm::ivec2 low{margin, picture.height - margin};
  fill_box(picture, {low.x, low.y - 2 * dot}, {low.x + bar.pixels, low.y}, color);
  for (const int x : {low.x, low.x + bar.pixels - dot})
    fill_box(picture, {x, low.y - 6 * dot}, {x + dot, low.y}, color);
  const glm::ivec2 words = text_size(bar.text, dot);
  draw_text(picture, {low.x + (bar.pixels - words.x) / 2, low.y - 7 * dot - words.y}, bar.text, dot, color);
}

bool is_empty(const Surface& surface) { return surface.mesh->triangles.empty(); }

}  // namespace

ScaleBar scale_bar(const Camera& camera, const PictureSize& size, const std::string& unit) {
  const double of_pixel = 2 * camera.unit() * std::tan(camera.fovy / 2) / size.height;
  const double most = 0.25 * size.width * of_pixel;
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  double length = power;
  for (const double times : {2.0, 5.0}) {
    if (times * power <= most) length = times * power;
  }
  return {length, std::max(1, static_cast<int>(std::lround(length / of_pixel))),
          unit.empty() ? fmt::format("{:.6g}", length) : fmt::format("{:.6g} {}", length, unit)};
}

Result<Rendered> draw_preview(std::span<const Surface> surfaces, const PreviewOptions& options, Renderer& renderer,
                              const Context& context) {
  Scene scene;
  scene.lights = preview_lights();
  scene.background = options.background;
  std::ranges::remove_copy_if(surfaces, std::back_inserter(scene.surfaces), is_empty);
  field::Box box{glm::dvec3(-1), glm::dvec3(1)};
  if (options.box) {
    box = *options.box;
  } else if (!scene.surfaces.empty()) {
    box = TRY(box_of(scene));
  }
  RenderOptions drawn;
  drawn.size = options.size;
  const Camera camera = frame_box_closely(box, options.angles, options.up, options.size, options.fovy);
  auto rendered = draw_antialiased(renderer, scene, camera, drawn, kRaysAcross, context);
  if (!rendered) return rendered;
  if (options.scale_bar && !scene.surfaces.empty()) {
    draw_scale_bar(rendered->picture, scale_bar(camera, options.size, options.unit), text_color(options.background));
  }
  return rendered;
}

}  // namespace isoextract::render
