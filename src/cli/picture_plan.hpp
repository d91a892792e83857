// Outputs that are pictures of the surfaces, in place of meshes.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

inline constexpr std::string_view kPictureFormat = "png";  // also the extension, without its dot

// By --format, and else by the name after -o.
[[nodiscard]] bool writes_picture(const ConvertFlags& flags);

// Nothing where a mesh or a field is written. Refuses what is about files of meshes where a picture is written, and
// what is about pictures where none is.
[[nodiscard]] Result<std::optional<convert::PictureFileOptions>> plan_picture(const ConvertFlags& flags);

// Returns a note for pictures of several frames whose camera is not the same for all; empty where there is nothing to
// tell.
[[nodiscard]] std::string note_of_cameras(const convert::PictureFileOptions& picture);

// The extension of outputs that are no meshes; empty where they are.
[[nodiscard]] std::string_view other_extension(const ConvertFlags& flags);

}  // namespace isoextract::cli
