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

enum class OutputWord { stem, frame, step, grid, iso, label, name, piece };
constexpr auto words_of(OutputWord /*type*/) {
  return std::array{Word{OutputWord::stem, "stem"}, Word{OutputWord::frame, "frame"}, Word{OutputWord::step, "step"},
                    Word{OutputWord::grid, "grid"}, Word{OutputWord::iso, "iso"},     Word{OutputWord::label, "label"},
                    Word{OutputWord::name, "name"}, Word{OutputWord::piece, "piece"}};
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

  // Returns the name. Stem and grid are made safe by files::safe_file_name(). {piece}, {label} and {name} stay as
  // convert::kPiecePlaceholder, kLabelPlaceholder and kNamePlaceholder, because bodies and labels are known only once
  // they are found.
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

}  // namespace isoextract::batch
