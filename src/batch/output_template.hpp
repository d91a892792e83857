// Names of outputs with words in them: "out/{stem}_{frame:04}_{iso}.glb".
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "base/words.hpp"

namespace isoextract::batch {

enum class OutputWord { stem, frame, grid, iso, piece };
constexpr auto words_of(OutputWord /*type*/) {
  return std::array{Word{OutputWord::stem, "stem"}, Word{OutputWord::frame, "frame"}, Word{OutputWord::grid, "grid"},
                    Word{OutputWord::iso, "iso"}, Word{OutputWord::piece, "piece"}};
}

// What the words stand for.
struct OutputWords {
  std::string stem;
  std::int64_t frame = 0;
  std::string grid;
  std::string iso;  // as convert::text_of() has it
};

class OutputTemplate {
 public:
  // Numbering and escapes are those of frame_pattern.hpp, except that a number may be there more than once:
  // "{frame:04}/mesh_####.ply". Nothing in braces is text unless the braces are escaped. Fails with ErrorCode::usage
  // for words that are unknown or have a width, and for what FramePattern::parse() refuses.
  [[nodiscard]] static Result<OutputTemplate> parse(std::string_view name);

  [[nodiscard]] bool uses(OutputWord word) const;

  // Stem and grid come out as safe_in_file_names(), and {piece} as it is, convert::kPieceWord: the numbers are known
  // once there are pieces.
  [[nodiscard]] std::string expand(const OutputWords& words) const;

 private:
  struct Part {
    std::string text;  // before the word
    OutputWord word = OutputWord::stem;
    int width = 0;
  };
  std::vector<Part> parts_;
  std::string end_;  // after the last word
};

// A template that expands to this very name.
[[nodiscard]] std::string template_of(std::string_view name);

// For names that come out of files: _ stands for slashes, backslashes, control characters, what is no UTF-8 or turns
// the direction of writing, any of : * ? " < > | and dots at the beginning, so that the text is part of one name, of a
// file that is not hidden and that other systems can have as well.
[[nodiscard]] std::string safe_in_file_names(std::string_view text);

}  // namespace isoextract::batch
