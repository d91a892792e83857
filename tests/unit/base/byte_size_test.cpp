#include "base/byte_size.hpp"

#include <gtest/gtest.h>

namespace isoextract {
namespace {

TEST(ByteSize, Parses) {
  EXPECT_EQ(parse_byte_size("0").value(), 0U);
  EXPECT_EQ(parse_byte_size("512").value(), 512U);
  EXPECT_EQ(parse_byte_size("512B").value(), 512U);
  EXPECT_EQ(parse_byte_size("16k").value(), 16U << 10);
  EXPECT_EQ(parse_byte_size("16M").value(), 16U << 20);
  EXPECT_EQ(parse_byte_size("2GB").value(), std::uint64_t{2} << 30);
  EXPECT_EQ(parse_byte_size("1.5GiB").value(), std::uint64_t{3} << 29);
  EXPECT_EQ(parse_byte_size("1T").value(), std::uint64_t{1} << 40);
}

TEST(ByteSize, RefusesInvalidSizes) {
  for (const char* text : {"", "M", "-1", "1X", "1MBs", "nan", "inf", "1e30", "12 M", "1.5GiBi"}) {
    const auto result = parse_byte_size(text);
    ASSERT_FALSE(result) << text;
    EXPECT_EQ(result.error().code, ErrorCode::usage);
  }
}

TEST(ByteSize, Formats) {
  EXPECT_EQ(format_byte_size(0), "0 B");
  EXPECT_EQ(format_byte_size(1023), "1023 B");
  EXPECT_EQ(format_byte_size(1536), "1.5 KiB");
  EXPECT_EQ(format_byte_size(1023 * 1024), "0.999 MiB");
  EXPECT_EQ(format_byte_size(std::uint64_t{2} << 30), "2 GiB");
}

}  // namespace
}  // namespace isoextract
