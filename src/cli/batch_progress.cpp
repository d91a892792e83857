#include "cli/batch_progress.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/printable.hpp"
#include "batch/frame_range.hpp"
#include "cli/rank_run.hpp"
#include "cli/remedies.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"

namespace isoextract::cli {
namespace {

std::string duration_text(double seconds) {
  const auto whole = static_cast<std::uint64_t>(std::llround(seconds));
  return whole >= 3600 ? fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
                       : fmt::format("{}:{:02}", whole / 60, whole % 60);
}

std::vector<double> seconds_of(std::span<const batch::RankWork> ranks) {
  std::vector<double> seconds;
  for (const batch::RankWork& work : ranks) seconds.push_back(work.seconds);
  return seconds;
}

}  // namespace

std::string speed_text(std::uint64_t done, std::uint64_t total, double seconds) {
  if (done == 0 || seconds <= 0) return {};
  const double rate = static_cast<double>(done) / seconds;
  std::string text = rate >= 1 ? fmt::format("{:.1f} frames/s", rate) : fmt::format("{:.1f} s per frame", 1 / rate);
  if (done < total) text += fmt::format(", {} left", duration_text(static_cast<double>(total - done) / rate));
  return text;
}

BatchProgress::BatchProgress(ProgressStyle style, const Messages& messages, std::uint64_t frames)
    : style_(style), messages_(messages), frames_(frames) {
  progress_.begin("frames", frames);
  if (style == ProgressStyle::json)
    line({{"schema", word_of(convert::JsonDocument::progress)}, {"event", "begin"}, {"frames", frames}});
  const bool wanted = style == ProgressStyle::bar && messages.verbosity() != Verbosity::quiet;
  bar_.emplace(
      progress_, wanted,
      [this] {
        return fmt::format("{}/{}  {}", progress_.done(), counted(frames_, "frame"),
                           speed_text(progress_.done(), frames_, seconds()));
      },
      true);
}

void BatchProgress::line(const convert::Json& event) {
  const std::string text = convert::json_line(event) + "\n";
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void BatchProgress::failed(const batch::FrameRow& row, const Error& error, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  if (style_ == ProgressStyle::json) return;  // the frame's line has the reason
  std::vector<std::int64_t>& frames = reasons_[reason];
  frames.push_back(row.frame);
  if (frames.size() > 1) return;
  Error named = error;
  named.message =
      fmt::format("frame {}{}: {}", row.frame, row.rank ? fmt::format(" on rank {}", *row.rank) : "", error.message);
  bar_->above([&] { messages_.error(named); });
}

void BatchProgress::print_repeated_reasons() {
  for (auto& [reason, frames] : reasons_) {
    if (frames.size() == 1) continue;
    const std::int64_t first = frames.front();
    std::ranges::sort(frames);
    messages_.error({ErrorCode::frames,
                     fmt::format("{} frames: {}; first: frame {}; all: {}", frames.size(), reason, first,
                                 batch::text_of(batch::runs_of(frames), batch::kShownFrameRuns)),
                     {}});
  }
}

void BatchProgress::detail(const std::string& text) {
  const std::lock_guard lock(mutex_);
  bar_->above([&] { messages_.detail(text); });
}

void BatchProgress::print_note_once(const Note& note) {
  const std::lock_guard lock(mutex_);
  if (!noted_.insert(note.id).second || style_ == ProgressStyle::json) return;
  bar_->above([&] { messages_.note(note); });
}

void BatchProgress::add_remark(std::int64_t frame, const Note& remark) {
  const std::lock_guard lock(mutex_);
  remarks_[remark].insert(frame);
}

void BatchProgress::tell_remarks() {
  for (const auto& [remark, frames] : remarks_) {
    const std::vector<std::int64_t> numbers(frames.begin(), frames.end());
    messages_.note({remark.id, fmt::format("{} of {} {}: {}", numbers.size(), counted(frames_, "frame"), remark.text,
                                           batch::text_of(batch::runs_of(numbers), batch::kShownFrameRuns))});
  }
}

void BatchProgress::over(const batch::FrameRow& row) {
  const std::lock_guard lock(mutex_);
  progress_.advance(1);
  ++over_;
  if (style_ != ProgressStyle::json) return;
  convert::Json event{{"event", "frame"}, {"done", over_}, {"frames", frames_}, {"seconds_so_far", seconds()}};
  event.update(batch::row_json(row));
  line(event);
}

void BatchProgress::tell_ranks(std::span<const batch::RankWork> ranks) const {
  for (const batch::RankWork& work : ranks) {
    messages_.detail(fmt::format("rank {}: {}, {:.2f} s", work.rank, counted(work.frames, "frame"), work.seconds));
  }
  if (!ranks.empty()) messages_.detail(imbalance_text(seconds_of(ranks)));
}

void BatchProgress::end(const FrameCounts& counts, std::span<const batch::RankWork> ranks) {
  const std::lock_guard lock(mutex_);
  bar_.reset();
  if (style_ == ProgressStyle::json) {
    convert::Json event{{"event", "end"},
                        {"frames", frames_},
                        {"done", counts.done},
                        {"failed", counts.failed},
                        {"cancelled", counts.cancelled},
                        {"kept", counts.kept},
                        {"not_started", counts.not_started},
                        {"missing", counts.missing},
                        {"seconds", seconds()}};
    for (const batch::RankWork& work : ranks) {
      event["ranks"].push_back({{"rank", work.rank}, {"frames", work.frames}, {"seconds", work.seconds}});
    }
    if (!ranks.empty()) event["imbalance"] = imbalance_of(seconds_of(ranks));
    line(event);
    return;
  }
  print_repeated_reasons();
  tell_remarks();
  std::string text = fmt::format("{} of {} done", counts.done, counted(frames_, "frame"));
  if (counts.kept > 0) text += fmt::format(", {} kept from an earlier run", counts.kept);
  if (counts.failed > 0) text += fmt::format(", {} failed", counts.failed);
  if (counts.cancelled > 0) text += fmt::format(", {} cancelled", counts.cancelled);
  if (counts.not_started > 0) text += fmt::format(", {} not started", counts.not_started);
  if (counts.missing > 0) text += fmt::format(", {} missing", counts.missing);
  const std::uint64_t tried = counts.done + counts.failed;
  const std::string speed = speed_text(tried, tried, seconds());
  messages_.summary(fmt::format("{}; {:.2f} s{}{}", text, seconds(), speed.empty() ? "" : ", ", speed));
  tell_ranks(ranks);
}

}  // namespace isoextract::cli
