#include "batch/shard.hpp"

#include <map>

#include <gtest/gtest.h>

#include "batch/manifest.hpp"
#include "batch/merge_shards.hpp"
#include "support/hints.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::batch {
namespace {

using test::TempFolder;
using test::write_bytes;

TEST(Shard, ParsesText) {
  EXPECT_EQ(parse_shard("2/3").value(), ShardChoice{(Shard{2, 3})});
  EXPECT_EQ(parse_shard("1/1").value(), ShardChoice{Shard()});
  EXPECT_EQ(parse_shard("auto").value(), ShardChoice());
  for (const char* bad : {"", "1", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "a/b", " 1/2", "1/99999999999"}) {
    const auto shard = parse_shard(bad);
    ASSERT_FALSE(shard) << bad;
    EXPECT_EQ(shard.error().code, ErrorCode::usage);
  }
}

Result<std::optional<Shard>> shard_told_by(const std::map<std::string, std::string>& variables) {
  return shard_of_environment([&](const char* name) -> const char* {
    const auto variable = variables.find(name);
    return variable == variables.end() ? nullptr : variable->second.c_str();
  });
}

TEST(Shard, ReadsJobSchedulerVariables) {
  EXPECT_EQ(shard_told_by({}).value(), std::nullopt);
  EXPECT_EQ(shard_told_by({{"SLURM_ARRAY_TASK_ID", "3"},
                           {"SLURM_ARRAY_TASK_MIN", "1"},
                           {"SLURM_ARRAY_TASK_COUNT", "4"},
                           {"SLURM_ARRAY_TASK_STEP", "1"}})
                .value(),
            (Shard{3, 4}));
  EXPECT_EQ(shard_told_by({{"SLURM_ARRAY_TASK_ID", "20"},
                           {"SLURM_ARRAY_TASK_MIN", "10"},
                           {"SLURM_ARRAY_TASK_COUNT", "3"},
                           {"SLURM_ARRAY_TASK_STEP", "5"}})
                .value(),
            (Shard{3, 3}));
  EXPECT_EQ(shard_told_by({{"JOB_COMPLETION_INDEX", "0"}, {"JOB_COMPLETIONS", "2"}}).value(), (Shard{1, 2}));
  EXPECT_FALSE(shard_told_by({{"SLURM_ARRAY_TASK_ID", "3"}})) << "of how many is not said";
  const auto without_count = shard_told_by({{"JOB_COMPLETION_INDEX", "0"}});
  ASSERT_FALSE(without_count);
  EXPECT_NE(test::text_of(without_count.error().hint).find("spec.completions"), std::string::npos);
  EXPECT_FALSE(shard_told_by({{"JOB_COMPLETION_INDEX", "2"}, {"JOB_COMPLETIONS", "2"}}));
  EXPECT_FALSE(shard_told_by({{"JOB_COMPLETION_INDEX", "x"}, {"JOB_COMPLETIONS", "2"}}));
  EXPECT_FALSE(shard_told_by({{"SLURM_ARRAY_TASK_ID", "21"},
                              {"SLURM_ARRAY_TASK_MIN", "10"},
                              {"SLURM_ARRAY_TASK_COUNT", "3"},
                              {"SLURM_ARRAY_TASK_STEP", "5"}}));
}

TEST(Shard, CoversEveryFrameOnce) {
  BatchJob batch;
  batch.frames.resize(10);
  for (const int count : {1, 3, 10, 12}) {
    std::vector<int> times(10);
    for (int number = 1; number <= count; ++number) {
      for (const std::size_t frame : frames_of(batch, {number, count})) ++times[frame];
    }
    EXPECT_EQ(times, std::vector<int>(10, 1)) << count;
  }
}

// Manifests of three shards with six frames, whose outputs are text files.
class Merge : public testing::Test {
 protected:
  Merge() {
    for (int i = 0; i < 6; ++i) {
      FrameJob frame;
      frame.number = i;
      frame.job.source.input = "demo:sphere";
      frame.job.outputs = {{(folder_ / ("f" + std::to_string(i))).string(), {0.0}}};
      write_bytes(folder_ / ("f" + std::to_string(i)), std::string("frame ") + std::to_string(i));
      batch_.frames.push_back(frame);
    }
  }

  void write_shard(const Shard& shard, std::size_t leave_out = 99) {
    auto manifest = Manifest::open(folder_.path(), header_of(batch_, shard, {}), false, {});
    ASSERT_TRUE(manifest);
    for (const std::size_t i : frames_of(batch_, shard)) {
      if (i == leave_out) continue;
      FrameRecord record;
      record.frame = batch_.frames[i].number;
      record.job = convert::hash_of(batch_.frames[i].job);
      const std::string path = batch_.frames[i].job.outputs[0].path;
      record.outputs = {{path, files::hash_file(path, Context()).value()}};
      ASSERT_TRUE(manifest->add(record));
    }
  }

  void expect_refused(const std::string& part) {
    const auto merged = merge_shards(folder_.path());
    ASSERT_FALSE(merged);
    EXPECT_EQ(merged.error().code, ErrorCode::input);
    EXPECT_NE(merged.error().message.find(part), std::string::npos) << merged.error().message;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "isoextract.manifest"));
  }

  TempFolder folder_;
  BatchJob batch_;
};

TEST_F(Merge, JoinsAllShards) {
  for (int number = 1; number <= 3; ++number) write_shard({number, 3});
  const auto merged = merge_shards(folder_.path());
  ASSERT_TRUE(merged) << merged.error().message;
  EXPECT_EQ(merged->frames, 6U);
  const auto content = read_manifest(merged->manifest);
  ASSERT_TRUE(content);
  EXPECT_EQ(content->header.shard, Shard());
  EXPECT_EQ(content->header.batch, hash_of(batch_));
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(content->records.at(i).frame, static_cast<std::int64_t>(i));
}

TEST_F(Merge, RefusesMissingRepeatedOrForeignShards) {
  expect_refused("no manifest of a shard");
  write_shard({1, 3});
  expect_refused("shards 2-3 of 3 are missing: there is no isoextract.2-of-3.manifest, for example");
  write_shard({3, 3});
  expect_refused("shard 2 of 3 is missing: there is no isoextract.2-of-3.manifest");
  EXPECT_EQ(test::text_of(merge_shards(folder_.path()).error().hint),
            "run shard 2 of 3 with the options of the others, then merge again; or copy manifest and outputs from the "
            "machine that has them");
  write_shard({2, 3}, 4);
  expect_refused("expected 6 frames, found 5: 1 is missing: 4");
  write_shard({2, 3});
  std::filesystem::copy_file(folder_ / "isoextract.2-of-3.manifest", folder_ / "isoextract.copy.manifest");
  expect_refused("expected each shard once, found shard 2 twice");
  std::filesystem::remove(folder_ / "isoextract.copy.manifest");
  write_bytes(folder_ / "f4", "another");
  expect_refused("f4: this file has changed since its shard wrote it");
  write_bytes(folder_ / "f4", "frame 4");
  batch_.frames[0].job.normals = convert::Normals::flat;
  write_shard({3, 3});
  expect_refused("are of different batches");
}

}  // namespace
}  // namespace isoextract::batch
