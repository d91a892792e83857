// JSON for terminals: its own escapes in place of the characters that a terminal obeys.
#pragma once

#include <string>

namespace isoextract {

// Returns the text of a JSON document with the characters that printable() escapes and JSON allows in its strings (DEL,
// C1 controls, line separators, changes of direction) as \uXXXX. Readers of the document get the same strings.
[[nodiscard]] std::string printable_json(std::string json);

}  // namespace isoextract
