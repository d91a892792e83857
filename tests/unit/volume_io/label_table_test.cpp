// Tests tables of label names and colors in both formats, and invalid lines.
#include "volume_io/label_table.hpp"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace isoextract::volume_io {
namespace {

constexpr std::string_view kItkSnap =
    "################################################\n"
    "# ITK-SnAP Label Description File\r\n"
    "    0     0    0    0        0  0  0    \"Clear Label\"\n"
    "    7   255    0   51        1  1  1    \"Left kidney, upper\"\r\n"
    "\n"
    "    2     0  128    0     0.25  0  1    \"Tumour #2\"";

TEST(LabelTable, ReadsItkSnapTables) {
  const auto table = LabelTable::parse(kItkSnap, "t");
  ASSERT_TRUE(table) << table.error().message;
  const std::vector<field::LabelName> expected{{0, "Clear Label", glm::dvec3(0), {}},
                                               {2, "Tumour #2", glm::dvec3(0, 128 / 255.0, 0), {}},
                                               {7, "Left kidney, upper", glm::dvec3(1, 0, 0.2), {}}};
  EXPECT_EQ(table->entries(), expected);
}

TEST(LabelTable, SkipsByteOrderMark) {
  const auto table = LabelTable::parse("\xEF\xBB\xBF#No. Label Name: R G B A\n17 Left 220 216 20 0\n", "t");
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->entries().at(0).name, "Left");
}

TEST(LabelTable, ReadsFreeSurferAndSlicerTables) {
  const auto table = LabelTable::parse(
      "#$Id$\n#No. Label Name: R G B A\n17  Left-Hippocampus  220 216  20  0\n"
      "\t-3\tnobody\t1\t2\t3\t255\n",
      "t");
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->entries().at(1).name, "Left-Hippocampus");
  EXPECT_EQ(table->entries().at(0).color, glm::dvec3(1, 2, 3) / 255.0);
  EXPECT_EQ(table->hash().size(), 32U);
  EXPECT_NE(table->hash(), LabelTable::parse(kItkSnap, "t")->hash());
}

TEST(LabelTable, RejectsInvalidTables) {
  for (const std::string_view line :
       {"1", "1 name", "1 name 1 2 3", "1 name 1 2 3 4 5", "x name 1 2 3 0", "1 name 1 2 256 0", "1 name -1 2 3 0",
        "1 name 1.5 2 3 0", "1 na me 1 2 3 0", "99999999999999999999 name 1 2 3 0", "1 name 1 2 3 x",
        "1 1 2 3 1 1 1 \"name", "1 1 2 3 1 1 1 \"", "1 1 2 3 1 1 1 \"\"", "1 1 2 3 1 1 \"name\"",
        "1 1 2 3 1 1 1 1 \"a\"", "1 1 2 300 1 1 1 \"name\"", "1 na\x01me 1 2 3 0", "1 1 2 3 1 1 1 \"na\x1b[2Jme\""}) {
    SCOPED_TRACE(line);
    const auto table = LabelTable::parse("# first\n" + std::string(line) + "\n", "lut.txt");
    ASSERT_FALSE(table);
    EXPECT_EQ(table.error().code, ErrorCode::input);
    EXPECT_TRUE(table.error().message.starts_with("lut.txt: line 2: expected a label line of ITK-SNAP"));
    EXPECT_EQ(table.error().message.find('\x1b'), std::string::npos);
  }
  EXPECT_FALSE(LabelTable::parse(std::string("1 a\0b 1 2 3 0", 13), "t"));
  EXPECT_FALSE(LabelTable::parse(std::string(100'000, '7'), "t"));
  EXPECT_LT(LabelTable::parse(std::string(100'000, '7'), "t").error().message.size(), 400U);
  for (const std::string_view nothing : {"", "\n\n", "# only this"}) {
    EXPECT_TRUE(LabelTable::parse(nothing, "t").error().message.starts_with("t: expected at least one label"))
        << nothing;
  }
  EXPECT_EQ(LabelTable::parse("1 a 1 2 3 0\n2 b 1 2 3 0\n1 c 1 2 3 0\n", "t").error().message,
            "t: expected each label once, found 1 as 'a' and as 'c'");
}

TEST(LabelTable, ChoosesDistinctDefaultColors) {
  for (std::int64_t label = -20; label < 20; ++label) {
    const glm::dvec3 color = default_label_color(label);
    for (int c = 0; c < 3; ++c) EXPECT_TRUE(color[c] >= 0 && color[c] <= 1);
    for (std::int64_t other = label + 1; other < label + 5; ++other) {
      EXPECT_GT(glm::distance(color, default_label_color(other)), 0.2) << label << " and " << other;
    }
  }
  EXPECT_EQ(default_label_color(0).x, 0.9);
  constexpr std::int64_t kId = 720575940600000017;  // a double holds neither it nor the next one
  EXPECT_GT(glm::distance(default_label_color(kId), default_label_color(kId + 1)), 0.2);
}

}  // namespace
}  // namespace isoextract::volume_io
