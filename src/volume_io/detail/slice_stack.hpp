// Stacks: a pattern of file names (files/frame_pattern.hpp) or a folder whose files are single pictures of one format,
// each of them a slice of one volume. Formats with FormatDescription::takes_slices read them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// Returns the files that a pattern or folder stands for, in the order of their numbers. In a folder, the order is
// natural if the names differ elsewhere than in their last number. Ignores files that are not volumes. Returns nullopt
// for other inputs, for fewer than two files, for a pattern without an extension of `format`, and for a folder that has
// files of other volume formats. Fails with ErrorCode::input if a folder cannot be read, if the distances between
// consecutive numbers differ, and if two files have the same number. Opens no file.
[[nodiscard]] Result<std::optional<std::vector<std::string>>> find_slices(const std::string& input,
                                                                          const VolumeFormat& format);

// Returns the format that reads the input as a stack, or null. Tests the first file, or the last one if the first
// cannot be read: it must be a single picture, as other files are a sequence of volumes.
[[nodiscard]] const VolumeFormat* format_of_stack(const std::string& input, const Context& context);

}  // namespace isoextract::volume_io
