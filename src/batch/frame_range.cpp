#include "batch/frame_range.hpp"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/checked.hpp"
#include "base/printable.hpp"
#include "files/frame_pattern.hpp"

namespace isoextract::batch {
namespace {

constexpr std::size_t kShownText = 60;

// Removes a number from the start of `text` and returns it.
std::optional<std::int64_t> take_number(std::string_view& text) {
  std::int64_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc() || number < -files::kMaxFrameNumber || number > files::kMaxFrameNumber)
    return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
  return number;
}

bool take_character(std::string_view& text, char c) {
  if (!text.starts_with(c)) return false;
  text.remove_prefix(1);
  return true;
}

Result<FrameRun> run_of(std::string_view text) {
  const auto misread = [&] {
    return fail(ErrorCode::usage,
                fmt::format("frames: expected A, A-B or A-BxS, found '{}'", printable(text, kShownText)),
                "for example 1-240, 1-240x2 or 1-10,20,30-40x5");
  };
  std::string_view rest = text;
  const auto first = take_number(rest);
  if (!first) return misread();
  FrameRun run{*first, *first, 1};
  if (rest.empty()) return run;
  if (!take_character(rest, '-')) return misread();
  const auto last = take_number(rest);
  if (!last) return misread();
  if (*last < *first) {
    return fail(ErrorCode::usage,
                fmt::format("frames {}: expected the smaller number first, found {} before {}",
                            printable(text, kShownText), *first, *last),
                "frames come in rising order");
  }
  if (take_character(rest, 'x')) {
    const auto step = take_number(rest);
    if (!step) return misread();
    if (*step < 1) {
      return fail(ErrorCode::usage, fmt::format("frames {}: expected a step of at least 1, found {}",
                                                printable(text, kShownText), *step));
    }
    run.step = *step;
  }
  if (!rest.empty()) return misread();
  run.last = *last - (*last - *first) % run.step;
  if (run.first == run.last) run.step = 1;
  return run;
}

std::vector<std::int64_t> numbers_of(std::span<const FrameRun> runs) {
  std::vector<std::int64_t> numbers;
  for (const FrameRun& run : runs) {
    for (std::uint64_t i = 0; i < run.count(); ++i) {
      numbers.push_back(run.first + static_cast<std::int64_t>(i) * run.step);
    }
  }
  return numbers;
}

}  // namespace

std::vector<FrameRun> runs_of(std::span<const std::int64_t> numbers) {
  std::vector<FrameRun> runs;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t end = i + 1;  // end of the run that begins at i
    const std::int64_t step = end < numbers.size() ? numbers[end] - numbers[i] : 1;
    while (end < numbers.size() && numbers[end] - numbers[end - 1] == step) ++end;
    // Two numbers with a gap between them do not make a run yet: the second may start a better one.
    if (end - i == 2 && step > 1) --end;
    runs.push_back({numbers[i], numbers[end - 1], end - i > 1 ? step : 1});
    i = end;
  }
  return runs;
}

std::string text_of(std::span<const FrameRun> runs, std::size_t max_runs) {
  std::string text;
  for (const FrameRun& run : runs.first(std::min(runs.size(), max_runs))) {
    if (!text.empty()) text += ',';
    text += fmt::format("{}", run.first);
    if (run.last != run.first) text += fmt::format("-{}", run.last);
    if (run.step != 1) text += fmt::format("x{}", run.step);
  }
  return runs.size() > max_runs ? text + ",..." : text;
}

Result<FrameRange> FrameRange::parse(std::string_view text) {
  FrameRange range;
  std::optional<std::uint64_t> count = 0;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const auto run = TRY(run_of(trimmed(text.substr(at, comma - at))));
    count = checked_sum(*count, run.count());
    if (!count || *count > kMaxFrames) {
      return fail(ErrorCode::usage, fmt::format("frames {}: expected at most {} frames, found more",
                                                printable(text, kShownText), kMaxFrames));
    }
    range.runs_.push_back(run);
    at = comma + 1;
  }
  std::vector<std::int64_t> numbers = numbers_of(range.runs_);
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  range.runs_ = runs_of(numbers);
  return range;
}

std::uint64_t FrameRange::count() const {
  std::uint64_t count = 0;
  for (const FrameRun& run : runs_) count += run.count();
  return count;
}

bool FrameRange::contains(std::int64_t number) const {
  const auto after = std::ranges::upper_bound(runs_, number, {}, &FrameRun::first);
  if (after == runs_.begin()) return false;
  const FrameRun& run = *std::prev(after);
  return number <= run.last && (number - run.first) % run.step == 0;
}

std::vector<std::int64_t> FrameRange::numbers() const { return numbers_of(runs_); }

}  // namespace isoextract::batch
