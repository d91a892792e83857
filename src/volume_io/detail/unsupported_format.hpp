// Known formats that are not supported, for messages that name a program to convert them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace isoextract::volume_io {

struct UnsupportedFormat {
  std::string title;  // "a MINC volume"
  bool by_name;       // recognized by its name; else by its content
  std::string way;    // how to convert it to a supported format, as a clause
};

// Recognizes a file by its extension, ignoring case, then by its first bytes. Returns nothing if neither is known.
[[nodiscard]] std::optional<UnsupportedFormat> find_unsupported_format(const std::filesystem::path& path,
                                                                       std::span<const std::byte> start);

}  // namespace isoextract::volume_io
