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

// Returns the format by the input's prefix such as demo:, else by ReadOptions::format, else the format that takes the
// stack or folder, else by the content. If these do not decide: raw if a raw layout is given, else by the extension.
// Fails with ErrorCode::input if the input is not a volume, and with ErrorCode::usage if the format is unknown or has
// no files.
[[nodiscard]] Result<DetectedFormat> detect_format(const std::string& input, const ReadOptions& options,
                                                   const Context& context);

// Returns the folder of an empty marker file, such as OpenFOAM's CASE.foam, if the format with the extension of that
// file can read the folder.
[[nodiscard]] std::optional<std::string> folder_of_marker(const std::string& input, const Context& context);

// Returns whether the input has the prefix of a format without files, such as demo:.
[[nodiscard]] bool is_named_by_prefix(const std::string& input);
// Returns whether a format recognizes the content of the file or folder, or the input is a stack of slices.
[[nodiscard]] Result<bool> has_volume_content(const std::string& input, const Context& context);

// Returns the path under which formats find the input. It is another one if the input is compressed as a whole or an
// archive (plugin_host/unpacked_input.hpp). If the archive's folder is not an input itself, it is the only file in it
// with the name of a volume.
// Keeps a gzip file if a format decompresses it itself, or if no format claims its content and the options give neither
// a format nor a raw layout. Always unpacks gzip tar archives.
[[nodiscard]] Result<std::string> unpack_for_volumes(const std::string& input, const ReadOptions& options,
                                                     const Context& context);

}  // namespace isoextract::volume_io
