// Which format's reader a fuzz target is for, as in --input-format or as the extension of a mesh.
#pragma once

#include <string_view>

namespace isoextract::fuzz {

extern const std::string_view kFormat;
extern const std::string_view kExtension;  // of the file, without the dot

}  // namespace isoextract::fuzz
