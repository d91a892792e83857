#include "batch/batch_run.hpp"

#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "mesh_io/mesh_writer.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::batch {
namespace {

using test::TempFolder;
using Status = FrameStatus;

BatchJob sphere_frames(const TempFolder& folder, int count = 3) {
  BatchJob batch;
  for (int i = 1; i <= count; ++i) {
    convert::ConversionJob job;
    job.source.input = "demo:sphere?size=" + std::to_string(8 + i);
    job.normals = convert::Normals::none;
    job.file = convert::MeshFileOptions{mesh_io::MeshFormat::ply};
    job.outputs = {{(folder / (std::to_string(i) + ".ply")).string(), {0.0}}};
    batch.frames.push_back({i, job});
  }
  return batch;
}

// Records its events; can lack the report of a frame, or fail to write it.
class Listener final : public RunEvents {
 public:
  convert::Events* started(std::size_t frame, const Context& /*context*/) override {
    const std::lock_guard lock(mutex_);
    converted.insert(frame);
    return nullptr;
  }
  bool has_report(std::size_t frame) override { return frame != lacks_report; }
  Result<void> write_report(std::size_t frame, const convert::Outcome& /*outcome*/) override {
    if (frame == cannot_write) return fail(ErrorCode::output, "the disk is full");
    return {};
  }
  void over(std::size_t frame, const FrameRow& row, convert::Outcome* outcome, const Error* error) override {
    const std::lock_guard lock(mutex_);
    EXPECT_TRUE(ended.emplace(frame, row.status).second) << "told twice of frame " << row.frame;
    EXPECT_EQ(outcome == nullptr, row.status == Status::kept);
    EXPECT_EQ(error != nullptr, row.status == Status::failed);
  }

  std::size_t lacks_report = std::string::npos;
  std::size_t cannot_write = std::string::npos;
  std::set<std::size_t> converted;
  std::map<std::size_t, FrameStatus> ended;

