#include "extract/detail/sparse_label_rows.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <variant>

#include <gtest/gtest.h>

#include "extract/detail/voxel_input.hpp"
#include "support/fields.hpp"

namespace isoextract::extract {
namespace {

constexpr glm::ivec3 kDims(96, 24, 16);

int label_at(int x, int y, int z) { return x < 8 ? 0 : 1 + (x / 8 + y / 8) % 3 + (x + y + z) % 2 * (x / 40); }

field::ScalarField label_map() {
  const auto label = [](int x, int y, int z) { return static_cast<std::int16_t>(label_at(x, y, z)); };
  return test::sparse_copy<std::int16_t>(test::dense_field<std::int16_t>(kDims, label), 0);
}

TEST(SparseLabelRows, ReadsBlocksTilesAndBackgroundInTheRegion) {
  const field::ScalarField field = label_map();
  const auto& samples = std::get<field::SparseSamples>(field.samples);
  ASSERT_FALSE(samples.blocks.empty());
  ASSERT_FALSE(samples.tiles.empty());
  const field::IndexBox region{{3, 2, 1}, {90, 20, 15}};
  const auto map = SparseLabelRows::make(field, samples, region, Context(), "the labels");
  ASSERT_TRUE(map);
  const auto chunks = map->chunks(Context());
  ASSERT_TRUE(chunks);
  EXPECT_EQ(chunks->origins.size(), 2U * 3 * 2);  // 64 x 8 x 8 samples each
  EXPECT_TRUE(std::ranges::is_sorted(chunks->origins, {}, chunk_order));
  auto rows = map->rows<std::int16_t>();
  for (const glm::ivec3& origin : chunks->origins) {
    const SampleRows<std::int16_t>& read = rows.read(origin);
    for (int z = 0; z < kVoxelChunk.z; ++z) {
      for (int y = 0; y < kVoxelChunk.y; ++y) {
        const std::int16_t* const row = read.rows[chunk_row(y, z)];
        const glm::ivec3 first = origin + glm::ivec3(read.begin, y, z);
        ASSERT_EQ(row != nullptr, is_in(region, first));
        for (int x = read.begin; row != nullptr && x < read.end; ++x) {
          EXPECT_EQ(row[x], label_at(origin.x + x, first.y, first.z));
        }
      }
    }
    EXPECT_EQ(read.begin, origin.x == 0 ? 3 : 0);
    EXPECT_EQ(origin.x + read.end, origin.x == 0 ? 64 : 91);
  }
}

TEST(SparseLabelRows, ReservesMemory) {
  const field::ScalarField field = label_map();
  const auto& samples = std::get<field::SparseSamples>(field.samples);
  const field::IndexBox region{glm::ivec3(0), kDims - 1};
  const auto none = SparseLabelRows::make(field, samples, region, Context(MemoryBudget(1000)), "the labels");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::out_of_memory);
  EXPECT_NE(none.error().message.find("the labels"), std::string::npos) << none.error().message;
  const Context context{MemoryBudget(std::uint64_t{1} << 20)};
  {
    const auto map = SparseLabelRows::make(field, samples, region, context, "the labels");
    ASSERT_TRUE(map);
    EXPECT_GE(context.memory().reserved(), field::SparseLookup::bytes(samples));
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

}  // namespace
}  // namespace isoextract::extract
