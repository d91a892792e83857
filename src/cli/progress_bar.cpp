#include "cli/progress_bar.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "cli/terminal.hpp"

namespace isoextract::cli {
namespace {

using namespace std::chrono_literals;
constexpr auto kSilentFor = 1s;
constexpr auto kRedrawEvery = 100ms;
constexpr auto kPrintEvery = 30s;
constexpr std::size_t kBarWidth = 30;
constexpr std::string_view kEraseLine = "\r\x1b[K";

std::string bar_text(const Progress& progress, const std::string& text) {
  const std::uint64_t total = progress.total();
  if (total == 0) return fmt::format("{}{} ...", kEraseLine, text);
  // Shows a full bar for one redraw if a stage begins between the two reads.
  const double share = std::min(1.0, static_cast<double>(progress.done()) / static_cast<double>(total));
  const auto filled = static_cast<std::size_t>(share * static_cast<double>(kBarWidth));
  return fmt::format("{}[{}{}] {:3.0f} % {}", kEraseLine, std::string(filled, '#'),
                     std::string(kBarWidth - filled, '.'), 100 * share, text);
}

void write_to_stderr(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

ProgressBar::ProgressBar(const Progress& progress, bool wanted, std::function<std::string()> text, bool lines)
    : progress_(progress), text_(std::move(text)) {
  const bool draws = stderr_is_terminal();
  if (!wanted || (!draws && !lines)) return;
  try {
    thread_ = std::thread([this, draws] { draws ? draw_until_done() : print_until_done(); });
  } catch (const std::system_error&) {  // no thread can be started; the work goes on without a bar
  }
}

ProgressBar::~ProgressBar() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    done_ = true;
  }
  finished_.notify_one();
  thread_.join();
}

void ProgressBar::draw_until_done() {
  std::unique_lock lock(mutex_);
  if (finished_.wait_for(lock, kSilentFor, [this] { return done_; })) return;
  do {
    write_to_stderr(bar_text(progress_, text_ ? text_() : progress_.stage()));
    drawn_ = true;
  } while (!finished_.wait_for(lock, kRedrawEvery, [this] { return done_; }));
  erase();
}

void ProgressBar::print_until_done() {
  std::unique_lock lock(mutex_);
  while (!finished_.wait_for(lock, kPrintEvery, [this] { return done_; })) {
    write_to_stderr((text_ ? text_() : progress_.stage()) + "\n");
  }
}

void ProgressBar::erase() {
  if (drawn_) write_to_stderr(kEraseLine);
  drawn_ = false;
}

}  // namespace isoextract::cli
