// Pictures as OpenEXR.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "files/output_file.hpp"
#include "image_io/light_image.hpp"

namespace isoextract::image_io {

// Scan lines with ZIP compression, premultiplied linear light as it is: R, G, B, A as half floats (beyond 65504 they
// are infinite); where there are depths, Z as float; where there are normals, N.X, N.Y, N.Z as half floats. Reserves
// what encoding takes; `file` is left to be committed. Fails with ErrorCode::input where memory is missing, and
// ErrorCode::output.
[[nodiscard]] Result<void> write_exr(files::OutputFile& file, const LightImage& image, const Context& context);

}  // namespace isoextract::image_io
