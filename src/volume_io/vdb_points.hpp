// Points in VDB files, which a plug-in reads: what the header tells of them without it.
#pragma once

#include <optional>
#include <string>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::volume_io {

// Whether a VDB file holds points and nothing else, or where `grid` is given, points by that name. False where the file
// is damaged or not known: the reader of volumes says what is wrong with it. Fails where the file cannot be read, or
// where the work is to end.
[[nodiscard]] Result<bool> has_vdb_points(const files::InputFile& file, const std::optional<std::string>& grid);

// Fails where the header is damaged: OpenVDB believes what it reads, and places of grids that a cut file no longer has
// are found here. A header that is not known here is no error, as OpenVDB may know it.
[[nodiscard]] Result<void> check_vdb_header(const files::InputFile& file);

}  // namespace isoextract::volume_io
