// Shows the progress of a batch on stderr, as ProgressStyle says: a bar on a terminal or a line every 30 seconds
// elsewhere (neither when quiet), lines of JSON for programs, or nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/note.hpp"
#include "base/progress.hpp"
#include "base/stopwatch.hpp"
#include "batch/batch_run.hpp"
#include "batch/frame_table.hpp"
#include "cli/messages.hpp"
#include "cli/options.hpp"
#include "cli/progress_bar.hpp"

namespace isoextract::cli {

// Returns "12.3 frames/s, 0:09 left" or "4.2 s per frame, 1:02:11 left"; empty if no frame is done.
[[nodiscard]] std::string speed_text(std::uint64_t done, std::uint64_t total, double seconds);

// The number of frames by outcome. Requested frames without an input count as `missing` if that is an error, otherwise
// not at all.
struct FrameCounts {
  std::uint64_t done = 0;  // includes frames without triangles
  std::uint64_t failed = 0;
  std::uint64_t cancelled = 0;
  std::uint64_t kept = 0;
  std::uint64_t not_started = 0;
  std::uint64_t missing = 0;
};

// Thread-safe. With ProgressStyle::json only the lines of JSON and detail() print anything.
class BatchProgress {
 public:
  BatchProgress(ProgressStyle style, const Messages& messages, std::uint64_t frames);

  // Prints `error` if `row` is the first frame with this `reason` (the message without the frame's file names). end()
  // prints one line for each reason that several frames have.
  void failed(const batch::FrameRow& row, const Error& error, const std::string& reason);
  // Prints a text with --verbose (Messages::detail()).
  void detail(const std::string& text);
  // Prints only the first note of each id, since other frames have similar notes.
  void print_note_once(const Note& note);
  // Records a remark about a frame. end() prints each remark once for all its frames: "2 of 3 frames TEXT: 1-2".
  void add_remark(std::int64_t frame, const Note& remark);
  // Records a frame that is over, whatever its outcome. With ProgressStyle::json, prints its line of JSON.
  void over(const batch::FrameRow& row);
  // Removes the bar, and prints the collected reasons and remarks, a summary, and with --verbose the frames and time of
  // each rank. With ProgressStyle::json, prints one line of JSON instead. Call once, last.
  void end(const FrameCounts& counts, std::span<const batch::RankWork> ranks = {});

  [[nodiscard]] double seconds() const { return watch_.elapsed().wall_seconds; }

 private:
  void line(const convert::Json& event);
  void print_repeated_reasons();
  void tell_remarks();
  void tell_ranks(std::span<const batch::RankWork> ranks) const;

  ProgressStyle style_;
  const Messages& messages_;
  std::uint64_t frames_;
  std::uint64_t over_ = 0;
  std::set<NoteId> noted_;
  Stopwatch watch_;
  Progress progress_;
  std::mutex mutex_;
  std::map<std::string, std::vector<std::int64_t>> reasons_;  // frames by reason, each list in the order of failure
  std::map<Note, std::set<std::int64_t>> remarks_;            // frames by remark
  std::optional<ProgressBar> bar_;                            // declared after the members that it reads
};

}  // namespace isoextract::cli
