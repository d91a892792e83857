// Which format an input is: by what was asked for, by its content, then by its extension.
#pragma once

#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

struct DetectedFormat {
  const VolumeFormat* format;
  std::string note;  // where the extension says something else; else empty
};

// A prefix such as demo: decides; else ReadOptions::format, where it is given. A raw layout makes a file raw that
// nothing else claims. Fails with ErrorCode::input for what is not a volume, and with ErrorCode::usage for a format
// that there is not or that has no files.
[[nodiscard]] Result<DetectedFormat> detect_format(const std::string& input, const ReadOptions& options,
                                                   const Context& context);

// Whether the input is no file but begins like demo:.
[[nodiscard]] bool is_named_by_prefix(const std::string& input);
// Whether a format knows the file by its content.
[[nodiscard]] Result<bool> has_volume_content(const std::string& input, const Context& context);

}  // namespace isoextract::volume_io
