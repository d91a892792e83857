// Sets of frame numbers: "1-240x2", "1-10,20,30-40x5", "-5-5".
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace isoextract::batch {

// Largest number of frames that one command converts.
inline constexpr std::uint64_t kMaxFrames = 1'000'000;

// The numbers first, first + step, ..., last, all within +-kMaxFrameNumber. The step of a single number is 1.
struct FrameRun {
  std::int64_t first = 0;
  std::int64_t last = 0;
  std::int64_t step = 1;

  [[nodiscard]] std::uint64_t count() const { return static_cast<std::uint64_t>((last - first) / step) + 1; }

  friend bool operator==(const FrameRun&, const FrameRun&) = default;
};

// Splits rising numbers into runs, in one greedy pass.
[[nodiscard]] std::vector<FrameRun> runs_of(std::span<const std::int64_t> numbers);

// Number of runs that a message lists.
inline constexpr std::size_t kShownFrameRuns = 20;

// Returns the text that FrameRange::parse() reads. If there are more than `max_runs` runs, lists `max_runs` and ",...",
// which parse() refuses.
[[nodiscard]] std::string text_of(std::span<const FrameRun> runs, std::size_t max_runs = std::string::npos);

// A set of frame numbers without duplicates, in rising order. Equal sets compare equal, however they were written.
class FrameRange {
 public:
  // Parses A, A-B or A-BxS, separated by commas and optional blanks. A and B are inclusive (B only if the steps reach
  // it) and may be negative. Fails with ErrorCode::usage for any other text, for B below A, steps below 1, numbers
  // beyond kMaxFrameNumber and more than kMaxFrames frames, where a number that occurs twice counts twice. Checks the
  // count before listing frames.
  [[nodiscard]] static Result<FrameRange> parse(std::string_view text);

  // Returns the runs, which do not overlap and are in rising order.
  [[nodiscard]] std::span<const FrameRun> runs() const { return runs_; }
  [[nodiscard]] std::uint64_t count() const;
  [[nodiscard]] bool contains(std::int64_t number) const;
  [[nodiscard]] std::vector<std::int64_t> numbers() const;

  friend bool operator==(const FrameRange&, const FrameRange&) = default;

 private:
  std::vector<FrameRun> runs_;
};

}  // namespace isoextract::batch
