// Which format a file is: by its content, then by its extension. Private to io.
#pragma once

#include <string>
#include <string_view>

#include "base/error.hpp"
#include "files/file_bytes.hpp"
#include "volumes/volume_reader.hpp"

namespace isoextract::volumes {

struct DetectedFormat {
  VolumeFormat format;
  std::string note;  // where the extension says something else; else empty
};

// ReadOptions::format decides where it is given; a raw layout makes a file raw that nothing else claims. Fails with
// ErrorKind::input for what is not a volume.
[[nodiscard]] Result<DetectedFormat> detect_format(const files::InputFile& file, const ReadOptions& options);

[[nodiscard]] std::string_view volume_format_name(VolumeFormat format);

}  // namespace isoextract::volumes
