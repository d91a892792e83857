// Cells of CSV files that spreadsheets open.
#pragma once

#include <string>
#include <string_view>

namespace isoextract {

// A text as a cell (RFC 4180): in quotes where it holds a comma, a quote or a line end. Spreadsheets run a cell that
// begins with = + - @, a tab or a carriage return as a formula, so such a text gets an apostrophe before it. Numbers
// are no texts: write them without this function.
[[nodiscard]] std::string csv_cell(std::string_view text);

}  // namespace isoextract
