#include "volume_io/vdb_points.hpp"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "volume_io/detail/grid_choice.hpp"
#include "volume_io/vdb/vdb_cursor.hpp"
#include "volume_io/vdb/vdb_header.hpp"

namespace isoextract::volume_io {
namespace {

// Returns the point grid that is called `wanted`; null if there is none. Fails if several grids are called so and one
// of them has points.
Result<const VdbGridRecord*> find_point_grid(const std::string& file, const VdbHeader& header,
                                             const std::string& wanted) {
  std::vector<GridInfo> grids(header.grids.size());
  for (std::size_t i = 0; i < grids.size(); ++i) grids[i].name = header.grids[i].name;
  label_grids(grids);
  const std::vector<std::size_t> found = grids_called(grids, wanted);
  const auto has_points = [&](std::size_t i) { return is_point_grid(header.grids[i]); };
  if (std::ranges::none_of(found, has_points)) return nullptr;
  if (found.size() == 1) return &header.grids[found.front()];
  std::string choices;
  for (const std::size_t i : found) {
    choices += fmt::format("\n  {}  {}", grids[i].label, printable(header.grids[i].value_type, 80));
  }
  return fail_for_several(file, found.size(), wanted, {Remedy::choose, Setting::grid, choices});
}

// Returns the unique name of a grid as OpenVDB shows and accepts it: "drops[1]".
std::string openvdb_name(const VdbGridRecord& record) {
  if (record.unique_name == record.name) return record.name;
  return fmt::format("{}[{}]", record.name, record.unique_name.substr(record.name.size() + 1));
}

}  // namespace

Result<bool> has_vdb_points(const files::InputFile& file, const std::optional<std::string>& grid) {
  try {
    VdbCursor cursor(file);
    if (!grid) return has_only_point_grids(cursor);
    const VdbHeader header = read_vdb_header(cursor);
    return TRY(find_point_grid(file.name(), header, *grid)) != nullptr;
  } catch (const VdbReadError& refused) {
    return tl::unexpected(refused.error);
  } catch (const std::runtime_error&) {
    return false;
  }
}

Result<std::string> vdb_points_name(const files::InputFile& file, const std::string& grid) {
  try {
    VdbCursor cursor(file);
    const VdbHeader header = read_vdb_header(cursor);
    const VdbGridRecord* const found = TRY(find_point_grid(file.name(), header, grid));
    if (found == nullptr || std::ranges::count(header.grids, found->unique_name, &VdbGridRecord::unique_name) > 1) {
      return grid;
    }
    return openvdb_name(*found);
  } catch (const VdbReadError& refused) {
    return tl::unexpected(refused.error);
  } catch (const std::runtime_error&) {
    return grid;
  }
}

Result<void> check_vdb_header(const files::InputFile& file) {
  try {
    VdbCursor cursor(file);
    static_cast<void>(read_vdb_header(cursor));
  } catch (const VdbReadError& refused) {
    return tl::unexpected(refused.error);
  } catch (const InvalidVdb& damage) {
    return fail(ErrorCode::input,
                fmt::format("{}: the VDB file is damaged: {}", file.name(), printable(damage.what(), 300)));
  } catch (const UnsupportedVdb&) {
    return {};
  }
  return {};
}

}  // namespace isoextract::volume_io
