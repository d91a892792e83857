// Names of files with a number in them: sim_{:04}.vdb, sim_%04d.vdb, sim_####.vdb, shot_{:03}/density.vdb.
//
//   {}  %d  {frame}  $F  ${F}  #  @     the number as it is; when read, with any zeros before it
//   {:04}  {:4}  {frame:04}  %04d  %4d  ####  @@@@  $F4  ${F4}
//                                       at least 4 digits, filled with zeros; larger numbers have more
//   {{  }}  %%  {#}  {@}  {$}           the characters { } % # @ $ themselves
//
// A single # or @ is numbering between dots, dashes, underscores, slashes and the ends of a name (fire.#.vdb), and text
// elsewhere (take#1.vdb).
//
// The width counts digits: frame -1 is "-0001" in {:04}, as Houdini writes it (printf would write "-001"). A number
// directly after a minus sign is read as negative; in "sim-{:04}.vdb" the sign is part of the name, and 1 is read.
//
// A name that is a pattern may be the name of a file as well (a####.vdb): whoever reads files looks for that first.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract::batch {

// Frame numbers and their differences fit into 64 bits.
inline constexpr int kMaxFrameDigits = 18;
inline constexpr std::int64_t kMaxFrameNumber = 999'999'999'999'999'999;

class FramePattern {
 public:
  // Nothing where the name has no numbering; escapes then stand for nothing else than what is written. Fails with
  // ErrorCode::usage for more than one numbering, for widths above kMaxFrameDigits and for {:x}. Anything else in
  // braces is text, and so is what looks like none of the above.
  [[nodiscard]] static Result<std::optional<FramePattern>> parse(std::string_view name);

  // `width` is that of {:04}, 0 that of {}; prefix and suffix are text.
  FramePattern(std::string prefix, int width, std::string suffix);

  // `number` is within +-kMaxFrameNumber.
  [[nodiscard]] std::string expand(std::int64_t number) const;

  // The number with which expand() gives `name`; with width 0 zeros may stand before it. Nothing for names that are
  // none of this pattern, and for numbers of more than kMaxFrameDigits digits.
  [[nodiscard]] std::optional<std::int64_t> match(std::string_view name) const;

  [[nodiscard]] const std::string& prefix() const { return prefix_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] const std::string& suffix() const { return suffix_; }

  // As parse() takes it, with {}; not fit for a terminal.
  [[nodiscard]] std::string text() const;

  friend bool operator==(const FramePattern&, const FramePattern&) = default;

 private:
  std::string prefix_;
  int width_ = 0;
  std::string suffix_;
};

// "-0001" for -1 and width 4.
[[nodiscard]] std::string frame_digits(std::int64_t number, int width);

}  // namespace isoextract::batch
