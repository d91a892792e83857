// A first look at meshes: framed, lit, on a light ground, with a scale bar.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/affine.hpp"
#include "render/camera.hpp"
#include "render/renderer.hpp"
#include "render/scene.hpp"

namespace isoextract::render {

struct PreviewOptions {
  PictureSize size{960, 720};
  ViewAngles angles;
  UpAxis up = UpAxis::z;
  std::optional<field::Box> box;  // what is framed, so that frames have one camera; nothing: the meshes' own box
  bool scale_bar = true;
  std::string unit;  // of lengths in the world, for the scale bar; may be empty
};

// Drawn with four views a pixel where the picture is at most half as large as the largest. Depth and normals are those
// of the nearest of the four. Without a surface, or where the surfaces are empty, there is the ground alone. Fails as
// Renderer::draw() does.
[[nodiscard]] Result<Rendered> draw_preview(std::span<const Surface> surfaces, const PreviewOptions& options,
                                            Renderer& renderer, const Context& context);

// A length that is 1, 2 or 5 times a power of ten, and how it is written.
struct ScaleBar {
  double length = 0;  // in the world
  int pixels = 0;     // at the distance of the camera's target
  std::string text;   // "20 mm"
};

// The longest that is at most a quarter of the picture wide.
[[nodiscard]] ScaleBar scale_bar(const Camera& camera, const PictureSize& size, const std::string& unit);

}  // namespace isoextract::render
