// Antialiasing: draws pictures with several rays per pixel.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "render/renderer.hpp"

namespace isoextract::render {

inline constexpr int kMostRaysAcross = 4;

// Draws the scene with `across` x `across` rays per pixel, evenly spread, or with fewer if a side of `options.size`
// times `across` would exceed PictureSize::kMaxSide. `across` is from 1 to kMostRaysAcross. A pixel's color is the mean
// of its rays; depth and normal come from its nearest ray. The statistics count all rays. Fails as Renderer::draw()
// does.
[[nodiscard]] Result<Rendered> draw_antialiased(Renderer& renderer, const Scene& scene, const Camera& camera,
                                                const RenderOptions& options, int across, const Context& context);

}  // namespace isoextract::render
