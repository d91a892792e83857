#include "batch/scheduler.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "support/temp_folder.hpp"

namespace isoextract::batch {
namespace {

using test::TempFolder;

convert::ConversionJob sphere_job(const TempFolder& folder, int number, const std::string& input) {
  convert::ConversionJob job;
  job.source.input = input;
  job.normals = convert::Normals::none;
  job.file = convert::MeshFileOptions{mesh_io::MeshFormat::ply};
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

// Counts how many frames run at a time.
class Watcher final : public FrameEvents {
 public:
  convert::Events* started(std::size_t frame, const Context& /*context*/) override {
    const std::lock_guard lock(mutex_);
    most = std::max(most, ++running_);
    order.push_back(frame);
    return nullptr;
  }
  bool finished(std::size_t frame, convert::Outcome& outcome) override {
    if (!outcome.done()) std::this_thread::sleep_for(pause_after_a_failure);
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
  std::chrono::milliseconds pause_after_a_failure{0};

 private:
  std::mutex mutex_;
  int running_ = 0;
};

TEST(Scheduler, WritesSameBytesForAnyNumberOfJobs) {
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

TEST(Scheduler, StartsFramesInOrder) {
  const TempFolder folder;
  const BatchJob batch = spheres(folder, 6);
  Watcher watcher;
  const std::vector<std::size_t> which{1, 3, 4};
  EXPECT_EQ(run(batch, which, {}, Context(), watcher).done, 3U);
  EXPECT_EQ(watcher.order, which);
}

TEST(Scheduler, StopsAfterFailureOnlyWithFailFast) {
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

// Each frame needs most of the budget, so frames cannot be converted side by side, but can one after another.
TEST(Scheduler, RepeatsFramesThatLackMemoryTogether) {
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
  // With the memory of one frame known, no frame starts beside another.
  Watcher told;
  const Context again{MemoryBudget(one + one / 4)};
  EXPECT_EQ(run(batch, every_frame(batch), {.jobs = 3, .threads = 2, .memory_per_frame = one}, again, told).repeated,
            0U);
  EXPECT_EQ(told.most, 1);
}

TEST(Scheduler, FailsFrameTooLargeForBudget) {
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

// Records the frames that it receives, and can refuse one.
class Basket final : public FrameReceiver {
 public:
  explicit Basket(const Context& context) : context_(context) {}

  Result<std::vector<mesh_io::PackedFacts>> take(std::size_t frame, const convert::MeshCollector& collected) override {
    if (frame == refused) return fail(ErrorCode::output, "refused");
    if (frame == 1 && first_error) return tl::unexpected(*std::exchange(first_error, std::nullopt));
    if (frame == cancels_at) context_.cancel();
    frames.push_back(frame);
    for (const mesh::Mesh& surface : collected.meshes) triangles.push_back(surface.triangles.size());
    if (held.size() < frames.size()) held.push_back(context_.memory().reserved());
    return std::vector<mesh_io::PackedFacts>();
  }

  std::size_t refused = std::string::npos;
  std::optional<Error> first_error;  // returned when it first receives frame 1
  std::size_t cancels_at = std::string::npos;
  std::vector<std::size_t> frames;
  std::vector<std::size_t> triangles;
  std::vector<std::uint64_t> held;  // reserved by all frames together, at each frame received

 private:
  const Context& context_;
};

// Returns frames of very different sizes, large ones first, so that they finish in another order than they start.
BatchJob uneven(const TempFolder& folder, int count) {
  BatchJob batch;
  for (int i = 0; i < count; ++i) {
    batch.frames.push_back({i, sphere_job(folder, 0, "demo:sphere?size=" + std::to_string(i % 3 == 0 ? 64 : 12))});
  }
  return batch;
}

TEST(Scheduler, HandsFramesToReceiverInOrder) {
  const TempFolder folder;
  BatchJob batch = uneven(folder, 12);
  batch.frames[4].job.source.input = (folder / "none.vdb").string();
  batch.frames[7].job.outputs.front().isos = {99};  // no surface
  batch.frames[7].job.empty = convert::EmptyPolicy::skip;
  std::vector<std::size_t> triangles;
  for (const int jobs : {1, 2, 5}) {
    const Context context;
    Basket basket(context);
    basket.refused = 9;
    Watcher watcher;
    const BatchCounts counts = run(batch, every_frame(batch), {.jobs = jobs, .threads = 2}, context, watcher, &basket);
    EXPECT_EQ(basket.frames, (std::vector<std::size_t>{0, 1, 2, 3, 5, 6, 7, 8, 10, 11}));
    EXPECT_EQ(counts.done, 10U);
    EXPECT_EQ(counts.failed, 2U);
    EXPECT_EQ(watcher.ended.size(), 12U);
    EXPECT_TRUE(watcher.ended.at(7));
    EXPECT_FALSE(watcher.ended.at(9));
    EXPECT_LE(watcher.most, jobs);
    if (jobs == 1) triangles = basket.triangles;
    EXPECT_EQ(basket.triangles, triangles);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Scheduler, HoldsOneWaitingFramePerJob) {
  const TempFolder folder;
  const BatchJob batch = spheres(folder, 40, "demo:gyroid?size=32");
  Watcher watcher;
  const Context one;
  Basket measured(one);
  ASSERT_EQ(run(batch, std::vector<std::size_t>{0}, {}, one, watcher, &measured).done, 1U);
  const Context context;
  Basket basket(context);
  EXPECT_EQ(run(batch, every_frame(batch), {.jobs = 3, .threads = 2}, context, watcher, &basket).done, 40U);
  EXPECT_LE(context.memory().peak(), 3 * one.memory().peak());
  EXPECT_EQ(context.memory().reserved(), 0U);
  const Context alone;
  Basket again(alone);
  ASSERT_EQ(run(batch, every_frame(batch), {}, alone, watcher, &again).done, 40U);
  EXPECT_EQ(alone.memory().peak(), one.memory().peak());
  EXPECT_EQ(std::ranges::min(again.held), std::ranges::max(again.held));
}

TEST(Scheduler, RepeatsAloneIfReceiverLacksMemory) {
  const TempFolder folder;
  const BatchJob batch = spheres(folder, 6, "demo:gyroid?size=48");
  const Context context;
  Basket basket(context);
  basket.first_error = Error{ErrorCode::out_of_memory, "no memory", {}};
  Watcher watcher;
  const BatchCounts counts = run(batch, every_frame(batch), {.jobs = 3, .threads = 2}, context, watcher, &basket);
  EXPECT_EQ(counts.done, 6U);
  EXPECT_GE(counts.repeated, 1U);
  EXPECT_EQ(basket.frames, every_frame(batch));
}

TEST(Scheduler, RepeatsOnlyFramesThatLackedMemory) {
  const TempFolder folder;
  const BatchJob batch = spheres(folder, 6, "demo:gyroid?size=48");
  const Context context;
  Basket basket(context);
  basket.first_error = Error{ErrorCode::input, "more vertices than a mesh can number", {Remedy::use, Setting::parts}};
  Watcher watcher;
  const BatchCounts counts = run(batch, every_frame(batch), {.jobs = 3, .threads = 2}, context, watcher, &basket);
  EXPECT_EQ(counts.done, 5U);
  EXPECT_EQ(counts.failed, 1U);
  EXPECT_FALSE(watcher.ended.at(1));
}

TEST(Scheduler, HandsOverSameFramesIfMemoryIsShort) {
  const TempFolder folder;
  const BatchJob batch = spheres(folder, 8, "demo:gyroid?size=64");
  Watcher alone;
  const Context measuring;
  Basket first(measuring);
  ASSERT_EQ(run(batch, std::vector<std::size_t>{0}, {}, measuring, alone, &first).done, 1U);
  const std::uint64_t one = measuring.memory().peak();
  std::size_t repeated = 0;
  for (const std::uint64_t limit : {one + one / 8, one + one / 2, 2 * one}) {
    const Context tight{MemoryBudget(limit)};
    Basket basket(tight);
    Watcher watcher;
    const BatchCounts counts = run(batch, every_frame(batch), {.jobs = 4, .threads = 2}, tight, watcher, &basket);
    EXPECT_EQ(counts.done, 8U);
    EXPECT_EQ(basket.frames, every_frame(batch));
    EXPECT_LE(tight.memory().peak(), limit);
    repeated += counts.repeated;
  }
  EXPECT_GT(repeated, 0U);
}

TEST(Scheduler, WakesWaitingFramesWhenBatchEnds) {
  const TempFolder folder;
  BatchJob batch = uneven(folder, 9);
  Watcher watcher;
  const Context context;
  Basket basket(context);
  basket.refused = 3;  // while others wait behind it
  BatchCounts counts =
      run(batch, every_frame(batch), {.jobs = 4, .threads = 2, .fail_fast = true}, context, watcher, &basket);
  EXPECT_EQ(basket.frames, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(counts.done, 3U);
  EXPECT_EQ(counts.failed + counts.not_started, 6U);

  Watcher other;
  const Context cancelled;
  Basket ended(cancelled);
  ended.cancels_at = 2;
  counts = run(batch, every_frame(batch), {.jobs = 4, .threads = 2}, cancelled, other, &ended);
  EXPECT_EQ(ended.frames, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(counts.done, 3U);
  EXPECT_EQ(counts.failed + counts.not_started, 6U);
}

// The next frame is converted while the listener hears of the failure, but must not be handed over.
TEST(Scheduler, HandsNothingOverAfterFinalFailure) {
  const TempFolder folder;
  const BatchJob batch = uneven(folder, 9);
  Watcher watcher;
  watcher.pause_after_a_failure = std::chrono::milliseconds(200);
  const Context context;
  Basket basket(context);
  basket.refused = 2;  // a small frame before a large one
  const BatchCounts counts =
      run(batch, every_frame(batch), {.jobs = 4, .threads = 2, .fail_fast = true}, context, watcher, &basket);
  EXPECT_EQ(basket.frames, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(counts.done, 2U);
}

TEST(Scheduler, StartsNothingAfterCancel) {
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
