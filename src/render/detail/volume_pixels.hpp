// The pixels that may see a volume.
#pragma once

#include "render/camera.hpp"
#include "render/scene.hpp"

namespace isoextract::render::detail {

// Returns the rectangle of the pixels that may see the volume or its emission. The volume has passed check().
inline PixelBox pixels_of(const Camera& camera, const PictureSize& size, const Volume& volume) {
  const auto of_field = [&](const Volume& placed) {
    return render::pixels_of(camera, size, placed.index_to_world, *volume_box(*placed.field));
  };
  const PixelBox box = of_field(volume);
  if (volume.emission == nullptr) return box;
  const PixelBox other = of_field(*volume.emission);
  if (box.empty() || other.empty()) return box.empty() ? other : box;
  return {glm::min(box.min, other.min), glm::max(box.max, other.max)};
}

}  // namespace isoextract::render::detail
