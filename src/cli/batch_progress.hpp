// How far a batch is: a bar on a terminal, a line every half a minute elsewhere, lines of JSON for programs. On stderr.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "base/stopwatch.hpp"
#include "batch/frame_table.hpp"
#include "cli/messages.hpp"
#include "cli/options.hpp"
#include "cli/progress_bar.hpp"

namespace isoextract::cli {

// "12.3 frames/s, 0:09 left", "4.2 s a frame, 1:02:11 left"
[[nodiscard]] std::string speed_text(std::uint64_t done, std::uint64_t total, double seconds);

// How the frames of a batch ended. Those that were not there count in none of the others.
struct FrameCounts {
  std::uint64_t done = 0;
  std::uint64_t failed = 0;
  std::uint64_t cancelled = 0;
  std::uint64_t kept = 0;
  std::uint64_t not_started = 0;
  std::uint64_t missing = 0;
};

// Used by several threads at once.
class BatchProgress {
 public:
  BatchProgress(ProgressStyle style, const Messages& messages, std::uint64_t frames);

  // The first frames that fail for one reason are told, the others by end(). `reason` is the error's message without
  // what only this frame has, such as the names of its files.
  void failed(std::int64_t frame, const Error& error, const std::string& reason);
  void detail(const std::string& text);
  // Tells the first note that it is called with; other frames have the same.
  void note_once(const std::string& text);
  // Something that is so of some frames: end() notes them all at once, as "2 of 3 frames TEXT: 1-2".
  void remark(std::int64_t frame, const std::string& text);
  // A frame that is over, however it ended.
  void over(const batch::FrameRow& row);
  // Call once, last.
  void end(const FrameCounts& counts);

  [[nodiscard]] double seconds() const { return watch_.elapsed().wall_seconds; }

 private:
  struct Reason {
    std::vector<std::int64_t> told;  // the frames whose error was printed
    std::vector<std::int64_t> untold;
  };

  void line(const convert::Json& event);
  void tell_folded();
  void tell_remarks();

  ProgressStyle style_;
  const Messages& messages_;
  std::uint64_t frames_;
  std::uint64_t over_ = 0;
  bool noted_ = false;
  Stopwatch watch_;
  Progress progress_;
  std::mutex mutex_;
  std::map<std::string, Reason> reasons_;                  // why frames failed
  std::map<std::string, std::set<std::int64_t>> remarks_;  // frames, by what is so of them
  std::optional<ProgressBar> bar_;                         // after what it reads
};

}  // namespace isoextract::cli
