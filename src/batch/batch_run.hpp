// A batch from the first frame to the last record: frames that an earlier run has done are kept, each frame that is
// done gets a record in the manifest, old meshes of frames that fail get other names, and an animation gets its name.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "batch/batch_job.hpp"
#include "batch/frame_table.hpp"
#include "batch/output_names.hpp"
#include "batch/scheduler.hpp"
#include "batch/shard.hpp"
#include "convert/events.hpp"
#include "field/scalar_field.hpp"
#include "files/read_files.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::batch {

// Which frames of an earlier run a run keeps instead of converting them again.
enum class EarlierFrames {
  converted_again,
  kept_if_unchanged,  // where the manifest has the job, and all inputs and outputs are what they were, byte by byte
  kept_if_there,      // where an output has its name, whatever is in it
};

struct RunOptions {
  Shard shard = {};  // whose frames are converted
  EarlierFrames earlier = EarlierFrames::converted_again;
  std::vector<std::string> arguments = {};  // of the command, which the manifest tells its readers
  std::string absent = {};                  // numbers of frames that were asked for and have no input (ManifestHeader)
  bool keeps_records = true;                // in the manifest, for later runs
  bool keeps_figures = true;                // in RunResult::rows, which takes memory for each frame
  SchedulerOptions scheduler = {};          // its note_of_field is RunEvents'
};

// Told by the threads that convert, side by side: who listens guards what it has.
class RunEvents {
 public:
  virtual ~RunEvents() = default;

  // Before a frame is converted: FrameEvents::started().
  [[nodiscard]] virtual convert::Events* started(std::size_t /*frame*/, const Context& /*context*/) { return nullptr; }
  // Returns a note about the field of a frame (convert::OutcomeExtras).
  [[nodiscard]] virtual std::optional<std::string> note_of_field(const field::ScalarField& /*field*/) {
    return std::nullopt;
  }
  // Whether what write_report() makes of a frame is there; a frame without it is not kept.
  [[nodiscard]] virtual bool has_report(std::size_t /*frame*/) { return true; }
  // Writes the report of a frame. A frame whose report cannot be written has failed.
  [[nodiscard]] virtual Result<void> write_report(std::size_t /*frame*/, const convert::Outcome& /*outcome*/) {
    return {};
  }
  // Each frame once, when nothing more happens to it. `outcome` is null for one that is kept, `error` for one that has
  // not failed.
  virtual void over(std::size_t /*frame*/, const FrameRow& /*row*/, const convert::Outcome* /*outcome*/,
                    const Error* /*error*/) {}
};

struct RunResult {
  std::vector<FrameRow> rows;               // of the run's frames, in their order
  std::vector<std::string> set_aside = {};  // the names that old meshes have now, of frames that failed
  mesh_io::MeshWriteResult animation = {};  // its files, and notes about it
  std::optional<Error> error = {};          // the manifest or the animation could not be written, which ended the run

  [[nodiscard]] std::size_t count(FrameStatus status) const;
};

// Returns the deepest folder that all outputs of the batch are in. The manifest lies there.
[[nodiscard]] std::filesystem::path manifest_folder(const BatchJob& batch);

// What all frames read, among it files that only the inputs name, where some file that would be written is there
// already, or names are known late (pieces): nothing else could be replaced. Fails with ErrorCode::usage where a file
// that would be written is read, or is of another run's shard.
[[nodiscard]] Result<std::optional<files::ReadFiles>> check_written_files(const BatchJob& batch, const Shard& shard,
                                                                          const OtherFiles& others,
                                                                          const Context& context);

class BatchRun {
 public:
  // Locks the manifest, if records are kept, whose folder has to be there; converts nothing yet. `batch` and `context`
  // outlive the run. Fails with ErrorCode::usage and ErrorCode::output.
  [[nodiscard]] static Result<BatchRun> open(const BatchJob& batch, RunOptions options, const Context& context);

  BatchRun(BatchRun&&) noexcept;
  BatchRun& operator=(BatchRun&&) noexcept;
  ~BatchRun();

  // Call once. Frames that fail are rows of the result.
  [[nodiscard]] RunResult run(RunEvents& events);

 private:
  struct State;
  explicit BatchRun(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::batch
