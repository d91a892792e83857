#include "field/label_map.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace isoextract::field {
namespace {

using ValueAt = std::function<double(int x, int y, int z)>;

template <class T>
ScalarField field_of(const glm::ivec3& dims, const ValueAt& value_at) {
  auto owner = std::make_shared<std::vector<T>>();
  for (int z = 0; z < dims.z; ++z) {
    for (int y = 0; y < dims.y; ++y) {
      for (int x = 0; x < dims.x; ++x) owner->push_back(static_cast<T>(static_cast<float>(value_at(x, y, z))));
    }
  }
  ScalarField field;
  field.samples = DenseSamples{sample_type_of<T>(), dims, owner, owner->data()};
  return field;
}

// Cells of random seeds on a grid of `side` samples, with shuffled labels from 1.
ValueAt random_cells(int side, std::uint32_t seed) {
  return [side, seed](int x, int y, int z) {
    constexpr int kLabels = 1000;
    std::uint32_t hash = seed;
    for (const int cell : {x / side, y / side, z / side})
      hash = (hash ^ static_cast<std::uint32_t>(cell)) * 2654435761U;
    return 1 + static_cast<double>((hash >> 8U) % kLabels);
  };
}

bool in_ball(int x, int y, int z, double radius) { return std::hypot(x - 20.2, y - 19.7, z - 20.4) < radius; }

std::optional<LabelMapKind> kind_of(const ScalarField& field) {
  const auto map = measure_label_map(field);
  return map ? std::optional(map->kind) : std::nullopt;
}

struct Counted {
  std::uint64_t voxels = 0;
  IndexBox box{glm::ivec3(1 << 20), glm::ivec3(-1)};
  std::uint64_t faces = 0;
};

// Counts voxels, boxes and faces sample by sample.
std::map<std::int64_t, Counted> count_labels(const glm::ivec3& dims, const ValueAt& value_at) {
  std::map<std::int64_t, Counted> labels;
  for (int z = 0; z < dims.z; ++z) {
    for (int y = 0; y < dims.y; ++y) {
      for (int x = 0; x < dims.x; ++x) {
        const double value = value_at(x, y, z);
        Counted& counted = labels[static_cast<std::int64_t>(value)];
        ++counted.voxels;
        counted.box.min = glm::min(counted.box.min, glm::ivec3(x, y, z));
        counted.box.max = glm::max(counted.box.max, glm::ivec3(x, y, z));
        for (int axis = 0; axis < 3; ++axis) {
          for (const int step : {-1, 1}) {
            glm::ivec3 at(x, y, z);
            at[axis] += step;
            const bool is_inside = at[axis] >= 0 && at[axis] < dims[axis];
            if (!is_inside || value_at(at.x, at.y, at.z) != value) ++counted.faces;
          }
        }
      }
    }
  }
  return labels;
}

void expect_counts(const LabelMap& map, const glm::ivec3& dims, const ValueAt& value_at) {
  std::map<std::int64_t, Counted> expected = count_labels(dims, value_at);
  if (expected.contains(0)) {
    ASSERT_TRUE(map.background);
    EXPECT_EQ(map.background->voxels, expected[0].voxels);
    EXPECT_EQ(map.background->box, expected[0].box);
    expected.erase(0);
  } else {
    EXPECT_FALSE(map.background);
  }
  ASSERT_EQ(map.labels.size(), expected.size());
  std::uint64_t faces = 0;
  auto next = expected.begin();
  for (const LabelFigures& label : map.labels) {
    EXPECT_EQ(label.label, next->first);
    EXPECT_EQ(label.voxels, next->second.voxels);
    EXPECT_EQ(label.box, next->second.box);
    faces += next->second.faces;
    ++next;
  }
  EXPECT_EQ(map.faces, faces);
}

TEST(LabelMap, MeasuresEachLabelOfAnyIntegerAndFloatingPointType) {
  const glm::ivec3 dims(41, 33, 29);
  const ValueAt labels = [](int x, int y, int z) {
    if (!in_ball(x, y, z, 15)) return 0.0;
    return x < 17 ? 3.0 : y < 20 ? 100.0 : 7.0;
  };
  for (const SampleType type : {SampleType::u8, SampleType::i8, SampleType::u16, SampleType::i16, SampleType::u32,
                                SampleType::i32, SampleType::f16, SampleType::f32, SampleType::f64}) {
    const ScalarField field =
        visit_sample_type(type, [&]<class T>(std::type_identity<T>) { return field_of<T>(dims, labels); });
    const auto map = measure_label_map(field);
    ASSERT_TRUE(map) << sample_type_name(type);
    EXPECT_EQ(map->kind, LabelMapKind::label_map);
    EXPECT_EQ(map->labels.size(), 3U);
    expect_counts(*map, dims, labels);
  }
}

TEST(LabelMap, MeasuresCellsWithoutBackground) {
  const glm::ivec3 dims(60, 50, 40);
  const ValueAt labels = random_cells(5, 3);
  const ScalarField field = field_of<std::uint32_t>(dims, labels);
  const auto map = measure_label_map(field);
  ASSERT_TRUE(map);
  EXPECT_GT(map->labels.size(), 500U);
  EXPECT_NEAR(map->equal_share, 0.8, 0.02);
  expect_counts(*map, dims, labels);
}

TEST(LabelMap, MeasuresAllSamplesOfLargeFields) {
  const glm::ivec3 dims(70, 65, 61);  // more than 2^17 samples
  const ValueAt labels = random_cells(9, 5);
  const ScalarField field = field_of<std::int16_t>(dims, labels);
  const auto map = measure_label_map(field);
  ASSERT_TRUE(map);
  expect_counts(*map, dims, labels);
  EXPECT_EQ(guess_label_map(field), LabelMapKind::label_map);
  // One fraction anywhere: no label map.
  const ValueAt broken = [&](int x, int y, int z) { return x == 69 && y == 31 && z == 7 ? 0.5 : labels(x, y, z); };
  EXPECT_FALSE(measure_label_map(field_of<float>(dims, broken)));
}

TEST(LabelMap, IsIndependentOfThreads) {
  const ScalarField field = field_of<std::uint16_t>({80, 70, 60}, random_cells(6, 7));
  const auto map = measure_label_map(field);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto alone = measure_label_map(field);
  ASSERT_TRUE(map && alone);
  EXPECT_EQ(map->labels, alone->labels);
  EXPECT_EQ(map->faces, alone->faces);
  EXPECT_EQ(map->equal_share, alone->equal_share);
}

TEST(LabelMap, RecognizesAnyTwoValuesAsAMask) {
  for (const double inside : {1.0, 255.0}) {
    const ValueAt mask = [&](int x, int y, int z) { return in_ball(x, y, z, 12) ? inside : 0; };
    for (const ScalarField& field : {field_of<std::uint8_t>({40, 40, 40}, mask), field_of<float>({40, 40, 40}, mask)}) {
      const auto map = measure_label_map(field);
      ASSERT_TRUE(map);
      EXPECT_EQ(map->kind, LabelMapKind::binary_mask);
      expect_counts(*map, {40, 40, 40}, mask);
      EXPECT_EQ(guess_label_map(field), LabelMapKind::binary_mask);
    }
  }
  // A mask of single voxels has no flat patches.
  EXPECT_EQ(kind_of(field_of<std::uint8_t>({16, 16, 16}, [](int x, int y, int z) { return (x + y + z) % 2; })),
            LabelMapKind::binary_mask);
}

TEST(LabelMap, RejectsNoiseScansAndSmoothFields) {
  const glm::ivec3 dims(40, 40, 40);
  std::mt19937 random(1);
  const auto noise = [&](int values) {
    return [&random, values](int, int, int) { return static_cast<double>(random() % static_cast<unsigned>(values)); };
  };
  EXPECT_FALSE(kind_of(field_of<std::uint8_t>(dims, noise(3))));
  EXPECT_FALSE(kind_of(field_of<std::uint8_t>(dims, noise(4))));
  EXPECT_FALSE(kind_of(field_of<std::uint16_t>(dims, noise(60'000))));
  // Noise of four values in a ball in an empty volume.
  EXPECT_FALSE(kind_of(field_of<std::uint8_t>(
      dims, [&](int x, int y, int z) { return in_ball(x, y, z, 9) ? noise(4)(x, y, z) : 0.0; })));
  // Rounded and smooth: flat patches, but each step is 1. With few values it cannot be told from labels.
  const auto rounded = [](double levels) {
    return [levels](int x, int y, int z) {
      return std::floor(levels * std::exp(-(x * x + y * y + z * z) / (2.0 * 30 * 30)));
    };
  };
  EXPECT_FALSE(kind_of(field_of<std::uint8_t>(dims, rounded(16))));
  EXPECT_EQ(kind_of(field_of<std::uint8_t>(dims, rounded(6))), LabelMapKind::label_map);
  // A ramp is flat along two axes only.
  EXPECT_FALSE(kind_of(field_of<std::uint8_t>({8, 20, 20}, [](int x, int, int) { return x; })));
}

// 2^24 + 1 is no f32 and 2^53 + 1 is no f64: adding 1 to the largest label of a type gives the same label.
TEST(LabelMap, TakesPairsOfTheLargestLabelForNoStepsOfOne) {
  const glm::ivec3 dims(40, 40, 40);
  const auto with_block_of = [](double largest) {
    return [largest](int x, int y, int z) { return x < 20 ? random_cells(5, 3)(x, y, z) : largest; };
  };
  for (const double sign : {1.0, -1.0}) {
    const ValueAt in_f32 = with_block_of(sign * 0x1p24);
    EXPECT_EQ(kind_of(field_of<float>(dims, in_f32)), LabelMapKind::label_map);
    expect_counts(measure_label_map(field_of<float>(dims, in_f32)).value(), dims, in_f32);
    EXPECT_EQ(kind_of(field_of<double>(dims, with_block_of(sign * 0x1p53))), LabelMapKind::label_map);
  }
}

TEST(LabelMap, RejectsScaledLevelSetSmallAndConstantFields) {
  const ValueAt mask = [](int x, int y, int z) { return in_ball(x, y, z, 12) ? 1 : 0; };
  ScalarField field = field_of<std::uint8_t>({40, 40, 40}, mask);
  field.scale = {2, 0};
  EXPECT_FALSE(measure_label_map(field));
  field.scale = {};
  field.kind = FieldKind::level_set;
  EXPECT_FALSE(measure_label_map(field));
  EXPECT_FALSE(guess_label_map(field));
  EXPECT_FALSE(kind_of(field_of<std::uint8_t>({7, 8, 9}, [](int x, int, int) { return x / 4; })));  // 504 samples
  EXPECT_TRUE(kind_of(field_of<std::uint8_t>({8, 8, 8}, [](int x, int, int) { return x / 4; })));
  EXPECT_FALSE(kind_of(field_of<std::uint8_t>({16, 16, 16}, [](int, int, int) { return 5; })));
  // f16 has no odd integers above 2^11.
  EXPECT_FALSE(kind_of(field_of<Half>({16, 16, 16}, [](int x, int, int) { return x < 8 ? 0 : 2050; })));
}

TEST(LabelMap, IgnoresNanSamples) {
  const ValueAt labels = [](int x, int y, int z) {
    if (z == 0) return std::numeric_limits<double>::quiet_NaN();
    return in_ball(x, y, z, 15) ? (x < 20 ? 1.0 : 2.0) : 0.0;
  };
  const auto map = measure_label_map(field_of<float>({41, 41, 41}, labels));
  ASSERT_TRUE(map);
  ASSERT_EQ(map->labels.size(), 2U);
  EXPECT_EQ(map->background->box.min.z, 1);
  EXPECT_EQ(map->background->voxels + map->labels[0].voxels + map->labels[1].voxels, 41U * 41 * 40);
}

TEST(LabelMap, MeasuresSparseIntegersWithTiles) {
  auto values = std::make_shared<std::vector<std::int32_t>>(512, 0);
  // The block from (8, 0, -8) on: label 4 where its k is at least 3, else the background.
  for (std::size_t n = 0; n < values->size(); ++n) (*values)[n] = n % 8 >= 3 ? 4 : 9;
  SparseSamples sparse;
  sparse.type = SampleType::i32;
  sparse.background = 9;
  sparse.owner = values;
  sparse.blocks = {{{8, 0, -8}, values->data()}};
  sparse.tiles = {{{16, 0, -8}, 8, 4}, {{64, 64, 64}, 32, 6}};
  ScalarField field;
  field.samples = sparse;
  const auto map = measure_label_map(field);
  ASSERT_TRUE(map);
  EXPECT_EQ(map->kind, LabelMapKind::label_map);
  EXPECT_FALSE(map->background);
  EXPECT_EQ(map->labels, (std::vector<LabelFigures>{{4, 5 * 64 + 512, {{8, 0, -8}, {23, 7, -1}}},
                                                    {6, 32 * 32 * 32, {{64, 64, 64}, {95, 95, 95}}}}));
  // A tile of the background changes nothing.
  sparse.tiles.push_back({{128, 0, 0}, 64, 9});
  field.samples = sparse;
  const auto with_background_tile = measure_label_map(field);
  ASSERT_TRUE(with_background_tile);
  EXPECT_EQ(with_background_tile->labels, map->labels);
  EXPECT_EQ(with_background_tile->faces, map->faces);
  EXPECT_GT(map->faces, 6U * (32 * 32 + 8 * 8));
  EXPECT_LT(map->faces, 7000U);
  // Floating-point grids with one value in them are densities.
  SparseSamples fog;
  fog.tiles = {{{0, 0, 0}, 8, 1}};
  field.samples = fog;
  EXPECT_FALSE(measure_label_map(field));
}

}  // namespace
}  // namespace isoextract::field
