// Keys of file locations, to find different names of the same file among many.
#pragma once

#include <filesystem>
#include <string>
#include <unordered_map>

namespace isoextract::files {

// Looks up each folder once. Compare only keys of the same function.
class LocationKeys {
 public:
  // Returns equal keys for all names of an existing file, pipe or device; by_name() if nothing exists. Unlike
  // is_same_output(), treats /dev/null as any file and "-" as no file, and does not follow a link to a missing file.
  [[nodiscard]] std::string key(const std::filesystem::path& path);

  // Returns the file name in its folder after resolving the folder's links, for files that may not exist. Does not
  // follow a link that is the file itself.
  [[nodiscard]] std::string by_name(const std::filesystem::path& path);

 private:
  const std::string& folder(const std::string& name);

  std::unordered_map<std::string, std::string> folders_;
};

}  // namespace isoextract::files
