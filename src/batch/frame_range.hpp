// Which frames: "1-240x2", "1-10,20,30-40x5", "-5-5".
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace isoextract::batch {

// At most so many frames in one run.
inline constexpr std::uint64_t kMaxFrames = 1'000'000;

// first, first + step, ..., last. The numbers are within +-kMaxFrameNumber, and the step is 1 where there is only one.
struct FrameRun {
  std::int64_t first = 0;
  std::int64_t last = 0;
  std::int64_t step = 1;

  [[nodiscard]] std::uint64_t count() const { return static_cast<std::uint64_t>((last - first) / step) + 1; }

  friend bool operator==(const FrameRun&, const FrameRun&) = default;
};

// As few runs as one pass finds. `numbers` rise.
[[nodiscard]] std::vector<FrameRun> runs_of(std::span<const std::int64_t> numbers);

// How many of them a message lists.
inline constexpr std::size_t kShownFrameRuns = 20;

// As parse() reads it; of more than `max_runs`, "..." stands for the rest.
[[nodiscard]] std::string text_of(std::span<const FrameRun> runs, std::size_t max_runs = std::string::npos);

// A set of frames: each counts once, however often it was named, and they come in rising order. Equal sets are equal,
// however they were written.
class FrameRange {
 public:
  // A, A-B or A-BxS, separated by commas; blanks around those do not matter. A and B belong to it, B only where the
  // steps meet it; both may be negative. Fails with ErrorCode::usage for anything else, for B below A, a step below 1,
  // numbers beyond kMaxFrameNumber and more than kMaxFrames frames, before memory is taken for them.
  [[nodiscard]] static Result<FrameRange> parse(std::string_view text);

  // One after another: each begins after the end of the one before.
  [[nodiscard]] std::span<const FrameRun> runs() const { return runs_; }
  [[nodiscard]] std::uint64_t count() const;
  [[nodiscard]] bool contains(std::int64_t number) const;
  [[nodiscard]] std::vector<std::int64_t> numbers() const;

  friend bool operator==(const FrameRange&, const FrameRange&) = default;

 private:
  std::vector<FrameRun> runs_;
};

}  // namespace isoextract::batch
