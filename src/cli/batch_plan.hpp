// Makes a batch from flags: finds the frames, names the outputs, and checks the options before any work.
//
// Reads folders, and opens only these files:
// - those that batch::find_frames() opens,
// - the file whose volumes are the frames,
// - the tables of --iso-table and --label-names, and a table of label names beside the first input,
// - the first input, where its content decides about particles, labels or the iso value,
// - if -o or --report contains {step}: each input whose time step is not known yet.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "batch/batch_job.hpp"
#include "batch/batch_run.hpp"
#include "batch/frame_range.hpp"
#include "batch/output_names.hpp"
#include "batch/shard.hpp"
#include "cli/options.hpp"
#include "cli/plan.hpp"

namespace isoextract::cli {

struct BatchPlan {
  ConvertPlan common;  // shared by all frames; each frame has its own input, outputs and iso values
  Notes frame_notes;   // the notes of `common` that the report of each frame repeats
  batch::BatchJob batch;
  std::vector<std::size_t> frames;    // indices into batch.frames: those of this run's shard
  std::vector<batch::FrameRun> gaps;  // missing frames of the whole batch
  bool missing_is_error = false;      // a missing frame makes the run fail (exit code 5)
  batch::Shard shard;
  batch::ResumePolicy resume_policy = batch::ResumePolicy::reconvert;
  // The options as given, but with the number of the shard in the names of --table and --plot. For a setting that
  // another member holds as well, such as `jobs`, use that member: it includes defaults.
  BatchFlags flags;
  int threads = 1;  // of the whole run
  int jobs = 1;
  bool make_folders = false;
  PictureFormat plot_format = PictureFormat::svg;
  ProgressStyle progress = ProgressStyle::bar;
  std::vector<std::string> reports;  // report paths, one for each of batch.frames; empty: no reports
  batch::OtherFiles others;          // files read and written besides the frames' inputs and outputs

  // Returns whether the run measures each mesh, for its table, plot, reports or page.
  [[nodiscard]] bool measures_meshes() const {
    return flags.table || flags.plot || !reports.empty() || common.pages.html;
  }
};

// Returns whether the inputs and options ask for a batch of frames instead of one conversion.
[[nodiscard]] bool is_batch(const ConvertFlags& flags);
// Returns whether this input is a pattern of file names, or a folder that is no volume itself. Returns false for an
// existing file, whatever its name, for pictures that are the slices of one volume, and for a volume inside a file
// (FILE.h5:/path). Returns true for an invalid pattern: the search for frames reports it.
[[nodiscard]] bool is_frame_pattern(const std::string& input);

// Replaces several files that are one volume, such as slices/*.png listed by a shell, by the header, the pattern or the
// folder that names the volume (batch::without_sample_files() and batch::find_one_volume()).
void name_volume_of_files(std::vector<std::string>& inputs);

// Plans the batch. `environment` is std::getenv, or a replacement in tests. plan_batch() asks it for the variables of
// job schedulers: for --shard auto, or without --shard for a note. Fails with ErrorCode::usage if options are invalid
// or do not work together, and as batch::find_frames(), batch::IsoTable::read(), volume_io::LabelTable::read(),
// convert::list_frames() and convert::find_frame_time() do.
[[nodiscard]] Result<BatchPlan> plan_batch(const ConvertFlags& flags, const char* (*environment)(const char*));

}  // namespace isoextract::cli
