// Draws a preview of meshes: framed and lit, on a light background, with a scale bar.
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
  static constexpr glm::dvec4 kUsualBackground{0.82, 0.84, 0.87, 1.0};

  PictureSize size{960, 720};
  ViewAngles angles;
  UpAxis up = UpAxis::z;
  // The box that the camera frames; if unset, the box of the meshes. Frames of a sequence with one box share a camera.
  std::optional<field::Box> box;
  double fovy = Camera::kDefaultFovy;        // vertical field of view, radians
  glm::dvec4 background = kUsualBackground;  // linear, straight alpha
  bool scale_bar = true;
  std::string unit;  // unit of world lengths, for the scale bar; may be empty
};

// Draws the surfaces with 2 x 2 rays per pixel, or with one if the doubled size would exceed PictureSize::kMaxSide.
// Depth and normals come from the nearest ray. Without a triangle the picture is the background alone, without
// a scale bar. Fails as Renderer::draw() does and, without PreviewOptions::box, as box_of() does.
[[nodiscard]] Result<Rendered> draw_preview(std::span<const Surface> surfaces, const PreviewOptions& options,
                                            Renderer& renderer, const Context& context);

// A length of 1, 2 or 5 times a power of ten, and its text.
struct ScaleBar {
  double length = 0;  // in the world
  int pixels = 0;     // at the distance of the camera's target
  std::string text;   // "20 mm"
};

// Returns the longest scale bar that is at most a quarter of the picture wide.
[[nodiscard]] ScaleBar scale_bar(const Camera& camera, const PictureSize& size, const std::string& unit);

}  // namespace isoextract::render
