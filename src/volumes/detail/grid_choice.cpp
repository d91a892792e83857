#include "volumes/detail/grid_choice.hpp"

#include <algorithm>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "files/file_bytes.hpp"

namespace isoextract::volumes {
namespace {

std::string describe_grid(const GridInfo& grid) {
  if (!grid.scalar) return "not scalar";
  const char* kind = "";
  if (grid.kind) kind = *grid.kind == field::FieldKind::level_set ? ", level set" : ", fog volume";
  if (grid.voxels == 0) return fmt::format("empty{}", kind);
  const field::IndexBox& box = grid.box;
  return fmt::format("{} active voxels in [{},{},{}]..[{},{},{}]{}", grid.voxels, box.min.x, box.min.y, box.min.z,
                     box.max.x, box.max.y, box.max.z, kind);
}

}  // namespace

void number_repeated_names(std::span<GridInfo> grids) {
  std::map<std::string, int> counts;
  for (GridInfo& info : grids) info.index_of_name = counts[info.name]++;
  for (GridInfo& info : grids) info.name_repeats = counts[info.name] > 1;
}

std::string grid_label(const GridInfo& grid) {
  const std::string name = files::printable(std::string_view(grid.name), 200);
  return grid.name_repeats ? fmt::format("{}[{}]", name, grid.index_of_name) : name;
}

std::string grid_table(std::span<const GridInfo> grids) {
  constexpr std::size_t kMaxRows = 100;
  const auto shown = grids.first(std::min(kMaxRows, grids.size()));
  std::size_t label_width = 0;
  std::size_t type_width = 0;
  for (const GridInfo& grid : shown) {
    label_width = std::max(label_width, grid_label(grid).size());
    type_width = std::max(type_width, grid.type.size());
  }
  std::string table;
  for (const GridInfo& grid : shown) {
    table += fmt::format("{}  {:<{}}  {:<{}}  {}", table.empty() ? "" : "\n", grid_label(grid), label_width, grid.type,
                         type_width, describe_grid(grid));
  }
  if (shown.size() < grids.size()) table += fmt::format("\n  ... and {} more", grids.size() - shown.size());
  return table;
}

Result<std::size_t> choose_grid(const std::string& file, std::span<const GridInfo> grids,
                                const std::optional<std::string>& wanted) {
  const auto listed = [&](Remedy remedy) { return Hint(remedy, "\n" + grid_table(grids)); };
  if (grids.empty()) return fail(ErrorKind::input, file + ": there is no grid in the file");
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const bool match = wanted ? grids[i].name == *wanted || grid_label(grids[i]) == *wanted : grids[i].scalar;
    if (match) found.push_back(i);
  }
  if (!wanted) {
    if (found.size() == 1) return found.front();
    const auto message = found.empty() ? fmt::format("{}: expected a grid of float, double or int32, found none", file)
                                       : fmt::format("{}: {} of its grids are scalar", file, found.size());
    return fail(ErrorKind::input, message,
                found.empty() ? Hint("its grids are\n" + grid_table(grids)) : listed(Remedy::choose_grid));
  }
  if (found.empty()) {
    return fail(ErrorKind::input,
                fmt::format("{}: there is no grid '{}'", file, files::printable(std::string_view(*wanted), 200)),
                listed(Remedy::choose_grid));
  }
  if (found.size() > 1) {
    return fail(ErrorKind::input, fmt::format("{}: {} grids are named '{}'", file, found.size(), *wanted),
                listed(Remedy::choose_grid_number));
  }
  if (!grids[found.front()].scalar) {
    return fail(ErrorKind::input,
                fmt::format("{}: expected a grid of float, double or int32, '{}' holds {}", file, *wanted,
                            grids[found.front()].type),
                listed(Remedy::choose_grid));
  }
  return found.front();
}

}  // namespace isoextract::volumes
