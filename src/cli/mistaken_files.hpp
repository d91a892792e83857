// Files of another kind than a command takes, and the command that is for them.
#pragma once

#include <string>

#include "base/error.hpp"

namespace isoextract::cli {

// `error` of reading a mesh: where the file's name is that of a volume or of particles, the hint says what tells of
// them.
[[nodiscard]] Error about_mesh_file(Error error, const std::string& path);

// `error` of reading a volume, and the same for a mesh.
[[nodiscard]] Error about_volume_file(Error error, const std::string& path);

}  // namespace isoextract::cli
