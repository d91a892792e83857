// File names with a frame number: sim_{:04}.vdb, sim_%04d.vdb, sim_####.vdb, shot_{:03}/density.vdb.
//
//   {}  %d  {frame}  $F  ${F}  #  @     the number without padding; leading zeros are allowed when reading
//   {:04}  {:4}  {frame:04}  %04d  %4d  ####  @@@@  $F4  ${F4}
//                                       at least 4 digits, padded with zeros; larger numbers have more
//   {{  }}  %%  {#}  {@}  {$}           the characters { } % # @ $ themselves
//
// A single # or @ stands for a number only between dots, dashes, underscores, slashes and the ends of a name
// (fire.#.vdb). Elsewhere it is text (take#1.vdb).
//
// The width counts digits: frame -1 is "-0001" in {:04}, as Houdini writes it (printf would write "-001"). When
// reading, a minus sign directly before the number makes it negative. In "sim-{:04}.vdb" the sign is part of the text,
// so sim-0001.vdb is frame 1.
//
// A pattern may also be the name of an existing file (a####.vdb), so readers look for such a file first.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract::files {

// Frame numbers and their differences fit into std::int64_t.
inline constexpr int kMaxFrameDigits = 18;
inline constexpr std::int64_t kMaxFrameNumber = 999'999'999'999'999'999;

class FramePattern {
 public:
  // Parses a name. Returns nullopt if the name has no placeholder; callers then use it unchanged: {{ stays {{. Fails
  // with ErrorCode::usage for several placeholders, for widths above kMaxFrameDigits, and for widths that are no number
  // ({:x}). Braces around other text are plain characters. If this text contains `{`, `%` or `#`, a placeholder in it
  // counts: {a%db} has the placeholder %d.
  [[nodiscard]] static Result<std::optional<FramePattern>> parse(std::string_view name);

  // `width` is 4 for {:04} and 0 for {}. prefix and suffix are plain text, without escapes.
  FramePattern(std::string prefix, int width, std::string suffix);

  // Returns the name of frame `number`, which is within +-kMaxFrameNumber.
  [[nodiscard]] std::string expand(std::int64_t number) const;

  // Returns the number for which expand() gives `name`; with width 0, leading zeros are allowed. Returns nullopt for
  // other names and for numbers of more than kMaxFrameDigits digits.
  [[nodiscard]] std::optional<std::int64_t> match(std::string_view name) const;

  [[nodiscard]] const std::string& prefix() const { return prefix_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] const std::string& suffix() const { return suffix_; }

  // Returns the pattern in the form that parse() takes, with {} or {:04}. May contain control characters.
  [[nodiscard]] std::string text() const;

  friend bool operator==(const FramePattern&, const FramePattern&) = default;

 private:
  std::string prefix_;
  int width_ = 0;
  std::string suffix_;
};

// Returns "-0001" for -1 and width 4.
[[nodiscard]] std::string frame_digits(std::int64_t number, int width);

}  // namespace isoextract::files
