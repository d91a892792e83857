// Keys of file locations, to find different names of the same file among many.
#pragma once

#include <filesystem>
#include <string>
#include <unordered_map>

namespace isoextract::files {

// Two paths have equal keys if writing to them would reach the same place; see is_same_output(). Looks up each folder
// once.
class LocationKeys {
 public:
  [[nodiscard]] std::string key(const std::filesystem::path& path);

  // Returns the key from the path alone, for files that may not exist.
  [[nodiscard]] std::string by_name(const std::filesystem::path& path);

 private:
  const std::string& folder(const std::string& name);

  std::unordered_map<std::string, std::string> folders_;
};

}  // namespace isoextract::files
