#include "batch/detail/sequences.hpp"

#include <gtest/gtest.h>

namespace isoextract::batch {
namespace {

// Returns "PATTERN: number number ..." for every sequence.
std::vector<std::string> described(const std::vector<std::string>& names) {
  std::vector<std::string> lines;
  for (const Sequence& sequence : sequences_of(names)) {
    std::string line = sequence.pattern + ":";
    for (const SequenceMember& member : sequence.members) line += " " + std::to_string(member.number);
    lines.push_back(line);
  }
  return lines;
}

using Lines = std::vector<std::string>;

TEST(Sequences, NumbersByDifferingGroup) {
  EXPECT_EQ(described({"sim_v2_0001.vdb", "sim_v2_0002.vdb", "sim_v2_0010.vdb"}), Lines{"sim_v2_{:04}.vdb: 1 2 10"});
  EXPECT_EQ(described({"f0001_d2.vdb", "f0003_d2.vdb"}), Lines{"f{:04}_d2.vdb: 1 3"});
  EXPECT_EQ(described({"shot_001/d7.vdb", "shot_002/d7.vdb"}), Lines{"shot_{:03}/d7.vdb: 1 2"});
  EXPECT_EQ(described({"1.mp4", "2.mp4"}), Lines{"{}.mp4: 1 2"});
}

TEST(Sequences, ReturnsPatternOfAllNames) {
  EXPECT_EQ(described({"f8", "f9", "f10"}), Lines{"f{}: 8 9 10"});
  EXPECT_EQ(described({"f9998", "f10000"}), Lines{"f{}: 9998 10000"});
  EXPECT_EQ(described({"f0998", "f10000"}), Lines{"f{:04}: 998 10000"});
  EXPECT_EQ(described({"f1", "f01", "f2"}), Lines{"f{}: 1 1 2"});
  EXPECT_EQ(described({"{a}%d1", "{a}%d2"}), Lines{"{{a}}%%d{}: 1 2"});
}

TEST(Sequences, SplitsByOtherNumbers) {
  EXPECT_EQ(described({"cam1_01", "cam1_02", "cam2_01", "cam2_02", "cam3_01"}),
            (Lines{"cam1_{:02}: 1 2", "cam2_{:02}: 1 2", "cam3_01: 1"}));
  EXPECT_EQ(described({"a1.vdb", "b1.vdb", "a2.vdb", "readme"}), (Lines{"a{}.vdb: 1 2", "b1.vdb: 1", "readme: 1"}));
}

TEST(Sequences, DistinguishesSignsFromHyphens) {
  EXPECT_EQ(described({"f.-0001.vdb", "f.0000.vdb"}), Lines{"f.{:04}.vdb: -1 0"});
  EXPECT_EQ(described({"f_-2", "f_-1"}), Lines{"f_{}: -2 -1"});
  EXPECT_EQ(described({"f-1", "f-2"}), Lines{"f-{}: 1 2"});
  EXPECT_EQ(described({"f-1", "f0", "f1"}), Lines{"f{}: -1 0 1"});
  EXPECT_EQ(described({"2026-11-21", "2026-11-22"}), Lines{"2026-11-{}: 21 22"});
  EXPECT_EQ(described({"-1", "-2"}), Lines{"{}: -1 -2"});
}

TEST(Sequences, IgnoresLongDigitGroups) {
  EXPECT_EQ(described({"f1234567890123456789", "f1234567890123456790"}).size(), 2U);
  EXPECT_EQ(described({"f123456789012345678", "f123456789012345679"}).size(), 1U);
}

TEST(Sequences, ContainEveryNameOnce) {
  const std::vector<std::string> names{"a1", "x", "a1b2", "a2", "a3b2", "a1b3", "", "7", "a2b3"};
  std::vector<int> count(names.size());
  for (const Sequence& sequence : sequences_of(names)) {
    for (const SequenceMember& member : sequence.members) ++count[member.name];
  }
  EXPECT_EQ(count, std::vector<int>(names.size(), 1));
}

TEST(TrailingNumber, ReturnsLastNumberBeforeExtension) {
  EXPECT_EQ(trailing_number("shot_3/sim_v2_0042.vdb"), 42);
  EXPECT_EQ(trailing_number("a_1.mp4"), 1);
  EXPECT_EQ(trailing_number("sim.0042"), 42);
  EXPECT_EQ(trailing_number("sim.-0042.vdb"), -42);
  EXPECT_EQ(trailing_number("sim-0042.vdb"), 42);
  EXPECT_FALSE(trailing_number("shot_3/sim.vdb"));
  EXPECT_FALSE(trailing_number("shot_3/sim.vdb2"));
  EXPECT_FALSE(trailing_number(""));
}

}  // namespace
}  // namespace isoextract::batch
