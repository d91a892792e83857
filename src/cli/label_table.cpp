#include "cli/label_table.hpp"

#include <fmt/format.h>

#include "base/printable.hpp"

namespace isoextract::cli {

std::vector<std::string> label_table(const convert::WrittenOutput& output) {
  constexpr std::size_t kMostOfName = 60;
  std::vector<std::string> rows{fmt::format("  {:>20} {:>12} {:>12} {:>10}  {:6}  {}", "label", "voxels", "volume",
                                            "triangles", "closed", "name")};
  for (const convert::WrittenOutput::Part& part : output.surfaces) {
    rows.push_back(fmt::format("  {:>20} {:>12} {:>12.6g} {:>10}  {:6}  {}", part.id.text(), part.voxels, part.volume,
                               part.triangles, part.closed ? "yes" : "no", printable(part.name, kMostOfName)));
  }
  return rows;
}

}  // namespace isoextract::cli
