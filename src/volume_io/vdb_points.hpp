// Finds point grids in VDB files from the header alone; a plug-in reads them.
#pragma once

#include <optional>
#include <string>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::volume_io {

// Returns whether a VDB file contains only point grids or, if `grid` is given, whether this grid is one. The rule for
// names is that of volumes: grids_called() (detail/grid_choice.hpp). Returns false for damaged or unknown files; the
// volume reader reports what is wrong with them. Fails if the file cannot be read, the context is cancelled, or several
// grids have the name and one of them has points.
[[nodiscard]] Result<bool> has_vdb_points(const files::InputFile& file, const std::optional<std::string>& grid);

// Returns the name that OpenVDB has for the point grid `grid`. Returns `grid` if the file has no such point grid or is
// damaged or unknown, or if OpenVDB cannot tell the grid from another one. Fails as has_vdb_points() does.
[[nodiscard]] Result<std::string> vdb_points_name(const files::InputFile& file, const std::string& grid);

// Fails with ErrorCode::input if the header is damaged, and if the file cannot be read. OpenVDB does not validate its
// input; this function finds grid positions beyond the end of a truncated file. Accepts unknown headers: OpenVDB may
// support them.
[[nodiscard]] Result<void> check_vdb_header(const files::InputFile& file);

}  // namespace isoextract::volume_io
