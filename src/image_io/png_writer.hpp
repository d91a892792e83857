// Writes pictures as PNG.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "files/output_file.hpp"
#include "image_io/light_image.hpp"

namespace isoextract::image_io {

// An image file in memory.
struct EncodedImage {
  std::shared_ptr<ReservedBuffer<std::byte>> buffer;  // can be longer than the file
  std::size_t size = 0;

  [[nodiscard]] std::span<const std::byte> bytes() const { return buffer->values.span().first(size); }
};

// Encodes a picture with 8 bits per channel in sRGB. Divides the light by alpha, clamps it to [0, 1], encodes it and
// rounds to nearest; NaN becomes 0. Alpha is straight and linear, and is omitted if it rounds to 255 everywhere. PNG
// cannot store depth and normals.
// Reserves the memory for encoding. `name` starts messages. Fails with ErrorCode::out_of_memory if memory is short,
// and with ErrorCode::output if encoding fails.
[[nodiscard]] Result<EncodedImage> encode_png(const LightImage& image, const std::string& name, const Context& context);

// Writes the PNG to `file` and does not commit it. Fails as encode_png() does, or if writing fails.
[[nodiscard]] Result<void> write_png(files::OutputFile& file, const LightImage& image, const Context& context);

}  // namespace isoextract::image_io
