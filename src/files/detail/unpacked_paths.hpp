// The packed files that paths of unpacked files come from. Private to the room.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace isoextract::files {

struct PackedPlace {
  std::string source;         // the file that was unpacked
  std::string folder;         // the temporary folder
  std::string member;         // path in that folder; empty for the folder itself
  bool is_only_file = false;  // the source is a compressed file, not an archive
};

// Returns nothing for a path that is not one of an unpacked file.
[[nodiscard]] std::optional<PackedPlace> packed_place(const std::filesystem::path& path);

}  // namespace isoextract::files
