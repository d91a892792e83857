// Hints for files of a kind that a command does not take; they name the command for such files.
#pragma once

#include <string>

#include "base/error.hpp"

namespace isoextract::cli {

// Adds a hint to an error of reading a mesh, if the file's name is that of a volume or of particles.
[[nodiscard]] Error add_mesh_file_hint(Error error, const std::string& path);

// Adds a hint to an error of reading a volume, if the file is a mesh.
[[nodiscard]] Error add_volume_file_hint(Error error, const std::string& path);

}  // namespace isoextract::cli
