#include "volume_io/vdb_points.hpp"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "volume_io/vdb/vdb_cursor.hpp"
#include "volume_io/vdb/vdb_header.hpp"

namespace isoextract::volume_io {

Result<bool> has_vdb_points(const files::InputFile& file, const std::optional<std::string>& grid) {
  try {
    VdbCursor cursor(file);
    if (!grid) return has_only_point_grids(cursor);
    const VdbHeader header = read_vdb_header(cursor);
    return std::ranges::any_of(
        header.grids, [&](const VdbGridRecord& record) { return is_point_grid(record) && record.name == *grid; });
  } catch (const VdbReadError& refused) {
    return tl::unexpected(refused.error);
  } catch (const std::runtime_error&) {
    return false;
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
