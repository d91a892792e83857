// Output names with words in them: "out/{stem}_{frame:04}_{iso}.glb".
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/enum_words.hpp"
#include "base/error.hpp"

namespace isoextract::batch {

enum class OutputWord { stem, frame, step, grid, iso, piece };
constexpr auto words_of(OutputWord /*type*/) {
  return std::array{Word{OutputWord::stem, "stem"}, Word{OutputWord::frame, "frame"}, Word{OutputWord::step, "step"},
                    Word{OutputWord::grid, "grid"}, Word{OutputWord::iso, "iso"},     Word{OutputWord::piece, "piece"}};
}

// Values of the words.
struct OutputWords {
  std::string stem;
  std::int64_t frame = 0;
  std::string grid;
  std::string iso;        // in the form of convert::file_name_part()
  std::int64_t step = 0;  // number of the simulation's time step
};

class OutputTemplate {
 public:
  // Parses a template. Numberings and escapes are those of frame_pattern.hpp, but a number may occur more than once:
  // "{frame:04}/mesh_####.ply". Text in braces is a number or a word, unless the braces are escaped or contain one of
  // { % #. Fails with ErrorCode::usage for unknown words, invalid widths of numbers, and words other
  // than step with a width.
  [[nodiscard]] static Result<OutputTemplate> parse(std::string_view name);

  [[nodiscard]] bool uses(OutputWord word) const;

  // Returns the name. Stem and grid are made safe by safe_file_name(). {piece} stays as convert::kPiecePlaceholder,
  // because the numbers of bodies are known only when the bodies exist.
  [[nodiscard]] std::string expand(const OutputWords& words) const;

 private:
  struct Part {
    std::string text;  // text before the word
    OutputWord word = OutputWord::stem;
    int width = 0;
  };
  std::vector<Part> parts_;
  std::string end_;  // text after the last word
};

// Returns a template that expands to exactly this name.
[[nodiscard]] std::string template_of(std::string_view name);

// Makes a text from a file safe as part of one file name, visible and valid on other systems, too. Replaces these by _:
// slashes, backslashes, any of : * ? " < > |, control characters, invalid UTF-8, characters that change the writing
// direction, and leading dots.
[[nodiscard]] std::string safe_file_name(std::string_view text);

}  // namespace isoextract::batch
