// Writes pictures as OpenEXR.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "files/output_file.hpp"
#include "image_io/light_image.hpp"

namespace isoextract::image_io {

// Writes scan lines with ZIP compression and does not commit `file`. Channels: R, G, B, A as half floats, premultiplied
// linear light up to 65504, the largest half float; Z as float if there are depths; N.X, N.Y, N.Z as half floats if
// there are normals. Reserves the memory for encoding. Fails with
// ErrorCode::out_of_memory if memory is short, and with ErrorCode::output if encoding or writing fails.
[[nodiscard]] Result<void> write_exr(files::OutputFile& file, const LightImage& image, const Context& context);

}  // namespace isoextract::image_io
