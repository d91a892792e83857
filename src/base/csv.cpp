#include "base/csv.hpp"

namespace isoextract {

std::string csv_cell(std::string_view text) {
  constexpr std::string_view kFormulaStarts = "=+-@\t\r";
  std::string cell;
  if (!text.empty() && kFormulaStarts.find(text.front()) != std::string_view::npos) cell = "'";
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return cell.append(text);
  cell = '"' + cell;
  for (const char c : text) {
    if (c == '"') cell += c;
    cell += c;
  }
  return cell + '"';
}

}  // namespace isoextract
