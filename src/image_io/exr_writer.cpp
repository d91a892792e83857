#include "image_io/exr_writer.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <functional>
#include <new>
#include <string>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <half.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"

namespace isoextract::image_io {
namespace {

// Collects the file in memory, because OpenEXR seeks back to fill in offsets.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream(const char* name, std::size_t expected) : Imf::OStream(name) { bytes_.reserve(expected); }

  void write(const char data[], int count) override {
    const std::size_t end = at_ + static_cast<std::size_t>(count);
    if (end > bytes_.size()) bytes_.resize(end);
    std::memcpy(bytes_.data() + at_, data, static_cast<std::size_t>(count));
    at_ = end;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t place) override { at_ = place; }

  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;
};

// Returns an upper bound of the file's bytes: the pixels, the header, the line table, and the overhead of
// incompressible blocks.
std::uint64_t max_file_bytes(std::uint64_t pixel_bytes, int height) {
  return pixel_bytes + pixel_bytes / 64 + 16 * static_cast<std::uint64_t>(height) + (std::uint64_t{1} << 16U);
}

void encode(MemoryStream& stream, const LightImage& image, std::span<Imath::half> halves) {
  const std::size_t pixels = image.pixels();
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer frame;
  const auto width = static_cast<std::size_t>(image.width);
  // Each channel has its own plane in `halves`.
  const auto add = [&](const char* name, const std::function<float(std::size_t)>& value) {
    const std::span<Imath::half> plane = halves.first(pixels);
    halves = halves.subspan(pixels);
    for_each_index(pixels / width, [&](std::size_t y) {
      for (std::size_t i = y * width; i < (y + 1) * width; ++i) plane[i] = value(i);
    });
    header.channels().insert(name, Imf::Channel(Imf::HALF));
    frame.insert(name, Imf::Slice::Make(Imf::HALF, plane.data(), {0, 0}, image.width, image.height));
  };
  static constexpr std::array kColors{"R", "G", "B", "A"};
  // More would become infinite, and a mask of 0 would make NaN of it.
  constexpr auto kMost = static_cast<float>(HALF_MAX);
  for (int c = 0; c < 4; ++c)
    add(kColors[static_cast<std::size_t>(c)], [&, c](std::size_t i) { return std::min(image.color[i][c], kMost); });
  static constexpr std::array kNormals{"N.X", "N.Y", "N.Z"};
  for (int c = 0; c < 3 && !image.normals.empty(); ++c) {
    add(kNormals[static_cast<std::size_t>(c)], [&, c](std::size_t i) { return image.normals[i][c]; });
  }
  if (!image.depth.empty()) {
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    frame.insert("Z", Imf::Slice::Make(Imf::FLOAT, image.depth.data(), {0, 0}, image.width, image.height));
  }
  Imf::OutputFile writer(stream, header);
  writer.setFrameBuffer(frame);
  writer.writePixels(image.height);
}

}  // namespace

Result<void> write_exr(files::OutputFile& file, const LightImage& image, const Context& context) {
  const std::string what = file.shown_name() + ": a picture as OpenEXR";
  const std::size_t channels = image.normals.empty() ? 4 : 7;
  const auto halves = TRY(make_reserved_buffer<Imath::half>(channels * image.pixels(), context, what));
  const std::uint64_t expected = max_file_bytes(halves->values.size_bytes() + image.depth.size_bytes(), image.height);
  const auto memory = TRY(context.reserve(expected, what));
  try {
    MemoryStream stream(file.shown_name().c_str(), static_cast<std::size_t>(expected));
    encode(stream, image, halves->values.span());
    return file.write(stream.bytes());
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& problem) {
    return fail(ErrorCode::output, file.shown_name() + ": OpenEXR cannot encode the picture: " + problem.what());
  }
}

}  // namespace isoextract::image_io
