#include "volume_io/detail/grid_choice.hpp"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/nearest_name.hpp"
#include "base/printable.hpp"

namespace isoextract::volume_io {
namespace {

std::string describe_grid(const GridInfo& grid) {
  if (!grid.scalar) return "not scalar";
  std::string text = "not counted";
  if (grid.voxels) {
    const field::IndexBox& box = grid.box;
    text = *grid.voxels == 0 ? "empty"
                             : fmt::format("{} active voxels in [{},{},{}]..[{},{},{}]", *grid.voxels, box.min.x,
                                           box.min.y, box.min.z, box.max.x, box.max.y, box.max.z);
  }
  if (grid.kind) text += *grid.kind == field::FieldKind::level_set ? ", level set" : ", density";
  if (!grid.placement_problem.empty()) text += "; its placement is not usable: " + grid.placement_problem;
  return text;
}

template <class F>
std::vector<std::size_t> indices_where(std::span<const GridInfo> grids, const F& is_meant) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < grids.size(); ++i) {
    if (is_meant(grids[i])) found.push_back(i);
  }
  return found;
}

}  // namespace

void label_grids(std::span<GridInfo> grids) {
  std::map<std::string, int> names;  // printable names, with the number of grids that have them
  for (GridInfo& grid : grids) {
    grid.label = printable(grid.name, kMaxLabel);
    ++names[grid.label];
  }
  std::map<std::string, int> next;
  for (GridInfo& grid : grids) {
    const std::string name = grid.label;
    if (names[name] == 1) continue;
    do {
      grid.label = fmt::format("{}[{}]", name, next[name]++);
    } while (names.contains(grid.label));
  }
}

std::vector<std::size_t> grids_called(std::span<const GridInfo> grids, const std::string& wanted) {
  auto found = indices_where(grids, [&](const GridInfo& grid) { return grid.label == wanted; });
  if (!found.empty()) return found;
  return indices_where(grids, [&](const GridInfo& grid) {
    return grid.matches_name(wanted) || printable(grid.name, kMaxLabel) == wanted;
  });
}

tl::unexpected<Error> fail_for_several(const std::string& file, std::size_t count, const std::string& wanted,
                                       Hint hint) {
  return fail(ErrorCode::input, fmt::format("{}: {} grids are named '{}'", file, count, printable(wanted, kMaxLabel)),
              std::move(hint));
}

std::string grid_table(std::span<const GridInfo> grids) {
  constexpr std::size_t kMaxRows = 100;
  const auto shown = grids.first(std::min(kMaxRows, grids.size()));
  std::size_t label_width = 0;
  std::size_t type_width = 0;
  for (const GridInfo& grid : shown) {
    label_width = std::max(label_width, grid.label.size());
    type_width = std::max(type_width, grid.type.size());
  }
  std::string table;
  for (const GridInfo& grid : shown) {
    table += fmt::format("{}  {:<{}}  {:<{}}  {}", table.empty() ? "" : "\n", grid.label, label_width, grid.type,
                         type_width, describe_grid(grid));
  }
  if (shown.size() < grids.size()) table += fmt::format("\n  ... and {} more", grids.size() - shown.size());
  return table;
}

Result<std::size_t> choose_grid(const std::string& file, std::span<const GridInfo> grids,
                                const std::optional<std::string>& wanted) {
  if (grids.empty()) return fail(ErrorCode::input, file + ": there is no grid in the file");
  const auto listed = [&] { return Hint(Remedy::choose, Setting::grid, "\n" + grid_table(grids)); };
  const auto found =
      wanted ? grids_called(grids, *wanted) : indices_where(grids, [](const GridInfo& grid) { return grid.scalar; });
  if (!wanted) {
    if (found.size() == 1) return found.front();
    const auto message = found.empty()
                             ? fmt::format("{}: expected a grid of scalars, such as float or int32, found none", file)
                             : fmt::format("{}: expected one scalar grid, found {}", file, found.size());
    return fail(ErrorCode::input, message,
                found.empty() ? Hint("the grids of the file are\n" + grid_table(grids)) : listed());
  }
  if (found.empty()) {
    std::vector<std::string> names;
    for (const GridInfo& grid : grids) names.push_back(grid.name);
    return fail(
        ErrorCode::input,
        fmt::format("{}: there is no grid '{}'{}", file, printable(*wanted, kMaxLabel), did_you_mean(*wanted, names)),
        listed());
  }
  if (found.size() > 1) return fail_for_several(file, found.size(), *wanted, listed());
  if (!grids[found.front()].scalar) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected a grid of scalars, such as float or int32, but '{}' has values of type {}",
                            file, grids[found.front()].label, grids[found.front()].type),
                listed());
  }
  return found.front();
}

Result<std::uint64_t> choose_volume(const std::string& file, std::uint64_t count, std::optional<std::int64_t> wanted,
                                    const Hint& otherwise) {
  Hint hint = count == 1 ? Hint(Remedy::leave_out, Setting::volume, "there is one volume in the file")
                         : Hint(Remedy::choose, Setting::volume, fmt::format("from 0 to {}", count - 1));
  if (count > 1) hint.steps.insert(hint.steps.end(), otherwise.steps.begin(), otherwise.steps.end());
  if (!wanted) {
    if (count == 1) return 0;
    return fail(ErrorCode::input,
                fmt::format("{}: expected the number of one volume, because the file has {} volumes", file, count),
                hint);
  }
  if (std::cmp_less(*wanted, 0) || std::cmp_greater_equal(*wanted, count)) {
    return fail(ErrorCode::input,
                fmt::format("{}: there is no volume {}; expected {}", file, *wanted,
                            count == 1 ? std::string("0, the only one") : fmt::format("0 to {}", count - 1)),
                hint);
  }
  return static_cast<std::uint64_t>(*wanted);
}

Result<std::optional<std::uint64_t>> choose_component(const std::string& file, std::uint64_t count,
                                                      const std::optional<ComponentChoice>& wanted,
                                                      const std::string& names) {
  const Hint choice{{Remedy::choose, Setting::component,
                     fmt::format("from 0 to {}{}{}", count - 1, names.empty() ? "" : ": ", names)},
                    {Remedy::set, Setting::component, "length to take the length of the vector"}};
  if (!wanted) {
    if (count == 1) return 0;
    return fail(ErrorCode::input, fmt::format("{}: expected one number per sample, found {} components", file, count),
                choice);
  }
  if (count == 1) {
    if (wanted->number == 0) return 0;
    return fail(ErrorCode::input, fmt::format("{}: expected several components per sample, found one", file),
                {Remedy::leave_out, Setting::component});
  }
  if (!wanted->number) return std::nullopt;
  if (std::cmp_less(*wanted->number, 0) || std::cmp_greater_equal(*wanted->number, count)) {
    return fail(ErrorCode::input,
                fmt::format("{}: there is no component {}; expected 0 to {}", file, *wanted->number, count - 1),
                choice);
  }
  return static_cast<std::uint64_t>(*wanted->number);
}

}  // namespace isoextract::volume_io
