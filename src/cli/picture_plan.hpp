// Plans outputs that are pictures of the surfaces instead of meshes.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

inline constexpr std::string_view kPictureFormat = "png";  // also the extension, without its dot

// Returns whether the output is a picture: by --format, or else by the extension of -o.
[[nodiscard]] bool writes_picture(const ConvertFlags& flags);

// Returns how to draw a picture; options that are not given have the defaults of convert::PictureFileOptions.
[[nodiscard]] convert::PictureFileOptions plan_view(const ViewFlags& flags);

// Returns how to draw the output, or nullopt if the output is no picture. Fails with ErrorCode::usage for options of
// mesh files if the output is a picture, and for options of pictures if the command draws none.
[[nodiscard]] Result<std::optional<convert::PictureFileOptions>> plan_picture(const ConvertFlags& flags);

// Returns the note for several frames whose cameras depend on the surfaces of each frame; empty if the camera is fixed
// (--camera with a distance, and --look-at). The caller checks that there are several frames.
[[nodiscard]] std::string cameras_note(const convert::PictureFileOptions& picture);

// Returns the extension, without its dot, of an output that is a field, particles or a picture; empty for a mesh.
[[nodiscard]] std::string_view non_mesh_extension(const ConvertFlags& flags);

}  // namespace isoextract::cli
