// The lists of triangles that parallel loops make are those of plain loops.
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/glm.hpp>

#include "edit/detail/collapse_state.hpp"
#include "edit/detail/patch_triangles.hpp"

namespace isoextract::edit {
namespace {

// A strip of triangles over several ranges, with random heights.
struct Strip {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
};

Strip make_strip(std::uint32_t triangles) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> height(-5, 5);
  Strip strip;
  for (std::uint32_t v = 0; v < triangles + 2; ++v) {
    strip.positions.emplace_back(static_cast<float>(v / 2), static_cast<float>(v % 2), height(engine));
  }
  for (std::uint32_t t = 0; t < triangles; ++t) strip.triangles.emplace_back(t, t + 1 + t % 2, t + 2 - t % 2);
  return strip;
}

TEST(PatchTriangles, EqualPlainLoop) {
  for (const std::size_t triangles : {std::size_t{1}, kTriangleGrain, 3 * kTriangleGrain + 17}) {
    const Strip strip = make_strip(static_cast<std::uint32_t>(triangles));
    CollapseState state(strip.positions, strip.positions, strip.triangles);
    for (std::size_t t = 1; t < triangles; t += 3) state.gone[t] = 1;
    const auto holds = [](const glm::uvec3& c) { return c.x % 5 != 4; };
    std::vector<std::uint32_t> expected;
    CornerBox box;
    for (std::uint32_t t = 0; t < triangles; ++t) {
      if (state.gone[t] != 0 || !holds(state.corners[t])) continue;
      expected.push_back(t);
      const glm::dvec3 p(state.positions[state.corners[t].x]);
      box = {glm::min(box.low, p), glm::max(box.high, p)};
    }
    const std::vector<PatchTriangle> found = remaining_triangles(state, holds);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_EQ(found[i].triangle, expected[i]);
      ASSERT_EQ(found[i].cell, 0U);
    }
    const CornerBox around = box_of_first_corners(state, found);
    EXPECT_EQ(around.low, box.low);
    EXPECT_EQ(around.high, box.high);
  }
}

}  // namespace
}  // namespace isoextract::edit
