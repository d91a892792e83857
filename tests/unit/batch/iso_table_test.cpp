#include "batch/iso_table.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "support/temp_folder.hpp"

namespace isoextract::batch {
namespace {

using convert::IsoChoice;
using Isos = std::vector<IsoChoice>;

IsoTable parsed_table(const std::string& text) {
  const auto parsed = IsoTable::parse(text, "iso.csv");
  EXPECT_TRUE(parsed) << (parsed ? "" : parsed.error().message);
  return parsed.value_or(IsoTable());
}

Isos isos_of_frame(const IsoTable& table, std::int64_t frame) {
  const auto found = table.isos_of(frame);
  return {found.begin(), found.end()};
}

std::string table_refusal(const std::string& text) {
  const auto parsed = IsoTable::parse(text, "iso.csv");
  if (parsed) return "accepted";
  EXPECT_EQ(parsed.error().code, ErrorCode::input);
  return parsed.error().message;
}

TEST(IsoTable, ReturnsValuesOfEachFrame) {
  const IsoTable some = parsed_table("frame,iso\n1,0.15\n-2,1e-3\n3,-4\n1,0.1\n");
  EXPECT_EQ(isos_of_frame(some, 1), (Isos{0.15, 0.1}));  // in the order of the rows
  EXPECT_EQ(isos_of_frame(some, -2), Isos{0.001});
  EXPECT_EQ(isos_of_frame(some, 3), Isos{-4});
  EXPECT_TRUE(isos_of_frame(some, 2).empty());
}

TEST(IsoTable, ParsesIsoValueWords) {
  const IsoTable some = parsed_table("frame,iso\n1,auto\n2,p99.9\n1,p50\n2,0.5\n");
  EXPECT_EQ(isos_of_frame(some, 1), (Isos{IsoChoice::suggested(), IsoChoice::percentile(field::Percent(50))}));
  EXPECT_EQ(isos_of_frame(some, 2), (Isos{*convert::iso_choice_of("p99.9"), 0.5}));
  EXPECT_EQ(table_refusal("frame,iso\n1,p50\n1,0.5\n1,p50.0\n"),
            "iso.csv:4: expected iso p50 of frame 1 once, found the same pair in line 2");
  for (const char* word : {"Auto", "p", "p101", "50%", "P9", "inf"}) {
    EXPECT_NE(table_refusal(std::string("frame,iso\n1,") + word + "\n"), "accepted") << word;
  }
}

TEST(IsoTable, AcceptsOtherColumnsAndSeparators) {
  for (const char separator : {',', ';', '\t'}) {
    std::string text = "note,ISO,volume,Frame\nwater,0.5,,7\n,0.25,x y,8\n";
    std::ranges::replace(text, ',', separator);
    const IsoTable some = parsed_table(text);
    EXPECT_EQ(isos_of_frame(some, 7), Isos{0.5}) << separator;
    EXPECT_EQ(isos_of_frame(some, 8), Isos{0.25}) << separator;
  }
  EXPECT_EQ(isos_of_frame(parsed_table("frame;iso;a,b\n1;2;3,4\n"), 1), Isos{2});
}

TEST(IsoTable, AcceptsSpreadsheetFiles) {
  const IsoTable some = parsed_table(
      "\xef\xbb\xbf# by hand\r\n\r\n  # and more\r\n \"frame\" , \"iso\",\"say \"\"no\"\"\"\r\n 1 , \"0.5\" "
      ",\"a,b\"\r\n\r\n#end\r\n2,0.75,");
  EXPECT_EQ(isos_of_frame(some, 1), Isos{0.5});
  EXPECT_EQ(isos_of_frame(some, 2), Isos{0.75});
}

TEST(IsoTable, RequiresBothColumnsOnce) {
  EXPECT_EQ(table_refusal("1,0.5\n2,0.6\n"),
            "iso.csv:1: expected a header with one column 'frame' and one 'iso', found '1,0.5'");
  EXPECT_EQ(table_refusal("# x\nframe,value\n"),
            "iso.csv:2: expected a header with one column 'frame' and one 'iso', found 'frame,value'");
  for (const char* text :
       {"frame,iso,iso\n1,2,3\n", "iso\n1\n", "frame iso\n1 2\n", "frame,frame,iso\n1,1,2\n", "\"frame,iso\n1,2\n",
        "\xff\xfe"
        "f"}) {
    EXPECT_NE(table_refusal(text), "accepted") << text;
  }
  for (const char* text : {"", "\n\n", "# frame,iso\n", "\xef\xbb\xbf"}) {
    EXPECT_EQ(table_refusal(text), "iso.csv: expected a header with the columns 'frame' and 'iso', found no line");
  }
}

TEST(IsoTable, RefusesInvalidValuesWithLine) {
  const std::string header = "frame,iso\n1,0.5\n";
  EXPECT_EQ(table_refusal(header + "2,abc\n"),
            "iso.csv:3: expected a finite number, auto, zero or a percentile from p0 to p100, found 'abc'");
  EXPECT_EQ(table_refusal(header + "\n#\n2.5,1\n"), "iso.csv:5: expected the number of a frame, found '2.5'");
  for (const char* row : {"2,", ",1", "2,nan", "2,inf", "2,1e999", "2,0x10", "2,1 2", "2,--1", "9223372036854775807,1",
                          "1000000000000000000,1", "2,1\r\r3", "2,\x1b", "x"}) {
    EXPECT_NE(table_refusal(header + row + "\n"), "accepted") << row;
  }
  EXPECT_EQ(table_refusal(header + "2,\x1b[2J\n"),
            "iso.csv:3: expected a finite number, auto, zero or a percentile from p0 to p100, found '\\x1b[2J'");
  EXPECT_NE(table_refusal(header + std::string("2,1\0", 4)), "accepted");
  EXPECT_LT(table_refusal(header + "2," + std::string(1 << 20, 'x')).size(), 140U);
}

TEST(IsoTable, DistinguishesDecimalCommasFromSeparators) {
  EXPECT_EQ(table_refusal("frame,iso\n1,0,15\n"), "iso.csv:2: expected 2 fields as in the header, found 3");
  EXPECT_EQ(table_refusal("frame;iso\n1;0,15\n2;0.15\n"),
            "iso.csv:3: expected an iso value with the decimal mark ',' of the rows before, found '0.15'");
  EXPECT_EQ(table_refusal("frame,iso,x\n1,2\n"), "iso.csv:2: expected 3 fields as in the header, found 2");
}

TEST(IsoTable, RefusesUnclosedQuotes) {
  const std::string message = "iso.csv:2: expected quotes around whole fields, found ";
  EXPECT_EQ(table_refusal("frame,iso,x\n1,2,\"a\nb\"\n"), message + "'1,2,\"a'");
  EXPECT_EQ(table_refusal("frame,iso,x\n1,\"2\"3,\n"), message + "'1,\"2\"3,'");
  EXPECT_EQ(table_refusal("frame,iso,x\n1,2,\""), message + "'1,2,\"'");
  EXPECT_EQ(table_refusal("frame,iso,x\n1,2,\"\"\""), message + "'1,2,\"\"\"'");
}

TEST(IsoTable, RefusesRepeatedRow) {
  EXPECT_EQ(table_refusal("frame,iso\n1,0.5\n2,0.5\n1,0.50\n"),
            "iso.csv:4: expected iso 0.5 of frame 1 once, found the same pair in line 2");
  EXPECT_NE(table_refusal("frame,iso\n1,0\n1,-0.0\n"), "accepted");
}

TEST(IsoTable, RequiresRowForEveryFrame) {
  const IsoTable some = parsed_table("frame,iso\n1,0.5\n2,0.5\n3,0.5\n9,1\n");
  EXPECT_TRUE(some.check_covers(std::vector<std::int64_t>{1, 3}));
  const auto covers = some.check_covers(std::vector<std::int64_t>{7, 1, 5, 4, 6, 2, 20});
  ASSERT_FALSE(covers);
  EXPECT_EQ(covers.error().message, "iso.csv: expected a row for every frame, found none for 4-7,20");
  EXPECT_EQ(covers.error().code, ErrorCode::input);
}

TEST(IsoTable, ReadsFile) {
  const test::TempFolder folder;
  test::write_bytes(folder / "a\n.csv", "frame,iso\n1,0.5\n2,x\n");
  const auto damaged = IsoTable::read(folder / "a\n.csv", Context());
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().message.find("a\\n.csv:3: "), std::string::npos) << damaged.error().message;
  test::write_bytes(folder / "b.csv", "frame,iso\n1,0.5");
  const auto sound = IsoTable::read(folder / "b.csv", Context());
  ASSERT_TRUE(sound);
  EXPECT_EQ(isos_of_frame(*sound, 1), Isos{0.5});
  EXPECT_FALSE(IsoTable::read(folder / "gone.csv", Context()));
  EXPECT_FALSE(IsoTable::read(folder.path(), Context()));
}

TEST(IsoTable, ParsesManyRows) {
  std::string text = "frame,iso\n";
  for (int i = 200000; i > 0; --i) text += std::to_string(i) + ",0." + std::to_string(i) + "\n";
  const IsoTable some = parsed_table(text);
  EXPECT_EQ(isos_of_frame(some, 123456), Isos{0.123456});
}

}  // namespace
}  // namespace isoextract::batch
