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

// Returns a note if the pictures of several frames have different cameras; otherwise empty.
[[nodiscard]] std::string cameras_note(const convert::PictureFileOptions& picture);

// Returns the extension of outputs that are not meshes; empty for meshes.
[[nodiscard]] std::string_view other_extension(const ConvertFlags& flags);

}  // namespace isoextract::cli
