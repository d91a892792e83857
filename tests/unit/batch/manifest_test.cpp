#include "batch/manifest.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <unordered_set>

#include <gtest/gtest.h>

#include "batch/shard.hpp"
#include "convert/conversion.hpp"
#include "convert/json_values.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::batch {
namespace {

using test::read_bytes;
using test::TempFolder;
using test::write_bytes;

BatchJob three_frames(const TempFolder& folder, double iso = 0) {
  BatchJob batch;
  for (int i = 1; i <= 3; ++i) {
    convert::ConversionJob job;
    job.source.input = (folder / ("in" + std::to_string(i) + ".raw")).string();
    volume_io::RawLayout raw;
    raw.dims = {4, 4, 4};
    job.source.read.raw = raw;
    job.file = convert::MeshFileOptions{mesh_io::MeshFormat::ply};
    job.normals = convert::Normals::none;
    job.outputs = {{(folder / ("out" + std::to_string(i) + ".ply")).string(), {iso}}};
    batch.frames.push_back({i, job});
    std::string bytes(64, '\0');
    bytes[21] = static_cast<char>(9 + i);
    write_bytes(folder / ("in" + std::to_string(i) + ".raw"), bytes);
  }
  return batch;
}

FrameRecord convert_frame(const FrameJob& frame) {
  auto inputs = input_states(frame, Context());
  EXPECT_TRUE(inputs);
  convert::Events unheard;
  const convert::Outcome outcome = convert::run(frame.job, Context(), unheard, {.mesh_facts = true});
  EXPECT_TRUE(outcome.done()) << outcome.error->message;
  auto record = record_of(frame, std::move(*inputs), outcome, Context());
  EXPECT_TRUE(record);
  return *record;
}

std::unordered_set<std::string> jobs_of(const BatchJob& batch) {
  std::unordered_set<std::string> jobs;
  for (const FrameJob& frame : batch.frames) jobs.insert(convert::hash_of(frame.job));
  return jobs;
}

Manifest must_open(const TempFolder& folder, const BatchJob& batch, bool resume, const Shard& shard = {}) {
  auto manifest = Manifest::open(folder.path(), header_of(batch, shard, {"a", "b"}), resume, jobs_of(batch));
  EXPECT_TRUE(manifest) << manifest.error().message;
  return std::move(*manifest);
}

TEST(Manifest, RestoresRecord) {
  const TempFolder folder;
  const BatchJob batch = three_frames(folder);
  const FrameRecord record = convert_frame(batch.frames[0]);
  EXPECT_EQ(record.figures.surfaces.at(0).closed, true);
  EXPECT_GT(record.figures.surfaces.at(0).volume.value(), 0);
  EXPECT_EQ(record.inputs.size(), 1U);
  EXPECT_EQ(record.outputs.size(), 1U);
  EXPECT_EQ(record_of(json_of(record)), record);
  FrameRecord of_grids = record;
  of_grids.figures.surfaces.at(0).grid =
      "fl\xff"
      "ame";
  EXPECT_EQ(record_of(json_of(of_grids)), of_grids);
  // Manifests written before conversions could have several grids name no grid.
  EXPECT_FALSE(json_of(record)["figures"]["surfaces"][0].contains("grid"));
  {
    Manifest manifest = must_open(folder, batch, false);
    ASSERT_TRUE(manifest.add(record));
  }
  const Manifest manifest = must_open(folder, batch, true);
  ASSERT_NE(manifest.find(record.job), nullptr);
  EXPECT_EQ(*manifest.find(record.job), record);
  EXPECT_EQ(manifest.find("another"), nullptr);
  EXPECT_EQ(reason_to_reconvert(record, batch.frames[0]), "");
}

TEST(Manifest, KeepsRecordUntilFrameBeginsAgain) {
  const TempFolder folder;
  const BatchJob batch = three_frames(folder);
  const FrameRecord first = convert_frame(batch.frames[0]);
  const FrameRecord second = convert_frame(batch.frames[1]);
  {
    Manifest manifest = must_open(folder, batch, false);
    ASSERT_TRUE(manifest.add(first));
    ASSERT_TRUE(manifest.add(second));
  }
  {
    Manifest manifest = must_open(folder, batch, false);
    EXPECT_EQ(manifest.find(first.job), nullptr) << "nothing was to be resumed";
    ASSERT_TRUE(manifest.revoke(first.job));
  }
  {
    Manifest manifest = must_open(folder, batch, true);
    EXPECT_EQ(manifest.find(first.job), nullptr);
    ASSERT_NE(manifest.find(second.job), nullptr) << "it was not started";
    ASSERT_TRUE(manifest.revoke(second.job));
    EXPECT_EQ(manifest.find(second.job), nullptr);
    ASSERT_TRUE(manifest.add(second));
  }
  EXPECT_EQ(*must_open(folder, batch, true).find(second.job), second);
}

TEST(Manifest, RestoresNamesOfAnyBytes) {
  FrameRecord record;
  record.inputs = {{"a\xff\n\"b", {1, 2, "x"}}};
  EXPECT_EQ(record_of(json_of(record)), record);
}

// Truncates the file at lengths that a crash can leave.
TEST(Manifest, IgnoresTruncatedLines) {
  const TempFolder folder;
  const BatchJob batch = three_frames(folder);
  const FrameRecord first = convert_frame(batch.frames[0]);
  const FrameRecord second = convert_frame(batch.frames[1]);
  std::size_t sound = 0;
  std::filesystem::path path;
  {
    Manifest manifest = must_open(folder, batch, false);
    ASSERT_TRUE(manifest.add(first));
    path = manifest.path();
    sound = read_bytes(path).size();
    ASSERT_TRUE(manifest.add(second));
  }
  const std::string whole = read_bytes(path);
  for (std::size_t size = sound; size < whole.size(); size += 17) {
    write_bytes(path, whole.substr(0, size));
    {
      Manifest manifest = must_open(folder, batch, true);
      EXPECT_NE(manifest.find(first.job), nullptr);
      EXPECT_EQ(manifest.find(second.job), nullptr);
      ASSERT_TRUE(manifest.add(second));
    }
    EXPECT_EQ(read_bytes(path), whole);
  }
  for (std::size_t at = sound; at < whole.size(); at += 13) {  // a byte is damaged
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write_bytes(path, damaged);
    EXPECT_EQ(must_open(folder, batch, true).find(second.job), nullptr) << at;
  }
  write_bytes(path, whole.substr(0, 20));  // truncated within the header
  EXPECT_EQ(must_open(folder, batch, true).find(first.job), nullptr);
}

TEST(Manifest, TrustsOnlyUnchangedFiles) {
  const TempFolder folder;
  const BatchJob batch = three_frames(folder);
  const FrameRecord record = convert_frame(batch.frames[0]);
  const auto out = folder / "out1.ply";
  const auto in = folder / "in1.raw";
  const std::string mesh = read_bytes(out);
  std::string other = mesh;
  other.back() = static_cast<char>(other.back() ^ 1);
  write_bytes(out, other);
  EXPECT_NE(reason_to_reconvert(record, batch.frames[0]).find("out1.ply has changed"), std::string::npos);
  write_bytes(out, mesh);
  EXPECT_EQ(reason_to_reconvert(record, batch.frames[0]), "");
  std::filesystem::remove(out);
  EXPECT_NE(reason_to_reconvert(record, batch.frames[0]), "");
  write_bytes(out, mesh);
  std::string samples = read_bytes(in);
  const auto time = std::filesystem::last_write_time(in);
  samples[22] = 1;
  write_bytes(in, samples);
  std::filesystem::last_write_time(in, time);  // same size and time, but another content
  EXPECT_NE(reason_to_reconvert(record, batch.frames[0]).find("in1.raw has changed"), std::string::npos);
  EXPECT_EQ(reason_to_reconvert(record, three_frames(folder, 1).frames[0]), "its options have changed");
  FrameRecord without_inputs = convert_frame(batch.frames[0]);
  without_inputs.inputs.clear();  // the file became readable only after the frame had begun
  EXPECT_EQ(reason_to_reconvert(without_inputs, batch.frames[0]), "its record lists no inputs");
}

TEST(Manifest, IgnoresOtherVersionsAndKeepsOtherFiles) {
  const TempFolder folder;
  const BatchJob batch = three_frames(folder);
  const FrameRecord record = convert_frame(batch.frames[0]);
  ManifestHeader header = header_of(batch, {}, {});
  header.program = "isoextract 0.0.0";
  {
    auto manifest = Manifest::open(folder.path(), header, false, jobs_of(batch));
    ASSERT_TRUE(manifest);
    ASSERT_TRUE(manifest->add(record));
  }
  EXPECT_EQ(must_open(folder, batch, true).find(record.job), nullptr);
  write_bytes(folder / "isoextract.manifest", "my notes");
  const auto refused = Manifest::open(folder.path(), header, false, jobs_of(batch));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::output);
  EXPECT_EQ(read_bytes(folder / "isoextract.manifest"), "my notes");
}

