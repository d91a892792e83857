// Splits names of inputs and outputs into text, numberings and words.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace isoextract::files {

struct NamePart {
  enum class Kind { text, number, word };
  Kind kind = Kind::text;
  std::string text;  // of Kind::text unescaped, else as written
  std::string word;  // the text between the braces; of {step:04} only "step"
  int width = 0;     // of a number or of {step}: minimum number of digits; 0: any
};

// Splits a name. Adjacent text is one part. Numbers are written as frame_pattern.hpp states; any other text in braces
// is a word. Braces around one of { % # are text, but a number between them counts. Fails with ErrorCode::usage for
// widths as FramePattern::parse() does.
[[nodiscard]] Result<std::vector<NamePart>> name_parts(std::string_view name);

// Escapes text so that name_parts() returns it as text.
[[nodiscard]] std::string escaped_name(std::string_view text);

// Makes a text from a file safe as part of one file name, visible and valid on other systems, too. Replaces these by _:
// slashes, backslashes, any of : * ? " < > |, control characters, invalid UTF-8, characters that change the writing
// direction, and leading dots.
[[nodiscard]] std::string safe_file_name(std::string_view text);

}  // namespace isoextract::files
