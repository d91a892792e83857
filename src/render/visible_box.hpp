// The part of a scene that a camera should frame.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/affine.hpp"
#include "render/scene.hpp"

namespace isoextract::render {

// Returns the box, in the world, around all vertices and the visible part of the volume. Beyond each face of the
// visible part lies at most 1/1000 of the sum of the samples' extinctions, so that single samples of noise do not
// count. Takes the whole volume if no sample is visible, or if a tile of a sparse field is visible. Reads all samples.
// The box does not depend on the number of threads. Fails as box_of(), Context::reserve() and Context::check() do.
[[nodiscard]] Result<field::Box> visible_box_of(const Scene& scene, const Context& context);

}  // namespace isoextract::render
