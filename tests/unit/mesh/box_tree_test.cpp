#include "mesh/box_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "mesh/detail/box_filter.hpp"

namespace isoextract::mesh {
namespace {

std::vector<FloatBox> random_boxes(std::size_t count) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> at(0, 100);
  std::uniform_real_distribution<float> size(0, 5);
  std::vector<FloatBox> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::vec3 low(at(random), at(random), at(random));
    boxes.push_back({low, low + glm::vec3(size(random), size(random), size(random))});
  }
  return boxes;
}

BoxTree tree_of(const std::vector<FloatBox>& boxes, std::span<const std::uint32_t> groups = {}) {
  Buffer<BoxTree::Item> items(boxes.size());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) items[i] = {boxes[i].center(), i};
  return {items.span(), [&](std::uint32_t i) { return boxes[i]; }, groups};
}

TEST(BoxQuery, AgreesWithBoxes) {
  std::mt19937 random(4);
  std::uniform_int_distribution<int> at(0, 3);  // so that boxes often touch
  int met = 0;
  for (int i = 0; i < 20000; ++i) {
    std::array<glm::vec3, 6> p;
    for (glm::vec3& corner : p) corner = 0.1F * glm::vec3(at(random), at(random), at(random));
    const FloatBox a = box_around(p[0], p[1], p[2]);
    const FloatBox b = box_around(p[3], p[4], p[5]);
    ASSERT_EQ(BoxQuery(a).meets(b), a.meets(b));
    ASSERT_EQ(BoxQuery(a).meets_triangle(&p[3]), a.meets(b));
    met += a.meets(b) ? 1 : 0;
  }
  EXPECT_GT(met, 2000);
  EXPECT_LT(met, 18000);
}

// Of random scale and place, also beyond the range of float.
TEST(BoxFilter, BoundsDistancesFromBelow) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(-1, 1);
  std::uniform_real_distribution<double> power(-44, 40);
  int far = 0;
  for (int i = 0; i < 100000; ++i) {
    const double scale = std::pow(10.0, power(random));
    const double place = i % 2 == 0 ? 0 : std::pow(10.0, power(random));
    const auto point = [&] { return scale * glm::dvec3(part(random), part(random), part(random)) + place; };
    std::array<glm::vec3, 3> corners;
    for (glm::vec3& corner : corners) {
      corner = glm::vec3(
          glm::clamp(point(), -double{std::numeric_limits<float>::max()}, double{std::numeric_limits<float>::max()}));
    }
    const FloatBox box = box_around(corners[0], corners[1], corners[2]);
    const glm::dvec3 p = point();
    const glm::dvec3 away = glm::max(glm::max(glm::dvec3(box.min) - p, p - glm::dvec3(box.max)), 0.0);
    const double squared = glm::dot(away, away);
    const double bound = BoxFilter(p).bound(box);
    ASSERT_LE(bound, squared) << i;
    ASSERT_EQ(BoxFilter(p).bound_of_triangle(corners.data()), bound);
    const bool is_usual = scale > 1e-10 && scale < 1e10 && place < 1e3 * scale;
    if (!is_usual || !(squared > 0.01 * scale * scale)) continue;
    ++far;
    EXPECT_GT(bound, 0.9 * squared);
  }
  EXPECT_GT(far, 1000);
}

TEST(BoxTree, FindsAllItemsNear) {
  for (const std::size_t count : {1, 4, 5, 9, 3000}) {
    const std::vector<FloatBox> boxes = random_boxes(count);
    const BoxTree tree = tree_of(boxes);
    for (const FloatBox& near : random_boxes(100)) {
      std::multiset<std::uint32_t> found;
      tree.for_each_near(near, [&](std::uint32_t i) {
        if (boxes[i].meets(near)) found.insert(i);
      });
      std::multiset<std::uint32_t> expected;
      for (std::uint32_t i = 0; i < count; ++i) {
        if (boxes[i].meets(near)) expected.insert(i);
      }
      EXPECT_EQ(found, expected);
    }
  }
}

TEST(BoxTree, MapsSlotsToLeaves) {
  const BoxTree tree = tree_of(random_boxes(1001));
  EXPECT_EQ(std::set<std::uint32_t>(tree.numbers().begin(), tree.numbers().end()).size(), 1001U);
  for (std::size_t slot = 0; slot < 1001; ++slot) {
    const BoxTree::Node leaf = tree.leaf(tree.leaf_of(slot));
    EXPECT_LE(tree.first_slot(leaf), slot);
    EXPECT_GT(tree.end_slot(leaf), slot);
    EXPECT_LE(tree.numbers_of(leaf).size(), BoxTree::kLeafSize);
  }
}

// Returns the coordinate and number by which the node is split: those of its greatest or least item.
std::pair<float, std::uint32_t> end_of(const BoxTree& tree, const BoxTree::Node& node,
                                       std::span<const glm::vec3> centers, int axis, bool greatest) {
  const auto key = [&](std::uint32_t i) { return std::pair(centers[i][axis], i); };
  const auto numbers = tree.numbers_of(node);
  const auto [least, most] = std::ranges::minmax(numbers, {}, key);
  return key(greatest ? most : least);
}

