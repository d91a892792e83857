// The options of many frames. One of them makes a batch of a conversion.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "base/words.hpp"
#include "batch/frame_range.hpp"
#include "batch/shard.hpp"
#include "cli/option.hpp"
#include "cli/values.hpp"

namespace isoextract::cli {

// How a batch tells how far it is, on stderr.
enum class ProgressStyle {
  bar,   // where that is a terminal
  json,  // a line of JSON an event
  none,
};
constexpr auto words_of(ProgressStyle /*type*/) {
  return std::array{Word{ProgressStyle::bar, "bar"}, Word{ProgressStyle::json, "json"},
                    Word{ProgressStyle::none, "none"}};
}

enum class MissingPolicy {
  error,  // the frames that are there are converted, and the run fails
  note,
};
constexpr auto words_of(MissingPolicy /*type*/) {
  return std::array{Word{MissingPolicy::error, "error"}, Word{MissingPolicy::note, "note"}};
}

// `help` says what the frames are taken for.
struct FramesOption : Value<batch::FrameRange> {
  FramesOption(const Place& place, std::string help)
      : Value(
            place, "--frames", "A-BxS,...", [](std::string_view range) { return batch::FrameRange::parse(range); },
            std::move(help)) {}
};

struct BatchFlags : OptionSet {
  explicit BatchFlags(OptionSet* command = nullptr);

  FramesOption frames{*this, "Frames to convert, such as 1-240, 1-240x2 or 1-10,20 (default: all that match INPUT)."};
  Value<MissingPolicy> missing{
      *this, "--missing",
      "What to do where frames are not there: convert the others and exit with 5, or tell of it only "
      "(default: error for those that --frames names, note for gaps in the numbering)."};
  Value<std::string> iso_table{
      *this,
      "--iso-table",
      "FILE",
      parse_text,
      "Iso values by frame, in place of --iso and in its words: a CSV file with the columns frame and iso.",
      About::surface};
  Flag animate{
      *this, "--animate",
      "Write all frames into one .glb that plays them, named after -o. The first frame is at 0 seconds, gaps in "
      "the numbering keep their time, and a frame that fails is left out: the one before it is shown longer. "
      "What does not fit into one file of 4 GiB goes on in NAME.part2.glb.",
      About::surface | About::mesh_file};
  Value<double> fps{*this, "--fps", "N", parse_positive,
                    "Frames per second of --animate (default: 24). Blender 3.4 rounds it to a whole number when it "
                    "opens the file."};
  Value<int> jobs{*this, "--jobs", "N", parse_thread_count,
                  "Frames to convert at a time, as far as --memory-limit lets them; they share --threads, and a GPU "
                  "draws one after another (default: as many as threads). The output does not depend on it."};
  Flag resume{*this, "--resume",
              "Do only what is not done: frames whose record, input and output are what the manifest in the folder of "
              "the outputs says are left alone."};
  Flag fail_fast{*this, "--fail-fast", "End with the first frame that fails (default: go on, and exit with 5)."};
  Flag no_clobber{*this, "--no-clobber", "Leave out frames of which a file is there, whoever wrote it."};
  Flag make_folders{*this, "--mkdir", "Make the folders of the outputs; so does a slash at the end of -o."};
  Flag dry_run{*this, "--dry-run", "Show the frames, their files and an estimate of memory on stdout, and do nothing."};
  Value<std::string> table{*this, "--table", "FILE", parse_text,
                           "Write a table of all frames, .csv or .json: triangles, area, volume, time, memory."};
  Value<std::string> plot{
      *this,         "--plot", "FILE", parse_text, "Draw the table over the frames with gnuplot, as .svg or .png.",
      About::surface};
  Value<ProgressStyle> progress{
      *this, "--progress",
      "How to tell on stderr how far it is: a bar on a terminal, a line of JSON an event, or not at all "
      "(default: bar)."};
  Value<batch::ShardChoice> shard{
      *this, "--shard", "K/N|auto", [](std::string_view text) { return batch::parse_shard(std::string(text)); },
      "Convert every N-th frame from the K-th on, for N machines; 'isoextract merge' joins what they did. auto "
      "takes K and N from the variables of a Slurm array or an indexed Kubernetes job (default: all frames)."};
};

}  // namespace isoextract::cli
