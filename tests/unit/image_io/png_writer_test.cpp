#include "image_io/png_writer.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <png.h>

#include "support/temp_folder.hpp"

namespace isoextract::image_io {
namespace {

struct Decoded {
  png_image header{};
  std::vector<std::uint8_t> bytes;
};

Decoded decode(const std::string& bytes) {
  Decoded decoded;
  decoded.header.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&decoded.header, bytes.data(), bytes.size()), 0);
  decoded.bytes.resize(PNG_IMAGE_SIZE(decoded.header));
  EXPECT_NE(png_image_finish_read(&decoded.header, nullptr, decoded.bytes.data(), 0, nullptr), 0);
  return decoded;
}

class PngWriter : public testing::Test {
 protected:
  std::string write(int width, int height, const std::vector<glm::vec4>& colors) {
    const auto path = folder_.path() / "a.png";
    auto file = files::OutputFile::create(path).value();
    EXPECT_TRUE(write_png(file, {width, height, colors, {}, {}}, Context()));
    EXPECT_TRUE(file.commit());
    return test::read_bytes(path);
  }
  test::TempFolder folder_;
};

TEST_F(PngWriter, EncodesLightWithStraightAlpha) {
  const Decoded decoded =
      decode(write(2, 2, {{0.25F, 0.125F, 0, 0.5F}, {1, 1, 1, 1}, {0, 0, 0, 0}, {0.214F, 0.0031308F, 0.5F, 1}}));
  EXPECT_EQ(decoded.header.width, 2U);
  EXPECT_EQ(decoded.header.height, 2U);
  EXPECT_EQ(decoded.header.format, static_cast<unsigned>(PNG_FORMAT_RGBA));
  // Linear light 0.5 is 188 in sRGB, 0.25 is 137, 0.214 is 127.
  EXPECT_EQ(decoded.bytes,
            (std::vector<std::uint8_t>{188, 137, 0, 128, 255, 255, 255, 255, 0, 0, 0, 0, 127, 10, 188, 255}));
}

TEST_F(PngWriter, OmitsAlphaOfOpaquePictures) {
  const Decoded decoded = decode(write(3, 1, {{1, 0, 0, 1}, {0, 1, 0, 0.9999F}, {0, 0, 1, 1}}));
  EXPECT_EQ(decoded.header.format, static_cast<unsigned>(PNG_FORMAT_RGB));
  EXPECT_EQ(decoded.bytes, (std::vector<std::uint8_t>{255, 0, 0, 0, 255, 0, 0, 0, 255}));
}

TEST_F(PngWriter, ClampsLightAndNan) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  const Decoded decoded = decode(write(3, 1, {{7, -2, nan, 1}, {infinite, -infinite, 0, 1}, {1, 1, 1, nan}}));
  EXPECT_EQ(decoded.bytes, (std::vector<std::uint8_t>{255, 0, 0, 255, 255, 0, 0, 255, 0, 0, 0, 0}));
}

TEST_F(PngWriter, ReservesMemory) {
  auto file = files::OutputFile::create(folder_.path() / "a.png").value();
  const std::vector<glm::vec4> colors(10000);
  const Context small{MemoryBudget(40000)};
  const auto written = write_png(file, {100, 100, colors, {}, {}}, small);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_EQ(small.memory().reserved(), 0U);
}

}  // namespace
}  // namespace isoextract::image_io
