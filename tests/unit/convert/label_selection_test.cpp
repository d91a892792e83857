#include "convert/label_selection.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "convert/detail/label_files.hpp"

namespace isoextract::convert {
namespace {

bool has(std::string_view text, std::int64_t label, std::string_view name = {}) {
  auto selection = LabelSelection::parse(text);
  EXPECT_TRUE(selection) << text;
  return selection && selection->contains(label, name);
}

TEST(LabelSelection, MatchesNumbersRangesAndNames) {
  EXPECT_TRUE(has("1-40,Hippocampus*,!Skull", 1, "a"));
  EXPECT_TRUE(has("1-40,Hippocampus*,!Skull", 40));
  EXPECT_FALSE(has("1-40,Hippocampus*,!Skull", 41));
  EXPECT_TRUE(has("1-40,Hippocampus*,!Skull", 41, "Hippocampus left"));
  EXPECT_FALSE(has("1-40,Hippocampus*,!Skull", 2, "Skull"));
  EXPECT_TRUE(has("-5--3", -4));
  EXPECT_FALSE(has("-5--3", 4));
  EXPECT_TRUE(has("-7-2", 0));
  // Ids of connectomics: neighbors that a double cannot tell apart.
  EXPECT_TRUE(has("720575940600000017", 720575940600000017));
  EXPECT_FALSE(has("720575940600000017", 720575940600000018));
  EXPECT_TRUE(has("all,!3", std::numeric_limits<std::int64_t>::max()));
}

TEST(LabelSelection, SelectsTheRestIfAllTermsExclude) {
  EXPECT_TRUE(has("!Skull,!3", 4, "Bone"));
  EXPECT_FALSE(has("!Skull,!3", 3, "Bone"));
  EXPECT_FALSE(has("!Skull,!3", 4, "Skull"));
  EXPECT_FALSE(has("3,!1-5", 3));
}

TEST(LabelSelection, MatchesStarsAndQuestionMarks) {
  EXPECT_TRUE(has("*", 1, "x"));
  EXPECT_FALSE(has("*", 1));  // no name
  EXPECT_TRUE(has("L?ft*cortex*", 1, "Left cortex"));
  EXPECT_TRUE(has("*a*b*c", 1, "aXbYabc"));
  EXPECT_FALSE(has("*a*b*c", 1, "aXbYcab"));
  EXPECT_FALSE(has("left*", 1, "Left cortex"));
  EXPECT_TRUE(has("B?ro", 1, "B\u00fcro"));  // a character of two bytes
  EXPECT_FALSE(has("B??ro", 1, "B\u00fcro"));
  EXPECT_TRUE(has("*?", 1, "\u8178"));
  EXPECT_TRUE(has("3rd-Ventricle", 14, "3rd-Ventricle"));
}

TEST(LabelSelection, RefusesMalformedTerms) {
  for (const char* text : {"", "1,", ",1", "!", "1-3,!", "5-3"}) EXPECT_FALSE(LabelSelection::parse(text)) << text;
}

TEST(LabelSelection, ListsTermsWithoutALabel) {
  auto selection = LabelSelection::parse("1,Kidney*,90-99,5,Skull,!7");
  ASSERT_TRUE(selection);
  EXPECT_TRUE(selection->contains(1, {}));
  using Terms = std::vector<LabelSelection::UnmatchedTerm>;
  EXPECT_EQ(selection->unmatched(), (Terms{{"Kidney*", false}, {"90-99", false}, {"5", true}, {"Skull", true}}));
  EXPECT_TRUE(selection->contains(5, "Skull"));
  EXPECT_TRUE(selection->contains(95, "Kidney left"));
  EXPECT_TRUE(selection->unmatched().empty());
}

TEST(LabelSelection, RecognizesASingleName) {
  for (const char* text : {"Skull", "3rd-Ventricle"}) EXPECT_TRUE(LabelSelection::parse(text)->is_one_name()) << text;
  for (const char* text : {"Skull,Brain", "!Skull", "Sk*", "?kull", "1-4", "all", "5"}) {
    EXPECT_FALSE(LabelSelection::parse(text)->is_one_name()) << text;
  }
}

TEST(LabelFileNames, GiveEachLabelItsOwnName) {
  EXPECT_FALSE(LabelFileNames("out_{piece}.stl").in_use());
  LabelFileNames names("o/{label}_{name}.stl");
  EXPECT_TRUE(names.in_use());
  EXPECT_EQ(names.next(5, "Left/kidney"), "o/5_Left_kidney.stl");
  EXPECT_EQ(names.next(6, ""), "o/6_label 6.stl");
  LabelFileNames by_name("{name}.stl");
  EXPECT_EQ(by_name.next(1, "twin"), "twin.stl");
  EXPECT_EQ(by_name.next(2, "twin"), "twin_2.stl");
  EXPECT_EQ(by_name.next(2, "twin"), "twin_2_2.stl");  // of another layer
  EXPECT_EQ(by_name.next(3, "{label}"), "{label}.stl");
}

}  // namespace
}  // namespace isoextract::convert
