#include "files/frame_pattern.hpp"

#include <gtest/gtest.h>

#include "files/name_parts.hpp"

namespace isoextract::files {
namespace {

FramePattern parsed_pattern(const std::string& name) {
  const auto parsed = FramePattern::parse(name);
  EXPECT_TRUE(parsed) << name << ": " << (parsed ? "" : parsed.error().message);
  if (!parsed || !*parsed) {
    ADD_FAILURE() << name << " is no pattern";
    return {"", 0, ""};
  }
  return **parsed;
}

std::string pattern_refusal(const std::string& name) {
  const auto parsed = FramePattern::parse(name);
  if (parsed) return "accepted";
  EXPECT_EQ(parsed.error().code, ErrorCode::usage);
  return parsed.error().message;
}

TEST(FramePattern, ParsesEveryNumbering) {
  const FramePattern four{"sim_", 4, ".vdb"};
  for (const char* name : {"sim_{:04}.vdb", "sim_{:4}.vdb", "sim_{frame:04}.vdb", "sim_%04d.vdb", "sim_%4d.vdb",
                           "sim_####.vdb", "sim_@@@@.vdb", "sim_$F4.vdb", "sim_${F4}.vdb"}) {
    EXPECT_EQ(parsed_pattern(name), four) << name;
  }
  const FramePattern any{"sim_", 0, ".vdb"};
  for (const char* name : {"sim_{}.vdb", "sim_{frame}.vdb", "sim_%d.vdb", "sim_{:}.vdb", "sim_{:0}.vdb", "sim_#.vdb",
                           "sim_@.vdb", "sim_$F.vdb", "sim_${F}.vdb"}) {
    EXPECT_EQ(parsed_pattern(name), any) << name;
  }
  EXPECT_EQ(parsed_pattern("shot_{:03}/density.vdb"), FramePattern("shot_", 3, "/density.vdb"));
  EXPECT_EQ(parsed_pattern("demo:waves?size=16&time={}"), FramePattern("demo:waves?size=16&time=", 0, ""));
  EXPECT_EQ(parsed_pattern("##"), FramePattern("", 2, ""));
  EXPECT_EQ(parsed_pattern("#/a.vdb"), FramePattern("", 0, "/a.vdb"));
}

TEST(FramePattern, FindsNoPatternInOtherNames) {
  for (const char* name :
       {"",         "sim.vdb", "sim_0001.vdb", "50%.vdb",   "50%",    "%4",         "%x",          "%-4d",
        "a{",       "a}",      "}{",           "{iso}.vdb", "{a b}",  "cube#1.vdb", "{{}}",        "{{:04}}",
        "%%04d",    "{#}{#}",  "#{#}#",        "{1}",       "a#.vdb", "#1.vdb",     "me@home.vdb", "$FF.vdb",
        "$F42.vdb", "$",       "$f4",          "${F44}",    "{$}F4",  "{@}{@}",     "x {#}.vdb"}) {
    const auto parsed = FramePattern::parse(name);
    ASSERT_TRUE(parsed) << name << ": " << parsed.error().message;
    EXPECT_FALSE(parsed->has_value()) << name;
  }
}

TEST(FramePattern, ParsesEscapes) {
  const FramePattern escaped = parsed_pattern("100%%_{{x}}_{#}{#}_{iso}_{}.vdb");
  EXPECT_EQ(escaped.prefix(), "100%_{x}_##_{iso}_");
  EXPECT_EQ(escaped.expand(3), "100%_{x}_##_{iso}_3.vdb");
}

TEST(FramePattern, ParsesItsOwnText) {
  for (const FramePattern& one :
       {FramePattern("a%d{x}###", 5, "}{#%%.vdb"), FramePattern("", 0, ""), FramePattern("#", 2, "#"),
        FramePattern("$F4_@@@.", 1, ".#._${F}@"), FramePattern("a.#.@.", 0, "$FF")}) {
    EXPECT_EQ(parsed_pattern(one.text()), one) << one.text();
  }
}

TEST(FramePattern, RefusesSeveralNumberings) {
  EXPECT_EQ(pattern_refusal("a{}_%04d.vdb"),
            "a{}_%04d.vdb: expected one placeholder of the frame number, found '{}' and '%04d'");
  EXPECT_EQ(pattern_refusal("##_##"), "##_##: expected one placeholder of the frame number, found '##' and '##'");
  EXPECT_EQ(pattern_refusal("\x1b[2J{}{}"),
            "\\x1b[2J{}{}: expected one placeholder of the frame number, found '{}' and '{}'");
}

TEST(FramePattern, RefusesImpossibleWidths) {
  EXPECT_EQ(parsed_pattern("{:018}").width(), 18);
  EXPECT_EQ(pattern_refusal("{:019}"), "{:019}: expected a width of at most 18 digits, found '{:019}'");
  EXPECT_NE(pattern_refusal("{:99999999999999999999}"), "accepted");
  EXPECT_NE(pattern_refusal("%4294967300d"), "accepted");
  EXPECT_NE(pattern_refusal(std::string(100000, '#')), "accepted");
  EXPECT_EQ(pattern_refusal("a{:x}.vdb"), "a{:x}.vdb: expected digits after the colon, as in {:04}, found '{:x}'");
  EXPECT_NE(pattern_refusal("{:-4}"), "accepted");
  EXPECT_NE(pattern_refusal("{frame:04d}"), "accepted");
}

TEST(FramePattern, PadsNumbersWithZeros) {
  const FramePattern four = parsed_pattern("f{:04}");
  EXPECT_EQ(four.expand(7), "f0007");
  EXPECT_EQ(four.expand(12345), "f12345");
  EXPECT_EQ(four.expand(0), "f0000");
  EXPECT_EQ(four.expand(-1), "f-0001");
  EXPECT_EQ(parsed_pattern("f{}").expand(-12), "f-12");
  EXPECT_EQ(four.expand(-kMaxFrameNumber), "f-999999999999999999");
}

TEST(FramePattern, MatchInvertsExpand) {
  for (const char* name : {"f{:04}.vdb", "f{}.vdb", "{:01}", "-{:03}", "s_{:02}/x.vdb", "1{:02}2"}) {
    const FramePattern one = parsed_pattern(name);
    for (const std::int64_t number : {std::int64_t{0}, std::int64_t{7}, std::int64_t{-1}, std::int64_t{99999},
                                      std::int64_t{-99999}, kMaxFrameNumber, -kMaxFrameNumber}) {
      EXPECT_EQ(one.match(one.expand(number)), number) << name;
    }
  }
}

TEST(FramePattern, MatchesOnlyItsWidth) {
  const FramePattern four = parsed_pattern("f{:04}.vdb");
  EXPECT_EQ(four.match("f0007.vdb"), 7);
  EXPECT_EQ(four.match("f12345.vdb"), 12345);
  EXPECT_EQ(four.match("f-0007.vdb"), -7);
  for (const char* name :
       {"f007.vdb", "f00007.vdb", "f012345.vdb", "f.vdb", "f-.vdb", "f-007.vdb", "f--0007.vdb", "f+0007.vdb",
        "f-0000.vdb", "f 007.vdb", "f0x07.vdb", "f0007.vdb.gz", "xf0007.vdb", "f0007", "", "f0007.VDB"}) {
    EXPECT_FALSE(four.match(name)) << name;
  }
}

TEST(FramePattern, MatchesLeadingZerosWithoutWidth) {
  const FramePattern any = parsed_pattern("f{}");
  EXPECT_EQ(any.match("f007"), 7);
  EXPECT_EQ(any.match("f-007"), -7);
  EXPECT_EQ(any.match("f000000000000000007"), 7);
  EXPECT_FALSE(any.match("f0000000000000000007"));  // 19 digits
  EXPECT_FALSE(any.match("f99999999999999999999999999"));
  EXPECT_FALSE(any.match("f-0"));
  EXPECT_FALSE(any.match(std::string("f7\0", 3)));
}

TEST(FramePattern, KeepsPrefixAndSuffixApart) {
  const FramePattern one{"a1", 0, "1a"};
  EXPECT_FALSE(one.match("a1a"));
  EXPECT_FALSE(one.match("a11a"));
  EXPECT_EQ(one.match("a151a"), 5);
}

TEST(FramePattern, ReadsMinusOfPrefixAsText) {
  EXPECT_EQ(parsed_pattern("sim-{:04}").match("sim-0001"), 1);
  EXPECT_EQ(parsed_pattern("sim-{:04}").match("sim--0001"), -1);
  EXPECT_EQ(parsed_pattern("sim{:04}").match("sim-0001"), -1);
}

}  // namespace
}  // namespace isoextract::files
