// Cells of CSV files that spreadsheets open.
#pragma once

#include <string>
#include <string_view>

namespace isoextract {

// Returns `text` as a cell (RFC 4180), in quotes if it contains a comma, a quote or a line end. Spreadsheets run a cell
// that begins with = + - @, a tab or a carriage return as a formula, so such a text gets a leading apostrophe. Write
// numbers without this function.
[[nodiscard]] std::string csv_cell(std::string_view text);

}  // namespace isoextract
