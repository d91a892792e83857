// JSON for terminals: escapes the characters that would control the terminal.
#pragma once

#include <string>

namespace isoextract {

// Returns a JSON document in which \uXXXX replaces the characters that printable() escapes and JSON strings allow (DEL,
// C1 controls, line separators, changes of direction). Parsers read the same strings.
[[nodiscard]] std::string printable_json(std::string json);

}  // namespace isoextract
