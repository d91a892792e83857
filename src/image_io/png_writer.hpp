// Pictures as PNG.
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
  std::shared_ptr<ReservedBuffer<std::byte>> buffer;  // longer than the file
  std::size_t size = 0;

  [[nodiscard]] std::span<const std::byte> bytes() const { return buffer->values.span().first(size); }
};

// 8 bits a channel, sRGB: light is divided by alpha, cut off at 0 and 1, encoded and rounded to the nearest; alpha is
// straight and linear, and left out where every pixel's rounds to 1. NaN counts as 0. Depth and normals have no place
// in a PNG. Reserves what encoding takes; `name` starts messages. Fails with ErrorCode::input where memory is missing.
[[nodiscard]] Result<EncodedImage> encode_png(const LightImage& image, const std::string& name, const Context& context);

// The same into a file, which is left to be committed. Fails with ErrorCode::output as well.
[[nodiscard]] Result<void> write_png(files::OutputFile& file, const LightImage& image, const Context& context);

}  // namespace isoextract::image_io
