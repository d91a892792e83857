// Pictures as PNG.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "files/output_file.hpp"
#include "images/light_image.hpp"

namespace isoextract::images {

// 8 bits a channel, sRGB: light is divided by alpha, cut off at 0 and 1, encoded and rounded to the nearest; alpha is
// straight and linear, and left out where every pixel's rounds to 1. NaN counts as 0. Depth and normals have no place
// in a PNG. Reserves what encoding takes; `file` is left to be committed. Fails with ErrorKind::input where memory is
// missing, and ErrorKind::output.
[[nodiscard]] Result<void> write_png(files::OutputFile& file, const LightImage& image, const Context& context);

}  // namespace isoextract::images