// Random, equal, ascending and repeated centers, with both zeros.
TEST(BoxTree, SplitsAtTheMedianOfTheLongestAxis) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> at(-1, 1);
  const auto expect_sorted = [](std::span<const glm::vec3> centers) {
    Buffer<BoxTree::Item> items(centers.size());
    for (std::uint32_t i = 0; i < centers.size(); ++i) items[i] = {centers[i], i};
    const BoxTree tree(items.span(), [&](std::uint32_t i) { return FloatBox{centers[i], centers[i]}; });
    for (std::size_t level = 0; level < tree.depth(); ++level) {
      for (std::size_t number = 0; number < std::size_t{1} << level; ++number) {
        const BoxTree::Node node{level, number};
        const glm::vec3 extent = tree.box(node.index()).max * 0.5F - tree.box(node.index()).min * 0.5F;
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        ASSERT_LT(end_of(tree, node.child(0), centers, axis, true), end_of(tree, node.child(1), centers, axis, false));
      }
    }
  };
  for (const std::size_t count : {5, 8, 9, 17, 64, 65, 200, 3000}) {
    std::vector<glm::vec3> centers(count);
    for (glm::vec3& c : centers) c = {at(random), 2 * at(random), at(random)};
    expect_sorted(centers);
    for (glm::vec3& c : centers) c = glm::trunc(2.0F * c);
    expect_sorted(centers);
    for (std::size_t i = 0; i < count; ++i) centers[i] = {i % 2 == 0 ? -0.0F : 0.0F, 0, 0};
    expect_sorted(centers);
    for (std::size_t i = 0; i < count; ++i) centers[i] = {0, 0, -static_cast<float>(i / 3)};
    expect_sorted(centers);
  }
}

TEST(BoxTree, KeepsGroupsTogether) {
  std::vector<std::uint32_t> groups;
  for (std::uint32_t i = 0; i < 2000; ++i) groups.push_back(i * 7919 % 5);
  const BoxTree tree = tree_of(random_boxes(groups.size()), groups);
  std::set<std::pair<std::uint32_t, std::size_t>> leaves_of;
  for (std::size_t slot = 0; slot < groups.size(); ++slot) {
    leaves_of.insert({groups[tree.numbers()[slot]], tree.leaf_of(slot)});
  }
  EXPECT_LE(leaves_of.size(), tree.leaves() + 4) << "a leaf has two groups only where one group ends";
}

TEST(BoxTree, FindsItemsThatGrew) {
  BoxTree tree = tree_of(random_boxes(1001));
  const FloatBox far{glm::vec3(1000), glm::vec3(1001)};
  const auto found = [&] {
    std::set<std::uint32_t> numbers;
    tree.for_each_near(far, [&](std::uint32_t number) { numbers.insert(number); });
    return numbers;
  };
  EXPECT_TRUE(found().empty());
  tree.enlarge(500, far);
  EXPECT_TRUE(found().contains(tree.numbers()[500]));
  EXPECT_LE(found().size(), BoxTree::kLeafSize);
}

TEST(BoxTree, SearchesSmallBoxesFromNodesNearLargeOne) {
  std::mt19937 random(6);
  std::uniform_real_distribution<float> at(-20, 110);
  for (const std::size_t count : {1, 5, 40, 3000}) {
    const std::vector<FloatBox> boxes = random_boxes(count);
    const BoxTree tree = tree_of(boxes);
    std::size_t starts_below_root = 0;
    std::size_t met = 0;
    for (int i = 0; i < 300; ++i) {
      const glm::vec3 low(at(random), at(random), at(random));
      const BoxTree::Nodes nodes = tree.nodes_near({low, low + 6.0F});
      EXPECT_LE(nodes.span().size(), BoxTree::Nodes::kMost);
      if (!nodes.span().empty() && nodes.span()[0].level > 0) ++starts_below_root;
      for (const float step : {0.0F, 2.0F, 5.0F}) {
        const FloatBox small{low + step, low + (step + 1)};
        std::vector<std::uint32_t> from_root, from_nodes;
        tree.for_each_near(small, [&](std::uint32_t item) { from_root.push_back(item); });
        tree.for_each_near(
            small, [&](std::uint32_t item) { from_nodes.push_back(item); }, nodes.span());
        EXPECT_EQ(from_nodes, from_root);
        EXPECT_EQ(tree.any_leaf_near(small, nodes.span()), !from_root.empty());
        EXPECT_EQ(tree.any_leaf_near(small), !from_root.empty());
        met += from_root.size();
      }
    }
    if (count == 3000) {
      EXPECT_GT(starts_below_root, 100U);
      EXPECT_GT(met, 100U);
    }
  }
}

}  // namespace
}  // namespace isoextract::mesh
