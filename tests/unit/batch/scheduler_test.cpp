#include "batch/scheduler.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <numeric>

#include <gtest/gtest.h>

#include "support/temp_folder.hpp"

namespace isoextract::batch {
namespace {

using test::TempFolder;

convert::ConversionJob sphere_job(const TempFolder& folder, int number, const std::string& input) {
  convert::ConversionJob job;
  job.source.input = input;
  job.normals = convert::Normals::none;
  job.format = meshes::MeshFormat::ply;
  job.outputs = {{(folder / ("f" + std::to_string(number) + ".ply")).string(), {0.0}}};
  return job;
}

BatchJob spheres(const TempFolder& folder, int count, const std::string& input = "demo:sphere?size=24") {
  BatchJob batch;
  for (int i = 0; i < count; ++i) batch.frames.push_back({i, sphere_job(folder, i, input)});
  return batch;
}

std::vector<std::size_t> every_frame(const BatchJob& batch) {
  std::vector<std::size_t> all(batch.frames.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

// Counts how many run at a time.
class Watcher final : public FrameEvents {
 public:
  void started(std::size_t frame) override {
    const std::lock_guard lock(mutex_);
    most = std::max(most, ++running_);
    order.push_back(frame);
  }
  bool finished(std::size_t frame, const convert::Outcome& outcome) override {
    const std::lock_guard lock(mutex_);
    --running_;
    ended[frame] = outcome.done();
    if (outcome.error) errors.push_back(outcome.error->message);
    return !stop;
  }

  int most = 0;
  std::vector<std::size_t> order;
  std::map<std::size_t, bool> ended;
  std::vector<std::string> errors;
  bool stop = false;

 private:
  std::mutex mutex_;
  int running_ = 0;
};

TEST(Scheduler, EveryFrameIsDoneOnceWithTheSameBytesForAnyNumberOfJobs) {
  std::map<int, std::vector<std::string>> files;
  for (const int jobs : {1, 2, 5}) {
    const TempFolder folder;
    const BatchJob batch = spheres(folder, 12);
    Watcher watcher;
    const BatchCounts counts = run(batch, every_frame(batch), {.jobs = jobs, .threads = 2}, Context(), watcher);
    EXPECT_EQ(counts.done, 12U);
    EXPECT_EQ(counts.failed + counts.not_started + counts.repeated, 0U);
    EXPECT_LE(watcher.most, jobs);
    EXPECT_EQ(watcher.ended.size(), 12U);
    for (int i = 0; i < 12; ++i) files[jobs].push_back(test::read_bytes(folder / ("f" + std::to_string(i) + ".ply")));
  }
  EXPECT_EQ(files[1], files[2]);
  EXPECT_EQ(files[1], files[5]);
}

TEST(Scheduler, FramesStartInTheirOrder) {
  const TempFolder folder;
  const BatchJob batch = spheres(folder, 6);
  Watcher watcher;
  const std::vector<std::size_t> which{1, 3, 4};
  EXPECT_EQ(run(batch, which, {}, Context(), watcher).done, 3U);
  EXPECT_EQ(watcher.order, which);
}

TEST(Scheduler, ABadFrameStopsNoOtherUnlessToldTo) {
  const TempFolder folder;
  BatchJob batch = spheres(folder, 6);
  batch.frames[2].job.source.input = (folder / "none.vdb").string();
  Watcher watcher;
  BatchCounts counts = run(batch, every_frame(batch), {.jobs = 2, .threads = 2}, Context(), watcher);
  EXPECT_EQ(counts.done, 5U);
  EXPECT_EQ(counts.failed, 1U);
  EXPECT_FALSE(watcher.ended.at(2));

  Watcher hasty;
  counts = run(batch, every_frame(batch), {.fail_fast = true}, Context(), hasty);
  EXPECT_EQ(counts.done, 2U);
  EXPECT_EQ(counts.failed, 1U);
  EXPECT_EQ(counts.not_started, 3U);

  Watcher stopping;
  stopping.stop = true;
  counts = run(batch, every_frame(batch), {}, Context(), stopping);
  EXPECT_EQ(counts.done, 1U);
  EXPECT_EQ(counts.not_started, 5U);
}

// Each needs most of the budget: side by side they cannot be done, one after another they can.
TEST(Scheduler, FramesThatDoNotFitSideBySideAreDoneAllTheSame) {
  const TempFolder folder;
  const BatchJob batch = spheres(folder, 6, "demo:gyroid?size=64");
  Watcher alone;
  const Context measuring;
  ASSERT_EQ(run(batch, std::vector<std::size_t>{0}, {}, measuring, alone).done, 1U);
  const std::uint64_t one = measuring.memory().peak();
  const Context tight{MemoryBudget(one + one / 4)};
  Watcher watcher;
  const BatchCounts counts = run(batch, every_frame(batch), {.jobs = 3, .threads = 2}, tight, watcher);
  EXPECT_EQ(counts.done, 6U) << watcher.errors.front();
  EXPECT_EQ(counts.failed, 0U);
  EXPECT_LE(tight.memory().peak(), one + one / 4);
  // One that is known to be too large for two at a time never starts beside another.
  Watcher told;
  const Context again{MemoryBudget(one + one / 4)};
  EXPECT_EQ(run(batch, every_frame(batch), {.jobs = 3, .threads = 2, .memory_of_one = one}, again, told).repeated, 0U);
  EXPECT_EQ(told.most, 1);
}

TEST(Scheduler, AFrameThatDoesNotFitAtAllFailsAndTheOthersAreDone) {
  const TempFolder folder;
  BatchJob batch = spheres(folder, 4);
  batch.frames[1].job.source.input = "demo:gyroid?size=256";
  const Context tight{MemoryBudget(std::uint64_t{24} << 20U)};
  Watcher watcher;
  const BatchCounts counts = run(batch, every_frame(batch), {.jobs = 2, .threads = 2}, tight, watcher);
  EXPECT_EQ(counts.done, 3U);
  EXPECT_EQ(counts.failed, 1U);
  EXPECT_FALSE(watcher.ended.at(1));
}

TEST(Scheduler, NothingStartsOnceTheEndIsAskedFor) {
  const TempFolder folder;
  const BatchJob batch = spheres(folder, 3);
  const Context context;
  context.cancel();
  Watcher watcher;
  const BatchCounts counts = run(batch, every_frame(batch), {.jobs = 2}, context, watcher);
  EXPECT_EQ(counts.not_started, 3U);
  EXPECT_TRUE(watcher.order.empty());
}

}  // namespace
}  // namespace isoextract::batch
