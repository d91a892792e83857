// Places on the disk as texts, to find names of one file among many.
#pragma once

#include <filesystem>
#include <string>
#include <unordered_map>

namespace isoextract::files {

// Texts that are equal where what is written to two paths would come to one place, as same_place() has it. Each folder
// is looked up once.
class PlaceKeys {
 public:
  [[nodiscard]] std::string key(const std::filesystem::path& path);

  // Of a path whose file need not be there.
  [[nodiscard]] std::string by_name(const std::filesystem::path& path);

 private:
  const std::string& folder(const std::string& name);

  std::unordered_map<std::string, std::string> folders_;
};

}  // namespace isoextract::files
