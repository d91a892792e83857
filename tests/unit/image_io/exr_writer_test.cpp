#include "image_io/exr_writer.hpp"

#include <limits>
#include <string>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <gtest/gtest.h>

#include "support/temp_folder.hpp"

namespace isoextract::image_io {
namespace {

constexpr int kAcross = 37;
constexpr int kDown = 21;

struct Light {
  std::vector<glm::vec4> colors;
  std::vector<float> depths;
  std::vector<glm::vec3> normals;

  Light() {
    for (int y = 0; y < kDown; ++y) {
      for (int x = 0; x < kAcross; ++x) {
        const float f = static_cast<float>(x) / kAcross + static_cast<float>(y);
        colors.emplace_back(f, 1 / (1 + f), -f, 0.5F);
        depths.push_back(x == 3 ? std::numeric_limits<float>::infinity() : 1e5F + f);
        normals.emplace_back(0.1F * f, 1, -0.25F);
      }
    }
  }
};

std::vector<std::string> names_of(const Imf::InputFile& file) {
  std::vector<std::string> names;
  for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c)
    names.emplace_back(c.name());
  return names;
}

std::vector<float> channel(Imf::InputFile& file, const char* name) {
  std::vector<float> values(std::size_t{kAcross} * kDown);
  Imf::FrameBuffer frame;
  frame.insert(name, Imf::Slice::Make(Imf::FLOAT, values.data(), {0, 0}, kAcross, kDown));
  file.setFrameBuffer(frame);
  file.readPixels(0, kDown - 1);
  return values;
}

TEST(ExrWriter, ReadsBackEveryChannel) {
  const test::TempFolder folder;
  const auto path = folder.path() / "a.exr";
  const Light light;
  auto file = files::OutputFile::create(path).value();
  ASSERT_TRUE(write_exr(file, {kAcross, kDown, light.colors, light.depths, light.normals}, Context()));
  ASSERT_TRUE(file.commit());

  Imf::InputFile read(path.c_str());
  EXPECT_EQ(names_of(read), (std::vector<std::string>{"A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z"}));
  EXPECT_EQ(read.header().channels()["R"].type, Imf::HALF);
  EXPECT_EQ(read.header().channels()["Z"].type, Imf::FLOAT);
  const char* const colors[] = {"R", "G", "B", "A"};
  for (int c = 0; c < 4; ++c) {
    const std::vector<float> values = channel(read, colors[c]);
    for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], float{Imath::half(light.colors[i][c])});
  }
  const char* const normals[] = {"N.X", "N.Y", "N.Z"};
  for (int c = 0; c < 3; ++c) {
    const std::vector<float> values = channel(read, normals[c]);
    for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], float{Imath::half(light.normals[i][c])});
  }
  EXPECT_EQ(channel(read, "Z"), light.depths);
}

TEST(ExrWriter, OmitsMissingDepthAndNormals) {
  const test::TempFolder folder;
  const auto path = folder.path() / "a.exr";
  const Light light;
  auto file = files::OutputFile::create(path).value();
  ASSERT_TRUE(write_exr(file, {kAcross, kDown, light.colors, {}, {}}, Context()));
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(names_of(Imf::InputFile(path.c_str())), (std::vector<std::string>{"A", "B", "G", "R"}));
}

TEST(ExrWriter, KeepsBrightLightFinite) {
  const test::TempFolder folder;
  const auto path = folder.path() / "a.exr";
  Light light;
  light.colors[5].r = 1e6F;
  light.colors[6].r = std::numeric_limits<float>::infinity();
  light.colors[7].r = 65000;
  auto file = files::OutputFile::create(path).value();
  ASSERT_TRUE(write_exr(file, {kAcross, kDown, light.colors, {}, {}}, Context()));
  ASSERT_TRUE(file.commit());
  Imf::InputFile read(path.c_str());
  const std::vector<float> red = channel(read, "R");
  EXPECT_EQ(red[5], 65504);
  EXPECT_EQ(red[6], 65504);
  EXPECT_EQ(red[7], float{Imath::half(65000)});
}

TEST(ExrWriter, ReservesMemory) {
  const test::TempFolder folder;
  auto file = files::OutputFile::create(folder.path() / "a.exr").value();
  const Light light;
  const Context small{MemoryBudget(10000)};
  const auto written = write_exr(file, {kAcross, kDown, light.colors, light.depths, light.normals}, small);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_EQ(small.memory().reserved(), 0U);
}

}  // namespace
}  // namespace isoextract::image_io
