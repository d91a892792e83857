// The options of batches. Each option of BatchFlags turns a conversion into a batch, except with --masks.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "base/enum_words.hpp"
#include "batch/frame_range.hpp"
#include "batch/shard.hpp"
#include "cli/option.hpp"
#include "cli/values.hpp"

namespace isoextract::cli {

// The form of a batch's progress on stderr.
enum class ProgressStyle {
  bar,   // on a terminal; elsewhere a line every 30 seconds
  json,  // one line of JSON per event
  none,
};
constexpr auto words_of(ProgressStyle /*type*/) {
  return std::array{Word{ProgressStyle::bar, "bar"}, Word{ProgressStyle::json, "json"},
                    Word{ProgressStyle::none, "none"}};
}

enum class MissingPolicy {
  error,  // converts the frames that have an input, then fails
  note,   // prints a note and does not fail
};
constexpr auto words_of(MissingPolicy /*type*/) {
  return std::array{Word{MissingPolicy::error, "error"}, Word{MissingPolicy::note, "note"}};
}

// `help` is the whole help text: what the command does with the frames.
struct FramesOption : Value<batch::FrameRange> {
  FramesOption(const Place& place, std::string help)
      : Value(
            place, "--frames", "A-BxS,...", [](std::string_view range) { return batch::FrameRange::parse(range); },
            std::move(help)) {}
};

struct BatchFlags : OptionSet {
  explicit BatchFlags(OptionSet* command = nullptr);

  FramesOption frames{everyday(*this),
                      "Frames to convert, such as 1-240, 1-240x2 or 1-10,20. x2 takes every second frame. Default: all "
                      "that match INPUT."};
  Value<MissingPolicy> missing{
      *this, "--missing",
      "What to do where frames are missing. error converts the other frames and exits with code 5; note only prints a "
      "note. Default: error for frames that --frames names, note for gaps in the numbering."};
  Value<std::string> iso_table{*this,
                               "--iso-table",
                               "FILE",
                               parse_text,
                               "CSV file with an iso value for each frame. Its columns are frame and iso. Replaces "
                               "--iso; the column iso takes the same values as --iso, such as 0.5, p99 or auto.",
                               About::surface};
  Flag animate{
      *this, "--animate",
      "Write all frames into one .glb file that plays them. It is named after -o. The first frame starts at 0 "
      "seconds, and gaps in the numbering keep their time. With --volume all, frames that state their times start at "
      "these times, in proportion. A frame that fails is left out, and the frame "
      "before it is shown longer. An animation over 4 GiB continues in NAME.part2.glb.",
      About::surface | About::mesh_file};
  Value<double> fps{
      *this, "--fps", "N", parse_positive,
      "Frames per second of --animate (default: 24). If frames state their times, N is the mean rate. Blender 3.4 "
      "rounds it to a whole number."};
  Value<int> jobs{*this, "--jobs", "N", parse_thread_count,
                  "Number of frames to convert at the same time. They share --threads and --memory-limit; a GPU "
                  "extracts one frame after another. Default: one for each thread. The output does not depend on it."};
  Flag resume{*this, "--resume",
              "Convert only frames that are not done. A frame is done if its manifest record matches its options, its "
              "input and its output files. The manifest is in the output folder."};
  Flag fail_fast{*this, "--fail-fast",
                 "Stop at the first frame that fails. Default: convert the others, then exit with code 5."};
  Flag no_clobber{*this, "--no-clobber", "Skip frames whose output exists already."};
  Flag make_folders{*this, "--mkdir", "Create missing output folders. A slash at the end of -o does so, too."};
  Flag dry_run{*this, "--dry-run", "Print frames, files and memory; convert nothing. The memory is an estimate."};
  Value<std::string> table{
      *this, "--table", "FILE", parse_text,
      "Write a table of all frames, as .csv or .json. It has triangles, area, volume, time and memory of each frame."};
  Value<std::string> plot{
      *this,         "--plot", "FILE", parse_text, "Plot the table over the frames, as .svg or .png. gnuplot draws it.",
      About::surface};
  Value<ProgressStyle> progress{*this, "--progress",
                                "How to show progress on stderr (default: bar). bar: a bar on a terminal, elsewhere a "
                                "line every 30 seconds; json: a line of JSON for each event; none: nothing."};
  Value<batch::ShardChoice> shard{*this, "--shard", "K/N|auto",
                                  [](std::string_view text) { return batch::parse_shard(std::string(text)); },
                                  "Convert part K of N of the frames, for N machines. Part K has every N-th frame from "
                                  "the K-th on; 'isoextract merge' joins the parts. auto takes K and N from the "
                                  "variables of a Slurm array or an indexed Kubernetes job. Default: all frames."};
};

}  // namespace isoextract::cli
