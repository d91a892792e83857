// Tests of arrays of surface nets in temporary files.
#include "extract/detail/net_memory.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/fields.hpp"
#include "unit/extract/label_nets.hpp"

namespace isoextract::extract {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20U;

TEST(NetMemory, PassesOverFilesInRuns) {
  NetMemory memory(Context(MemoryBudget(16 * kMiB)), "test");
  EXPECT_FALSE(NetMemory::prefers_files(8 * kMiB, memory.context()));
  EXPECT_TRUE(NetMemory::prefers_files(8 * kMiB + 1, memory.context()));
  constexpr std::size_t kCount = std::size_t{4} << 20U;
  auto in_memory = memory.make<std::uint8_t>(kCount);
  ASSERT_TRUE(in_memory);
  std::vector<std::pair<std::size_t, std::size_t>> runs;
  const auto note_runs = [&](std::size_t begin, std::size_t end) { runs.emplace_back(begin, end); };
  memory.for_each_run(kCount, note_runs);
  EXPECT_EQ(runs, (std::vector<std::pair<std::size_t, std::size_t>>{{0, kCount}}));
  EXPECT_EQ(memory.most_in_files(), 0U);

  memory.use_files();
  {
    auto in_file = memory.make<std::uint32_t>(kCount);
    ASSERT_TRUE(in_file);
    EXPECT_EQ(memory.context().memory().reserved(), kCount);
    EXPECT_EQ(memory.bytes_in_files(), 4 * kCount);
    runs.clear();
    memory.for_each_run(kCount, note_runs);
    EXPECT_GT(runs.size(), 4U);
    std::size_t next = 0;
    for (const auto& [begin, end] : runs) {
      EXPECT_EQ(begin, next);
      EXPECT_GT(end, begin);
      next = end;
    }
    EXPECT_EQ(next, kCount);
    memory.fill(*in_file, std::uint32_t{5});
    std::vector<std::atomic<int>> calls(kCount / 64);
    memory.for_each_chunk(calls.size(), [&](std::size_t c) {
      ++calls[c];
      for (std::size_t i = 64 * c; i < 64 * (c + 1); ++i) (*in_file)[i] += static_cast<std::uint32_t>(c);
    });
    for (std::size_t i = 0; i < kCount; ++i) ASSERT_EQ((*in_file)[i], 5 + i / 64);
    for (const std::atomic<int>& count : calls) ASSERT_EQ(count, 1);
    EXPECT_TRUE(memory.check());
  }
  EXPECT_EQ(memory.bytes_in_files(), 0U);
  EXPECT_EQ(memory.most_in_files(), 4 * kCount);
}

TEST(NetMemory, LeavesHalfOfTheLimitToMeshes) {
  NetMemory memory(Context(MemoryBudget(20 * kMiB)), "test");
  const auto first = memory.make<std::uint8_t>(5 * kMiB);
  const auto second = memory.make<std::uint8_t>(5 * kMiB);
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(first->is_in_file() || second->is_in_file());
  const auto third = memory.make<std::uint8_t>(4 * kMiB);
  ASSERT_TRUE(third);
  EXPECT_TRUE(third->is_in_file());
  const auto small = memory.make<std::uint8_t>(kMiB);  // below kLeastNetFile
  ASSERT_TRUE(small);
  EXPECT_FALSE(small->is_in_file());
}

// Blocks of four voxels along each axis, of 60 labels and none.
field::ScalarField blocks() {
  return test::dense_field<std::uint8_t>({130, 120, 110}, [](int x, int y, int z) {
    const unsigned block = static_cast<unsigned>(x / 4) * 73856093U ^ static_cast<unsigned>(y / 4) * 19349663U ^
                           static_cast<unsigned>(z / 4) * 83492791U;
    return (block >> 3U) % 61;
  });
}

TEST(NetMemory, MakesTheSameMeshesOfLabelsFromFiles) {
  const field::ScalarField field = blocks();
  for (const Method method : {Method::surface_nets, Method::voxels}) {
    ExtractOptions options = net_options();
    options.method = method;
    const Labels whole = nets_of(field, options);
    const Context limited{MemoryBudget((method == Method::voxels ? 16 : 48) * kMiB)};
    const auto found = LabelVoxels::find(field, options, {true, {}}, limited);
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_EQ(found->labels().size(), whole.size());
    ASSERT_EQ(found->notes().size(), 1U);
    EXPECT_EQ(found->notes().front().id, NoteId::voxels_in_files);
    for (const auto& [label, expected] : whole) {
      const auto extraction = found->extract(field, label, options, limited);
      ASSERT_TRUE(extraction) << extraction.error().message;
      EXPECT_TRUE(std::ranges::equal(extraction->mesh.positions, expected.positions)) << label;
      EXPECT_TRUE(std::ranges::equal(extraction->mesh.triangles, expected.triangles)) << label;
    }
  }
}

}  // namespace
}  // namespace isoextract::extract
