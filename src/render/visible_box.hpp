// The part of a scene that a camera should frame.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/affine.hpp"
#include "render/scene.hpp"

namespace isoextract::render {

// Returns the box, in the world, around all vertices and the visible parts of the volume and its emission. Beyond each
// face of the visible part lies at most 1/1000 of the sum of the samples' extinctions, for an emission of their light,
// so that single samples of noise do not count. Takes a sparse field whole if one of its tiles is visible, and both
// fields whole if neither has a visible sample. Reads all samples.
// The box does not depend on the number of threads. Fails as box_of(), Context::reserve() and Context::check() do.
[[nodiscard]] Result<field::Box> visible_box_of(const Scene& scene, const Context& context);

}  // namespace isoextract::render