TEST(Manifest, KeepsFramesSharedByBatches) {
  const TempFolder folder;
  BatchJob batch = three_frames(folder);
  const FrameRecord record = convert_frame(batch.frames[0]);
  ASSERT_TRUE(must_open(folder, batch, false).add(record));
  batch.frames.pop_back();
  const Manifest manifest = must_open(folder, batch, true);
  EXPECT_NE(manifest.find(record.job), nullptr);
  const auto content = read_manifest(manifest.path());
  ASSERT_TRUE(content);
  EXPECT_EQ(content->header.batch, hash_of(batch));
  EXPECT_EQ(content->records, std::vector{record});
}

TEST(Manifest, KeepsRecordsOfOtherBatch) {
  const TempFolder folder;
  const BatchJob batch = three_frames(folder);
  const BatchJob other = three_frames(folder, 1);
  const FrameRecord record = convert_frame(batch.frames[0]);
  ASSERT_TRUE(must_open(folder, batch, false).add(record));
  {
    Manifest manifest = must_open(folder, other, false);
    EXPECT_EQ(manifest.find(record.job), nullptr) << "nothing was to be resumed";
    ASSERT_TRUE(manifest.add(convert_frame(other.frames[1])));
  }
  EXPECT_NE(must_open(folder, batch, true).find(record.job), nullptr);
  EXPECT_NE(must_open(folder, other, true).find(convert::hash_of(other.frames[1].job)), nullptr);
}

