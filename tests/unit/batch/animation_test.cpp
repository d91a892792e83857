#include "batch/detail/animation.hpp"

#include <array>
#include <numeric>

#include <gtest/gtest.h>

#include "support/temp_folder.hpp"

namespace isoextract::batch {
namespace {

using test::read_bytes;
using test::TempFolder;
using test::write_bytes;

TEST(AnimationStarts, FollowUnevenFrameTimes) {
  using Times = std::vector<particle_io::FrameTime>;
  const auto starts = [](const std::vector<std::int64_t>& numbers, const Times& times) {
    return animation_starts(numbers, times, 10);
  };
  const auto at = [](std::vector<double> times) {
    Times frames;
    for (const double time : times) frames.push_back({std::nullopt, time});
    return frames;
  };
  const std::vector<double> uneven = starts({0, 1, 2, 3}, at({5, 6, 9, 11}));
  ASSERT_EQ(uneven.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(uneven[i], (std::array{0.0, 0.05, 0.2, 0.3})[i], 1e-12);
  EXPECT_NEAR(starts({0, 10, 40}, at({0, 2, 4}))[1], 2, 1e-12) << "the numbers count for the length only";
  EXPECT_EQ(starts({0, 1, 2, 3}, at({0.1, 0.2, 0.3, 0.4})), std::vector<double>()) << "even, but for rounding";
  EXPECT_EQ(starts({0, 10, 40}, at({0, 1, 4})), std::vector<double>()) << "as by the numbers";
  EXPECT_EQ(starts({0, 1, 2}, at({0, 2, 2})), std::vector<double>());
  EXPECT_EQ(starts({0, 1, 2}, at({3, 2, 9})), std::vector<double>());
  EXPECT_EQ(starts({0, 1, 2}, {{0, 0.0}, {1, std::nullopt}, {2, 9.0}}), std::vector<double>());
  EXPECT_EQ(starts({0, 1}, at({0, 5})), std::vector<double>());
}

class AnimationTest : public testing::Test {
 protected:
  AnimationTest() {
    batch_.animation = AnimationJob{(folder_ / "water.glb").string(), 24};
    for (int i = 0; i < 4; ++i) {
      std::string samples(216, '\0');
      samples[86] = static_cast<char>(100 + i);
      write_bytes(input(i), samples);
      convert::ConversionJob job;
      job.source.input = input(i).string();
      volume_io::RawLayout raw;
      raw.dims = {6, 6, 6};
      job.source.read.raw = raw;
      job.outputs = {{batch_.animation->path, {50.0}}};
      batch_.frames.push_back({i, job});
    }
  }

  [[nodiscard]] std::filesystem::path input(int i) const { return folder_ / ("in" + std::to_string(i) + ".raw"); }

  // Writes all frames into files of at most `largest` bytes each.
  mesh_io::MeshWriteResult write(std::uint64_t largest = mesh_io::kLargestGlb) {
    const Context context;
    Animation animation(batch_, context, largest);
    EXPECT_TRUE(animation.check());
    std::vector<std::size_t> all(batch_.frames.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    FrameEvents unheard;
    EXPECT_EQ(run(batch_, all, {.jobs = 2, .threads = 2}, context, unheard, &animation).failed, 0U);
    EXPECT_FALSE(animation.lost());
    auto written = animation.finish();
    EXPECT_TRUE(written) << written.error().message;
    return std::move(*written);
  }

  [[nodiscard]] std::vector<FrameRecord> records() const {
    std::vector<FrameRecord> records;
    for (const FrameJob& frame : batch_.frames) {
      auto inputs = input_states(frame, Context());
      EXPECT_TRUE(inputs);
      convert::Outcome outcome;
      auto record = record_of(frame, std::move(*inputs), outcome, Context());
      EXPECT_TRUE(record);
      records.push_back(std::move(*record));
    }
    return records;
  }

  [[nodiscard]] Manifest manifest(bool resume) const {
    auto opened = Manifest::open(folder_.path(), header_of(batch_, {}, {}), resume, {});
    EXPECT_TRUE(opened) << opened.error().message;
    return std::move(*opened);
  }

  // Returns whether a later run would keep the animation.
  [[nodiscard]] bool is_kept() const { return find_animation_record(manifest(true), batch_).has_value(); }

  TempFolder folder_;
  BatchJob batch_;
};

TEST_F(AnimationTest, KeepsAllFilesOrNone) {
  const auto whole = write();
  ASSERT_EQ(whole.files.size(), 1U);
  const auto written = write(whole.files.front().bytes * 3 / 4);
  ASSERT_GE(written.files.size(), 2U);
  EXPECT_EQ(written.files[1].path, (folder_ / "water.part2.glb").string());
  {
    Manifest begun = manifest(false);
    EXPECT_FALSE(find_animation_record(begun, batch_));
    ASSERT_TRUE(record_animation(begun, batch_, records(), written));
  }
  ASSERT_TRUE(is_kept());
  const auto kept = find_animation_record(manifest(true), batch_);
  ASSERT_EQ(kept->size(), 4U);
  EXPECT_EQ(kept->at(2).frame, 2);
  EXPECT_EQ(kept->at(2).outputs.size(), written.files.size());

  const std::string part = read_bytes(folder_ / "water.part2.glb");
  write_bytes(folder_ / "water.part2.glb", "truncated");
  EXPECT_FALSE(is_kept());
  write_bytes(folder_ / "water.part2.glb", part);
  EXPECT_TRUE(is_kept());
  batch_.animation->frames_per_second = 25;
  EXPECT_FALSE(is_kept());
  batch_.animation->frames_per_second = 24;
  EXPECT_TRUE(is_kept());
  batch_.frames[1].job.outputs.front().isos = {60};
  EXPECT_FALSE(is_kept());
  batch_.frames[1].job.outputs.front().isos = {50};
  write_bytes(input(3), std::string(216, 'x'));
  EXPECT_FALSE(is_kept());
}

// The frames of an animation have no files, so a later run that writes one must not find a record for it.
TEST_F(AnimationTest, SeparatesRecordsFromJobRecords) {
  const auto written = write();
  Manifest manifest_of_it = manifest(false);
  ASSERT_TRUE(record_animation(manifest_of_it, batch_, records(), written));
  for (const FrameJob& frame : batch_.frames) EXPECT_EQ(manifest_of_it.find(convert::hash_of(frame.job)), nullptr);
}

TEST_F(AnimationTest, IgnoresTruncatedRecord) {
  {
    Manifest begun = manifest(false);
    ASSERT_TRUE(record_animation(begun, batch_, records(), write()));
  }
  const std::string text = read_bytes(folder_ / "isoextract.manifest");
  for (std::size_t bytes = 0; bytes < text.size(); bytes += 97) {
    write_bytes(folder_ / "isoextract.manifest", text.substr(0, bytes));
    ASSERT_FALSE(is_kept()) << bytes;
  }
  write_bytes(folder_ / "isoextract.manifest", text);
  EXPECT_TRUE(is_kept());
}

TEST_F(AnimationTest, WritesNoFileWithoutSurfaces) {
  for (FrameJob& frame : batch_.frames) {
    frame.job.outputs.front().isos = {200};
    frame.job.empty = convert::EmptyPolicy::skip;
  }
  write_bytes(folder_ / "water.glb", "old");
  const auto written = write();
  EXPECT_TRUE(written.files.empty());
  ASSERT_EQ(written.notes.size(), 1U);
  EXPECT_NE(written.notes.front().text.find("removed the old file"), std::string::npos);
  EXPECT_FALSE(folder_.names().contains("water.glb"));
}

}  // namespace
}  // namespace isoextract::batch
