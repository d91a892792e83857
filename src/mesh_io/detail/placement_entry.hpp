// MeshWriteOptions::placement in files: what it is called, and how much of it is read.
#pragma once

#include <cstddef>
#include <string_view>

namespace isoextract::mesh_io {

// The first word of a comment, or the key of an entry.
inline constexpr std::string_view kPlacementEntry = "placement";
// In place of a placement that a file has no room for: it is none that can be read.
inline constexpr std::string_view kPlacementElsewhere = "elsewhere";
inline constexpr std::size_t kMaxPlacement = 16000;  // bytes

}  // namespace isoextract::mesh_io
