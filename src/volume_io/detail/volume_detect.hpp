// Detects the format of an input: by its prefix, by the options, by its content, then by its extension.
#pragma once

#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

struct DetectedFormat {
  const VolumeFormat* format;
  std::string note;  // set if the extension suggests another format
};

// Returns the format by the input's prefix such as demo:, else by ReadOptions::format, else by the content, else raw if
// a raw layout is given, else by the extension. Fails with ErrorCode::input if the input is not a volume, and with
// ErrorCode::usage if the format does not exist or has no files.
[[nodiscard]] Result<DetectedFormat> detect_format(const std::string& input, const ReadOptions& options,
                                                   const Context& context);

// Returns the folder that an empty file marks as an input of the file's format, as OpenFOAM's CASE.foam does.
[[nodiscard]] std::optional<std::string> folder_of_marker(const std::string& input, const Context& context);

// Returns whether the input is no file but has a prefix like demo:.
[[nodiscard]] bool is_named_by_prefix(const std::string& input);
// Returns whether a format recognizes the file by its content.
[[nodiscard]] Result<bool> has_volume_content(const std::string& input, const Context& context);

// Returns the path under which formats find the input: another one if it is compressed as a whole or an archive
// (plugin_host/unpacked_input.hpp). Keeps gzip files that a format decompresses itself, and those whose content no
// format claims, unless the options choose a format that does not.
[[nodiscard]] Result<std::string> unpack_for_volumes(const std::string& input, const ReadOptions& options,
                                                     const Context& context);

}  // namespace isoextract::volume_io
