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

// Returns the files that a pattern or folder stands for, in the order of their numbers; the files of a folder whose
// names do not differ in one number are in natural order. Returns nullopt for other inputs, for fewer than two files,
// and if a file's extension is not one of `format`. Fails with ErrorCode::input if a folder cannot be read, if numbers
// are missing between the files (at the greatest step that all share), and if two files have the same number. Opens no
// file.
[[nodiscard]] Result<std::optional<std::vector<std::string>>> find_slices(const std::string& input,
                                                                          const VolumeFormat& format);

// Returns the format that reads the input as a stack, or null. The first file that can be read, of the first and the
// last one, must be a single picture: other files are a sequence of volumes.
[[nodiscard]] const VolumeFormat* format_of_stack(const std::string& input, const Context& context);

}  // namespace isoextract::volume_io
