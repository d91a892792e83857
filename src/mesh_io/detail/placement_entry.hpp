// How mesh files store MeshWriteOptions::placement: its key, and the length that readers accept.
#pragma once

#include <cstddef>
#include <string_view>

namespace isoextract::mesh_io {

// The first word of the comment, or the key of the metadata entry.
inline constexpr std::string_view kPlacementEntry = "placement";
// Stored instead of a placement that does not fit into the file. Readers cannot parse it as a placement.
inline constexpr std::string_view kPlacementOmitted = "elsewhere";
inline constexpr std::size_t kMaxPlacement = 16000;  // bytes

}  // namespace isoextract::mesh_io
