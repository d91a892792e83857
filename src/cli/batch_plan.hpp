// From flags to a batch: frames found, names given, all of it checked before any work. Folders are looked into; no file
// is opened but one whose volumes are the frames, and a table of iso values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
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
  ConvertPlan common;                    // what all frames share; its job is without input, iso values and outputs
  std::vector<std::string> frame_notes;  // those of common that a conversion of one frame has
  batch::BatchJob batch;
  std::vector<std::size_t> frames;    // that are this run's, by index: those of its shard
  std::vector<batch::FrameRun> gaps;  // frames that are not there
  bool needs_all = false;             // gaps are an error
  batch::Shard shard;
  batch::EarlierFrames earlier = batch::EarlierFrames::converted_again;
  BatchFlags flags;  // what was asked for; where they say the same, what follows counts
  int jobs = 1;
  bool make_folders = false;
  PictureFormat picture = PictureFormat::svg;
  ProgressStyle progress = ProgressStyle::bar;
  std::optional<batch::OutputTemplate> report;  // a report a frame
  batch::OtherFiles others;                     // what is read and written besides the frames' inputs and outputs
};

// Whether the inputs and options ask for frames rather than for one conversion.
[[nodiscard]] bool is_batch(const ConvertFlags& flags);
// Whether this one stands for the frames of a sequence: a folder or a pattern.
[[nodiscard]] bool names_frames(const std::string& input);

// `environment` is std::getenv: job schedulers tell there which part of the frames is this process's.
[[nodiscard]] Result<BatchPlan> plan_batch(const ConvertFlags& flags, const char* (*environment)(const char*));

}  // namespace isoextract::cli
