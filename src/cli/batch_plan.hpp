// Makes a batch from flags: finds the frames, names the outputs, and checks the options before any work.
//
// Reads folders. Opens only the file whose volumes are the frames, the tables of --iso-table and --label-names, and
// without an iso value the first input, to find out whether it holds particles.
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
  Notes frame_notes;   // the notes of common that a conversion of one frame would print
  batch::BatchJob batch;
  std::vector<std::size_t> frames;    // indices into batch.frames: those of this run's shard
  std::vector<batch::FrameRun> gaps;  // missing frames of the whole batch
  bool needs_all = false;             // missing frames are an error
  batch::Shard shard;
  batch::ResumePolicy earlier = batch::ResumePolicy::reconvert;
  // As given, except that shards add their number to the files of --table and --plot. If another member here has the
  // same setting, that member counts.
  BatchFlags flags;
  int jobs = 1;
  bool make_folders = false;
  PictureFormat picture = PictureFormat::svg;
  ProgressStyle progress = ProgressStyle::bar;
  std::vector<std::string> reports;  // the path of each frame's report; empty: none
  batch::OtherFiles others;          // files read and written besides the frames' inputs and outputs
};

// Returns whether the inputs and options ask for a batch of frames instead of one conversion.
[[nodiscard]] bool is_batch(const ConvertFlags& flags);
// Returns whether this input is a folder or a pattern of file names. An existing file is neither, whatever its name,
// and neither are pictures that are the slices of one volume. Returns true for an invalid pattern as well; the search
// for frames reports it.
[[nodiscard]] bool is_frame_pattern(const std::string& input);

// Plans the batch. `environment` is std::getenv or a replacement in tests; it gives the job scheduler's variables for
// --shard auto, and without --shard for a note. Fails with ErrorCode::usage for options, and as batch::find_frames(),
// batch::IsoTable::read(), volume_io::LabelTable::read() and convert::list_frames() do.
[[nodiscard]] Result<BatchPlan> plan_batch(const ConvertFlags& flags, const char* (*environment)(const char*));

}  // namespace isoextract::cli
