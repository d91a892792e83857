// Compares the window with a model that stores every sample by its address.
#include <map>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

#include "gpu/detail/toroidal_window.hpp"

namespace isoextract::gpu {
namespace {

std::uint64_t volume(const field::IndexBox& box) {
  const glm::u64vec3 dims(box.dims());
  return dims.x * dims.y * dims.z;
}

template <class F>
void for_each_sample(const field::IndexBox& box, const F& f) {
  glm::ivec3 p;
  for (p.z = box.min.z; p.z <= box.max.z; ++p.z) {
    for (p.y = box.min.y; p.y <= box.max.y; ++p.y) {
      for (p.x = box.min.x; p.x <= box.max.x; ++p.x) f(p);
    }
  }
}

using Key = std::tuple<int, int, int>;
Key key(const glm::ivec3& p) { return {p.x, p.y, p.z}; }

TEST(ToroidalWindow, ReportsOnlyEnteredSamples) {
  std::mt19937 engine(4);
  const auto random = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine); };
  for (int run = 0; run < 40; ++run) {
    const glm::ivec3 size(random(1, 6), random(1, 7), random(1, 5));
    ToroidalWindow window(size);
    std::map<Key, Key> kept;  // address to sample
    glm::ivec3 low(random(0, 20), random(0, 20), random(0, 20));
    for (int move = 0; move < 25; ++move) {
      const bool first = move == 0;
      if (!first) {
        const int far = move % 5 == 0 ? 12 : 2;
        low = glm::max(low + glm::ivec3(random(-far, far), random(-far, far), random(-far, far)), glm::ivec3(0));
      }
      const field::IndexBox now{low, low + size - 1};
      const auto before = kept;
      const auto entered = window.move_to(low);
      EXPECT_LE(entered.size(), first ? 1U : 3U);
      std::map<Key, int> reported;
      for (const field::IndexBox& box : entered) {
        EXPECT_FALSE(box.empty());
        for (const field::IndexBox& piece : window.pieces(box)) {
          for_each_sample(piece, [&](const glm::ivec3& p) {
            ++reported[key(p)];
            // A piece is contiguous: addresses rise with the samples.
            EXPECT_EQ(window.texel(p), window.texel(piece.min) + (p - piece.min));
            kept[key(window.texel(p))] = key(p);
          });
        }
      }
      for (const auto& [sample, times] : reported) EXPECT_EQ(times, 1);
      std::size_t fresh = 0;
      for_each_sample(now, [&](const glm::ivec3& p) {
        const auto old = before.find(key(window.texel(p)));
        const bool was_there = old != before.end() && old->second == key(p);
        EXPECT_NE(was_there, reported.contains(key(p)));
        fresh += was_there ? 0 : 1;
        EXPECT_EQ(kept.at(key(window.texel(p))), key(p));
      });
      EXPECT_EQ(reported.size(), fresh) << "only samples of the window";
      EXPECT_EQ(kept.size(), volume(now));
    }
  }
}

TEST(ToroidalWindow, SplitsBoxesAtSeams) {
  const ToroidalWindow window({4, 5, 3});
  const field::IndexBox box{{6, 3, 2}, {8, 7, 3}};  // ends on a seam in x and z
  const auto pieces = window.pieces(box);
  EXPECT_EQ(pieces.size(), 8U);
  std::uint64_t samples = 0;
  for (const field::IndexBox& piece : pieces) samples += volume(piece);
  EXPECT_EQ(samples, volume(box));
  const field::IndexBox whole{{4, 5, 3}, {7, 9, 5}};
  ASSERT_EQ(window.pieces(whole).size(), 1U);
  EXPECT_EQ(window.pieces(whole).front(), whole);
}

TEST(ToroidalWindow, UploadsNothingWithoutMove) {
  ToroidalWindow window({4, 4, 4});
  EXPECT_EQ(window.move_to({1, 2, 3}).size(), 1U);
  EXPECT_TRUE(window.move_to({1, 2, 3}).empty());
}

// Shustikov: a step along the diagonal renews one row and one column. The paper counts 2n of n * n texels; here their
// common corner is renewed once.
TEST(ToroidalWindow, SavesUploadsLikePaper) {
  constexpr int kSize = 255;
  ToroidalWindow window({kSize, kSize, 1});
  EXPECT_EQ(volume(window.move_to({1000, 77, 0}).front()), 65025U);
  std::uint64_t renewed = 0;
  for (const field::IndexBox& box : window.move_to({1001, 78, 0})) renewed += volume(box);
  EXPECT_EQ(renewed, 509U);
  EXPECT_NEAR(65025.0 / static_cast<double>(renewed), 127.75, 0.005);
  EXPECT_DOUBLE_EQ(kSize * kSize / (2.0 * kSize), 127.5) << "the paper's figure";
}

}  // namespace
}  // namespace isoextract::gpu