 private:
  std::mutex mutex_;
};

RunResult must_run(const BatchJob& batch, RunOptions options, Listener& listener) {
  options.scheduler.jobs = options.scheduler.threads = 2;
  const Context context;
  auto run = BatchRun::open(batch, std::move(options), context);
  EXPECT_TRUE(run) << run.error().message;
  return run->run(listener);
}

std::vector<FrameStatus> statuses(const RunResult& result) {
  std::vector<FrameStatus> all;
  for (const FrameRow& row : result.rows) all.push_back(row.status);
  return all;
}

TEST(BatchRun, ReconvertsChangedFrames) {
  const TempFolder folder;
  const BatchJob batch = sphere_frames(folder);
  Listener first;
  EXPECT_EQ(statuses(must_run(batch, {}, first)), (std::vector<FrameStatus>(3, Status::done)));
  test::write_bytes(folder / "2.ply", "something else");

  Listener second;
  const RunResult result = must_run(batch, {.resume_policy = ResumePolicy::keep_unchanged}, second);
  EXPECT_EQ(statuses(result), (std::vector{Status::kept, Status::done, Status::kept}));
  EXPECT_EQ(second.converted, (std::set<std::size_t>{1}));
  EXPECT_GT(result.rows[0].figures.surfaces.front().triangles, 0U);
  EXPECT_EQ(result.rows[0].outputs, (std::vector{(folder / "1.ply").string()}));

  test::write_bytes(folder / "2.ply", "something else");
  Listener third;
  EXPECT_EQ(must_run(batch, {.resume_policy = ResumePolicy::keep_existing}, third).count(Status::kept), 3U);
  EXPECT_EQ(test::read_bytes(folder / "2.ply"), "something else");

  Listener fourth;
  EXPECT_EQ(must_run(batch, {}, fourth).count(Status::done), 3U);
  EXPECT_EQ(fourth.converted.size(), 3U);
}

TEST(BatchRun, ReconvertsFramesWithoutReport) {
  const TempFolder folder;
  const BatchJob batch = sphere_frames(folder);
  Listener first;
  first.cannot_write = 0;
  const RunResult begun = must_run(batch, {}, first);
  EXPECT_EQ(statuses(begun), (std::vector{Status::failed, Status::done, Status::done}));
  EXPECT_EQ(begun.rows[0].error, "the disk is full");
  Listener second;
  second.lacks_report = 2;
  EXPECT_EQ(statuses(must_run(batch, {.resume_policy = ResumePolicy::keep_unchanged}, second)),
            (std::vector{Status::done, Status::kept, Status::done}));
}

TEST(BatchRun, WritesNoManifestWithoutRecords) {
  const TempFolder folder;
  Listener listener;
  EXPECT_EQ(must_run(sphere_frames(folder, 1), {.keeps_records = false}, listener).count(Status::done), 1U);
  EXPECT_EQ(folder.names(), (std::set<std::string>{"1.ply"}));
}

TEST(BatchRun, RenamesOldMeshesOfFailedFrames) {
  const TempFolder folder;
  BatchJob batch = sphere_frames(folder);
  Listener first;
  ASSERT_EQ(must_run(batch, {}, first).count(Status::done), 3U);
  const std::string old = test::read_bytes(folder / "3.ply");
  batch.frames[2].job.source.input = (folder / "none.vdb").string();
  const auto read = check_written_files(batch, {}, {}, Context());
  ASSERT_TRUE(read && *read);
  RunOptions options;
  options.scheduler.extras.read = &**read;
  Listener second;
  const RunResult result = must_run(batch, options, second);
  EXPECT_EQ(statuses(result), (std::vector{Status::done, Status::done, Status::failed}));
  EXPECT_EQ(result.set_aside, (std::vector{(folder / "3.ply.old").string()}));
  EXPECT_EQ(test::read_bytes(folder / "3.ply.old"), old);
  EXPECT_FALSE(std::filesystem::exists(folder / "3.ply"));
}

// Returns frames without an input, whose labels have files of their own.
BatchJob label_frames(const TempFolder& folder, int count) {
  BatchJob batch = sphere_frames(folder, count);
  for (FrameJob& frame : batch.frames) {
    frame.job.source.input = (folder / "none.vdb").string();
    frame.job.outputs = {
        {(folder / (std::to_string(frame.number) + "_{label}.ply")).string(), {convert::IsoChoice::all_labels()}}};
  }
  return batch;
}

void write_old_mesh(const std::filesystem::path& path) {
  const mesh::Mesh mesh = test::make_mesh("a", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  const auto done = mesh_io::write_meshes({&mesh, 1}, path, {mesh_io::MeshFormat::ply}, Context());
  ASSERT_TRUE(done) << done.error().message;
}

TEST(BatchRun, KeepsFramesWithExistingLabelFiles) {
  const TempFolder folder;
  test::write_bytes(folder / "1_-7.ply", "mine");
  test::write_bytes(folder / "22_7.ply", "mine");
  Listener listener;
  const RunResult result = must_run(label_frames(folder, 2), {.resume_policy = ResumePolicy::keep_existing}, listener);
  EXPECT_EQ(statuses(result), (std::vector{Status::kept, Status::failed}));
}

TEST(BatchRun, RenamesOldLabelFilesOfFailedFrames) {
  const TempFolder folder;
  for (const char* name : {"1_3.ply", "1_4.ply", "2_5.ply", "11_3.ply"}) write_old_mesh(folder / name);
  test::write_bytes(folder / "1_5.ply", "mine");
  const BatchJob batch = label_frames(folder, 2);
  const auto read = check_written_files(batch, {}, {}, Context());
  ASSERT_TRUE(read && *read);
  RunOptions options;
  options.keeps_records = false;
  options.scheduler.extras.read = &**read;
  Listener listener;
  const RunResult result = must_run(batch, options, listener);
  EXPECT_EQ(statuses(result), (std::vector{Status::failed, Status::failed}));
  EXPECT_EQ(folder.names(),
            (std::set<std::string>{"1_3.ply.old", "1_4.ply.old", "2_5.ply.old", "11_3.ply", "1_5.ply"}));
  EXPECT_EQ(result.set_aside.size(), 3U);
  const std::string& error = result.rows[0].error;
  EXPECT_NE(error.find("; the 2 old files are now " + (folder / "1_3.ply.old").string() + " and "), std::string::npos)
      << error;
}

// Only the conversion knows whether a label gets the name of an input.
TEST(BatchRun, ListsInputsThatLabelsMayOverwrite) {
  const TempFolder folder;
  BatchJob batch = label_frames(folder, 2);
  test::write_bytes(folder / "2_1.ply", "a volume");
  batch.frames[0].job.source.input = (folder / "2_1.ply").string();
  const auto read = check_written_files(batch, {}, {}, Context());
  ASSERT_TRUE(read && *read);
  EXPECT_FALSE((*read)->check(folder / "2_1.ply"));
}

TEST(BatchRun, NeverOverwritesInputs) {
  const TempFolder folder;
  BatchJob batch = sphere_frames(folder);
  test::write_bytes(folder / "2.ply", "a mesh");
  batch.frames[0].job.source.input = (folder / "2.ply").string();
  const auto read = check_written_files(batch, {}, {}, Context());
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::usage);
}

TEST(BatchRun, KeepsFiguresOnRequest) {
  const TempFolder folder;
  const BatchJob batch = sphere_frames(folder, 1);
  Listener listener;
  EXPECT_FALSE(must_run(batch, {}, listener).rows[0].outputs.empty());
  Listener again;
  const RunResult bare = must_run(batch, {.keeps_figures = false}, again);
  EXPECT_TRUE(bare.rows[0].outputs.empty());
  EXPECT_TRUE(bare.rows[0].figures.surfaces.empty());
  EXPECT_EQ(bare.rows[0].input, "demo:sphere?size=9");
}

TEST(BatchRun, RefusesLockedManifest) {
  const TempFolder folder;
  const BatchJob batch = sphere_frames(folder, 1);
  const Context context;
  const auto first = BatchRun::open(batch, {}, context);
  ASSERT_TRUE(first);
  const auto second = BatchRun::open(batch, {}, context);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::output);
}

}  // namespace
}  // namespace isoextract::batch
