#include "cli/stage_lines.hpp"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace isoextract::cli {
namespace {

SurfaceLine about_label(std::int64_t label, std::string text) {
  SurfaceLine line;
  line.text = std::move(text);
  line.id = convert::Label{label};
  return line;
}

std::vector<std::string> joined(const std::vector<SurfaceLine>& lines) {
  std::vector<std::string> texts;
  for (const SurfaceLine& line : join_equal_lines(lines)) texts.push_back(line.text);
  return texts;
}

TEST(JoinEqualLines, JoinsLinesOfLabelsThatDifferInLabelAndTime) {
  EXPECT_EQ(
      joined({about_label(1, "no triangles intersect at label 1; 0.02 s"),
              about_label(11, "no triangles intersect at label 11; 0.03 s"),
              about_label(1, "hollowed at label 1: no cavity"), about_label(2, "hollowed at label 2: no cavity"),
              about_label(2, "no triangles intersect at label 2; 0.04 s")}),
      (std::vector<std::string>{"no triangles intersect at 3 labels; 0.09 s", "hollowed at 2 labels: no cavity"}));
}

TEST(JoinEqualLines, CountsALabelOnce) {
  EXPECT_EQ(joined({about_label(3, "no triangles intersect at label 3; 0.02 s"),
                    about_label(3, "no triangles intersect at label 3; 0.03 s")}),
            (std::vector<std::string>{"no triangles intersect at label 3; 0.05 s"}));
}

TEST(JoinEqualLines, KeepsLinesWithOtherFigures) {
  const std::vector<SurfaceLine> lines{about_label(1, "components at label 1: kept 1 of 2 bodies; 0.01 s"),
                                       about_label(2, "components at label 2: kept 1 of 3 bodies; 0.01 s"),
                                       about_label(1, "no label changed its volume at label 17")};
  EXPECT_EQ(joined(lines), (std::vector<std::string>{lines[0].text, lines[1].text, lines[2].text}));
  SurfaceLine packed;
  packed.text = "packed; 0.01 s";
  SurfaceLine later;
  later.text = "packed; 0.02 s";
  EXPECT_EQ(joined({packed, later, packed}), (std::vector<std::string>{packed.text, later.text}));
}

}  // namespace
}  // namespace isoextract::cli
