// What files begin with, by which formats know their own.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::files {

// The beginning of a file, for formats to know their own by. kStartBytes of it, or all where there are fewer.
inline constexpr std::size_t kStartBytes = 1024;
struct FileStart {
  const std::filesystem::path& path;
  std::span<const std::byte> bytes;  // inflated where the file is gzip
  bool packed = false;               // it is
};

[[nodiscard]] bool starts_with(std::span<const std::byte> content, std::string_view magic);

// What `file` should start with and does not. For formats that an extension or an option chose.
[[nodiscard]] tl::unexpected<Error> fail_magic(const InputFile& file, std::string_view format,
                                               std::string_view expected);

}  // namespace isoextract::files
