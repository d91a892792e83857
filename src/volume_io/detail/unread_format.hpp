// Formats of the field that are known and not read, so that a message can say what converts them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace isoextract::volume_io {

struct UnreadFormat {
  std::string title;  // "a DICOM file"
  bool by_name;       // what told it; else the content did
  std::string way;    // what makes a file of it that is read, as a clause of its own
};

// By the end of the file's name, whatever its case, then by what the file begins with. Nothing where neither is known.
[[nodiscard]] std::optional<UnreadFormat> unread_format(const std::filesystem::path& path,
                                                        std::span<const std::byte> start);

}  // namespace isoextract::volume_io
