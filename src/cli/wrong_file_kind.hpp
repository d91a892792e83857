// Adds hints to errors about files of the wrong kind; the hint names a command that reads the file.
#pragma once

#include <string>

#include "base/error.hpp"

namespace isoextract::cli {

// Adds a hint to an error of reading a mesh, if the file name has the extension of a volume or of particles, and
// not that of a mesh. Changes only errors with ErrorCode::input and without a hint, and only for regular files
// that are not empty.
[[nodiscard]] Error add_mesh_file_hint(Error error, const std::string& path);

// Adds a hint to an error of reading a volume if `path` is a folder and the error has no hint. Replaces the hint of an
// ErrorCode::input if the non-empty file is a mesh (mesh_io::find_mesh_format()).
[[nodiscard]] Error add_volume_file_hint(Error error, const std::string& path);

}  // namespace isoextract::cli
