// Tests where the samples of a dense volume are stored: in memory, or in a temporary file.
#include "volume_io/detail/sample_store.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <span>
#include <string>

#include <gtest/gtest.h>

namespace isoextract::test {
namespace {

using volume_io::SampleStore;

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20U;
constexpr glm::ivec3 kLarge(256, 256, 256);  // as floats kLeastInFile

std::span<float> floats_of(SampleStore& store) {
  const auto bytes = store.bytes();
  return {reinterpret_cast<float*>(bytes.data()), bytes.size() / sizeof(float)};
}

TEST(SampleStore, ReadsAsManyLayersAsHalfOfTheMemoryHolds) {
  const Context context{MemoryBudget(100 * kMiB)};
  EXPECT_EQ(volume_io::layers_at_once(kMiB, 1000, context), 32);
  EXPECT_EQ(volume_io::layers_at_once(kMiB, 40, context), 40);
  EXPECT_EQ(volume_io::layers_at_once(kMiB / 4, 1000, context), 192);
  EXPECT_EQ(volume_io::layers_at_once(10 * kMiB, 1000, context), 4);
  EXPECT_EQ(volume_io::layers_at_once(200 * kMiB, 1000, context), 1);
  EXPECT_EQ(volume_io::layers_at_once(0, 7, context), 7);
}

TEST(SampleStore, IsInMemoryIfHalfOfTheLimitHoldsIt) {
  const Context context{MemoryBudget(128 * kMiB)};
  auto store = SampleStore::make("a", kLarge, field::SampleType::f32, context);
  ASSERT_TRUE(store);
  EXPECT_FALSE(store->is_in_file());
  EXPECT_EQ(context.memory().reserved(), 64 * kMiB);
  Notes notes;
  const field::DenseSamples samples = std::move(*store).finish(notes);
  EXPECT_FALSE(samples.file_backed);
  EXPECT_TRUE(notes.empty());
}

TEST(SampleStore, IsInAFileOtherwise) {
  const Context context{MemoryBudget(128 * kMiB - 1)};
  auto store = SampleStore::make("a", kLarge, field::SampleType::f32, context);
  ASSERT_TRUE(store) << store.error().message;
  ASSERT_TRUE(store->is_in_file());
  EXPECT_EQ(context.memory().reserved(), 0U);
  const std::span<float> values = floats_of(*store);
  ASSERT_EQ(values.size(), std::size_t{1} << 24U);
  EXPECT_EQ(std::ranges::count(values, 0.0F), 1 << 24);
  std::iota(values.begin(), values.end(), 0.0F);
  // Released pages keep their values, and can be written again.
  store->leave(store->bytes());
  values[5] = -5;
  store->leave(store->bytes());
  Notes notes{{NoteId::samples_in_file, "one of another component"}};
  const field::DenseSamples samples = std::move(*store).finish(notes);
  EXPECT_TRUE(samples.file_backed);
  EXPECT_TRUE(samples.releases_pages());
  EXPECT_FALSE(samples.lost());
  EXPECT_EQ(samples.dims, kLarge);
  const std::span stored(static_cast<const float*>(samples.data), samples.count());
  EXPECT_EQ(stored[5], -5);
  samples.leave(0, samples.count());
  EXPECT_EQ(stored[6], 6);
  EXPECT_EQ(stored[(1 << 24) - 1], (1 << 24) - 1);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0].text, "memory is short for the 64 MiB of samples, so they are in a temporary file");
}

TEST(SampleStore, RefusesSmallVolumesWithoutMemory) {
  const Context context{MemoryBudget(kMiB)};
  const auto store = SampleStore::make("a", {256, 256, 255}, field::SampleType::f32, context);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(store.error().message, "a: 256x256x255 f32 samples would take 63.8 MiB, the limit is 1 MiB");
}

}  // namespace
}  // namespace isoextract::test