TEST(Manifest, DropsShardRecordsOutsideItsBatch) {
  const TempFolder folder;
  const Shard shard{1, 2};
  BatchJob batch = three_frames(folder);
  const FrameRecord first = convert_frame(batch.frames[0]);
  const FrameRecord third = convert_frame(batch.frames[2]);
  {
    Manifest manifest = must_open(folder, batch, false, shard);
    ASSERT_TRUE(manifest.add(first));
    ASSERT_TRUE(manifest.add(third));
  }
  batch.frames.pop_back();
  const Manifest manifest = must_open(folder, batch, true, shard);
  EXPECT_NE(manifest.find(first.job), nullptr);
  EXPECT_EQ(read_manifest(manifest.path()).value().records, std::vector{first});
}

TEST(Manifest, LocksOutOtherRunsButNotShards) {
  const TempFolder folder;
  const BatchJob batch = three_frames(folder);
  const auto opens_elsewhere = [&](const Shard& shard) {  // locks belong to a process
    const pid_t child = ::fork();
    if (child == 0) ::_exit(Manifest::open(folder.path(), header_of(batch, shard, {}), true, {}) ? 0 : 1);
    int status = 0;
    ::waitpid(child, &status, 0);
    return WEXITSTATUS(status) == 0;
  };
  {
    const Manifest whole = must_open(folder, batch, false);
    EXPECT_FALSE(opens_elsewhere({}));
    EXPECT_FALSE(opens_elsewhere({1, 2}));
  }
  const Manifest first = must_open(folder, batch, false, {1, 2});
  EXPECT_FALSE(opens_elsewhere({}));
  EXPECT_FALSE(opens_elsewhere({1, 2}));
  EXPECT_TRUE(opens_elsewhere({2, 2}));
}

}  // namespace
}  // namespace isoextract::batch
