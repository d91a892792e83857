// `isoextract convert`: a volume in, meshes out.
#pragma once

#include <string_view>

namespace isoextract::cli {

// Ends the note that relaxing changed volumes.
inline constexpr std::string_view kHowToKeepVolumes = ": --relax 0 keeps the volumes of the voxels";

}  // namespace isoextract::cli
