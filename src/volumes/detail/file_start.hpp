// What files begin with, by which formats know their own.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "base/error.hpp"
#include "files/file_bytes.hpp"
#include "volumes/volume_format.hpp"

namespace isoextract::volumes {

[[nodiscard]] bool starts_with(std::span<const std::byte> content, std::string_view magic);

// What `file` should start with and does not. For formats that an extension or an option chose.
[[nodiscard]] tl::unexpected<Error> fail_magic(const files::InputFile& file, std::string_view format,
                                               std::string_view expected);

}  // namespace isoextract::volumes
