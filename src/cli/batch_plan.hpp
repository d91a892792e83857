// Makes a batch from flags: finds the frames, names the outputs, and checks everything before any work. Reads folders,
// but opens only a file whose volumes are the frames, and a table of iso values.
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
#include "batch/output_template.hpp"
#include "batch/shard.hpp"
#include "cli/options.hpp"
#include "cli/plan.hpp"

namespace isoextract::cli {

struct BatchPlan {
  ConvertPlan common;  // shared by all frames; its job has no input, iso values and outputs
  Notes frame_notes;   // the notes of common that a conversion of one frame would print
  batch::BatchJob batch;
  std::vector<std::size_t> frames;    // indices of this run's frames: those of its shard
  std::vector<batch::FrameRun> gaps;  // missing frames
  bool needs_all = false;             // missing frames are an error
  batch::Shard shard;
  batch::ResumePolicy earlier = batch::ResumePolicy::reconvert;
  BatchFlags flags;  // as given; the members below take precedence
  int jobs = 1;
  bool make_folders = false;
  PictureFormat picture = PictureFormat::svg;
  ProgressStyle progress = ProgressStyle::bar;
  std::optional<batch::OutputTemplate> report;  // one report per frame
  batch::OtherFiles others;                     // files read and written besides the frames' inputs and outputs
};

// Returns whether the inputs and options ask for a batch of frames instead of one conversion.
[[nodiscard]] bool is_batch(const ConvertFlags& flags);
// Returns whether this input names the frames of a sequence: a folder or a pattern.
[[nodiscard]] bool is_frame_pattern(const std::string& input);

// `environment` is std::getenv, or a replacement in tests: job schedulers set variables with the shard of this
// process.
[[nodiscard]] Result<BatchPlan> plan_batch(const ConvertFlags& flags, const char* (*environment)(const char*));

}  // namespace isoextract::cli
