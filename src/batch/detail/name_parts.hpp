// What stands in a name besides its text: numbering and words. For names of inputs and for those of outputs.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace isoextract::batch {

struct NamePart {
  enum class Kind { text, number, word };
  Kind kind = Kind::text;
  std::string text;  // text: unescaped; else as it was written
  std::string word;  // what stands between the braces
  int width = 0;     // of a number: at least so many digits; 0 is any way of writing it
};

// Neighbouring text is one part. {frame} is a number, anything else in braces a word. Fails as FramePattern::parse()
// does.
[[nodiscard]] Result<std::vector<NamePart>> name_parts(std::string_view name);

// The way back for text: a name in which it stands for itself.
[[nodiscard]] std::string escaped_name(std::string_view text);

}  // namespace isoextract::batch
