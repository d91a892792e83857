// How far a batch is: a bar for people, lines of JSON for programs. Both on stderr.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "base/progress.hpp"
#include "base/stopwatch.hpp"
#include "batch/frame_table.hpp"
#include "cli/messages.hpp"
#include "cli/options.hpp"
#include "cli/progress_bar.hpp"

namespace isoextract::cli {

// "12.3 frames/s, 0:09 left", "4.2 s a frame, 1:02:11 left"
[[nodiscard]] std::string speed_text(std::uint64_t done, std::uint64_t total, double seconds);

// Used by several threads at once.
class BatchProgress {
 public:
  BatchProgress(ProgressStyle style, const Messages& messages, std::uint64_t frames);

  void failed(std::int64_t frame, const Error& error);
  void detail(const std::string& text);
  // Tells the first note that it is called with; other frames have the same.
  void note_once(const std::string& text);
  // A frame that is over, however it ended.
  void over(const batch::FrameRow& row);
  // What there was in all. Call once, last.
  void end(std::uint64_t done, std::uint64_t failed, std::uint64_t kept, std::uint64_t not_started);

  [[nodiscard]] double seconds() const { return watch_.elapsed().wall_seconds; }

 private:
  void line(const convert::Json& event);

  ProgressStyle style_;
  const Messages& messages_;
  std::uint64_t frames_;
  std::uint64_t over_ = 0;
  bool noted_ = false;
  Stopwatch watch_;
  Progress progress_;
  std::mutex mutex_;
  std::optional<ProgressBar> bar_;  // after what it reads
};

}  // namespace isoextract::cli
