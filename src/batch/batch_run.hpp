// Runs a batch: skips frames that an earlier run finished, records each finished frame in the manifest, renames old
// meshes of frames that fail, and last writes the animation file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "base/ranks.hpp"
#include "batch/batch_job.hpp"
#include "batch/frame_table.hpp"
#include "batch/output_names.hpp"
#include "batch/scheduler.hpp"
#include "batch/shard.hpp"
#include "convert/events.hpp"
#include "field/scalar_field.hpp"
#include "files/input_file_set.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::batch {

// Frames of an earlier run that this run keeps instead of converting them again.
enum class ResumePolicy {
  reconvert,
  // Frames that the manifest lists with the same job and unchanged files (reason_to_reconvert()). An animation keeps
  // all frames or none. Keeps no frame without RunOptions::keeps_records.
  keep_unchanged,
  keep_existing,  // frames of which an output file exists (ExistingFiles::find()), whatever it contains
};

struct RunOptions {
  Shard shard = {};  // only this shard's frames are converted
  ResumePolicy resume_policy = ResumePolicy::reconvert;
  std::vector<std::string> arguments = {};  // the command line, which the manifest stores for people to read
  std::string absent = {};                  // requested frames without input, as FrameRange text (ManifestHeader)
  bool keeps_records = true;                // keep records in the manifest, for later runs
  // Keep figures, outputs and errors of converted frames in RunResult::rows, which takes memory for each frame.
  bool keeps_figures = true;
  // The ranks that share the frames; null: this process converts all frames. Each rank must run the same batch with the
  // same options. Not for a batch with an animation.
  Ranks* ranks = nullptr;
  // BatchRun sets extras.field_notes and extras.hash_files, and renames old meshes only if extras.read is set.
  SchedulerOptions scheduler = {};
};

// Events of a run. The converting threads call them concurrently, so a listener must guard its data. The thread of
// BatchRun::run() calls has_report() and over() for kept frames, before any frame starts.
//
// Each of several ranks calls started(), field_notes() and write_report() for the frames that it converts. Rank 0 calls
// has_report() and over() for all frames, and notes_of_rank() for frames of other ranks.
class RunEvents {
 public:
  virtual ~RunEvents() = default;

  // Called before a frame is converted; see FrameEvents::started().
  [[nodiscard]] virtual convert::Events* started(std::size_t /*frame*/, const Context& /*context*/) { return nullptr; }
  // Returns notes about the field of a frame (convert::ConversionOptions).
  [[nodiscard]] virtual Notes field_notes(const field::ScalarField& /*field*/) { return {}; }
  // Called with notes that field_notes() returned on another rank.
  virtual void notes_of_rank(const Notes& /*notes*/) {}
  // Returns whether the report of a frame, as write_report() writes it, exists. ResumePolicy::keep_unchanged does not
  // keep a frame without a report.
  [[nodiscard]] virtual bool has_report(std::size_t /*frame*/) { return true; }
  // Writes the report of a frame. If that fails, the frame fails.
  [[nodiscard]] virtual Result<void> write_report(std::size_t /*frame*/, const convert::Outcome& /*outcome*/) {
    return {};
  }
  // Called once for each kept frame and each frame that FrameEvents::finished() receives, after its other events.
  // `outcome` is null for a kept frame; for a frame of another rank it has only `notes`, `empty_picture` and `error`.
  // The receiver may move parts out of it. `error` is set if the frame failed or was cancelled.
  virtual void over(std::size_t /*frame*/, const FrameRow& /*row*/, convert::Outcome* /*outcome*/,
                    const Error* /*error*/) {}
};

// The share of a rank.
struct RankWork {
  int rank = 0;
  std::size_t frames = 0;  // number of frames that the rank converted, including failed and cancelled frames
  double seconds = 0;      // time until the rank had no more frames
};

struct RunResult {
  std::vector<FrameRow> rows;               // of the run's frames, in order
  std::vector<std::string> set_aside = {};  // the new names of old meshes of frames that failed
  mesh_io::MeshWriteResult animation = {};  // the animation's files, and notes about it
  // Set if the manifest or the animation could not be written, or if the connection between the ranks failed, which
  // ended the run.
  std::optional<Error> error = {};
  std::vector<RankWork> ranks = {};  // by rank; empty if one process converted all frames

  [[nodiscard]] std::size_t count(FrameStatus status) const;
};

// Returns the deepest folder that contains all outputs of the batch, with the manifest; empty for the current folder.
[[nodiscard]] std::filesystem::path manifest_folder(const BatchJob& batch);

// Fails with ErrorCode::usage if an existing output or an existing file of `others.written` is also read. Fails as
// check_replaced_shard() does.
//
// Returns the set of the files that the run reads, including data files that input headers name. Conversions check the
// files of bodies and labels against this set. Returns nullopt if no file to write exists yet, no existing file has a
// name that a label may get, and no surface is split into bodies.
[[nodiscard]] Result<std::optional<files::InputFileSet>> check_written_files(const BatchJob& batch, const Shard& shard,
                                                                             const OtherFiles& others,
                                                                             const Context& context);

class BatchRun {
 public:
  // Opens and locks the manifest, if records are kept; the manifest's folder must exist. Converts nothing. `batch` and
  // `context` must outlive the run. Fails with ErrorCode::usage or ErrorCode::output.
  [[nodiscard]] static Result<BatchRun> open(const BatchJob& batch, RunOptions options, const Context& context);

  BatchRun(BatchRun&&) noexcept;
  BatchRun& operator=(BatchRun&&) noexcept;
  ~BatchRun();

  // Runs the batch. Call once. Frames that fail are rows of the result, not an error. Of several ranks, only rank 0
  // returns the result; the others set only RunResult::error.
  [[nodiscard]] RunResult run(RunEvents& events);

 private:
  struct State;
  explicit BatchRun(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::batch
