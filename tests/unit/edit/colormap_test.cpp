#include "edit/colormap.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace isoextract::edit {
namespace {

TEST(Colormap, ClampsToFirstAndLastColor) {
  const auto as_bytes = [](const glm::dvec3& c) { return glm::ivec3(glm::round(c * 255.0)); };
  EXPECT_EQ(as_bytes(color_at(Colormap::viridis, 0)), glm::ivec3(0x44, 0x01, 0x54));
  EXPECT_EQ(as_bytes(color_at(Colormap::viridis, 1)), glm::ivec3(0xFD, 0xE7, 0x25));
  EXPECT_EQ(color_at(Colormap::viridis, -3), color_at(Colormap::viridis, 0));
  EXPECT_EQ(color_at(Colormap::viridis, std::numeric_limits<double>::infinity()), color_at(Colormap::viridis, 1));
  EXPECT_EQ(color_at(Colormap::turbo, std::numeric_limits<double>::quiet_NaN()), glm::dvec3(0.5));
  EXPECT_EQ(as_bytes(color_at(Colormap::gray, 0.5)), glm::ivec3(128));
  // As in matplotlib: the middle of the diverging map is light gray, its ends are blue and red.
  EXPECT_EQ(as_bytes(color_at(Colormap::coolwarm, 0)), glm::ivec3(59, 76, 192));
  EXPECT_EQ(as_bytes(color_at(Colormap::coolwarm, 1)), glm::ivec3(180, 4, 38));
}

}  // namespace
}  // namespace isoextract::edit
