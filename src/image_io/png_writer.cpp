#include "image_io/png_writer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <png.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "base/srgb.hpp"

namespace isoextract::image_io {
namespace {

// Clamps to [0, 1]; NaN becomes 0.
double cut_off(double v) { return v > 0 ? std::min(v, 1.0) : 0; }

std::uint8_t byte_of(double v) { return static_cast<std::uint8_t>(std::lround(255 * cut_off(v))); }

void encode_row(std::span<const glm::vec4> row, int channels, std::uint8_t* out) {
  for (const glm::vec4& pixel : row) {
    const double alpha = cut_off(double{pixel.a});
    for (int c = 0; c < 3; ++c) {
      *out++ = byte_of(alpha > 0 ? linear_to_srgb(cut_off(double{pixel[c]} / alpha)) : 0);
    }
    if (channels == 4) *out++ = byte_of(alpha);
  }
}

}  // namespace

Result<EncodedImage> encode_png(const LightImage& image, const std::string& name, const Context& context) {
  const bool opaque = std::ranges::all_of(image.color, [](const glm::vec4& p) { return byte_of(double{p.a}) == 255; });
  const int channels = opaque ? 3 : 4;
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = opaque ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;

  const std::size_t row_bytes = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(channels);
  const std::string what = name + ": a picture as PNG";
  const auto rows =
      TRY(make_reserved_buffer<std::uint8_t>(row_bytes * static_cast<std::size_t>(image.height), context, what));
  auto encoded = TRY(make_reserved_buffer<std::byte>(PNG_IMAGE_PNG_SIZE_MAX(header), context, what));

  for_each_index(static_cast<std::size_t>(image.height), [&](std::size_t y) {
    const auto width = static_cast<std::size_t>(image.width);
    encode_row(image.color.subspan(y * width, width), channels, rows->values.data() + y * row_bytes);
  });
  png_alloc_size_t size = encoded->values.size();
  if (png_image_write_to_memory(&header, encoded->values.data(), &size, 0, rows->values.data(), 0, nullptr) == 0) {
    return fail(ErrorCode::output, name + ": libpng cannot encode the picture: " + header.message);
  }
  return EncodedImage{std::move(encoded), size};
}

Result<void> write_png(files::OutputFile& file, const LightImage& image, const Context& context) {
  const auto encoded = encode_png(image, file.shown_name(), context);
  return encoded ? file.write(encoded->bytes()) : tl::unexpected(encoded.error());
}

}  // namespace isoextract::image_io
