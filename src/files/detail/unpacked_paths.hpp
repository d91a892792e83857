// Finds the archive or compressed file from which a file was unpacked. Private to src/files.
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

// Returns the origin of a path in the temporary folder of an unpacked file; nullopt for any other path.
[[nodiscard]] std::optional<PackedPlace> packed_place(const std::filesystem::path& path);

}  // namespace isoextract::files
