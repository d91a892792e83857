#include "files/location_keys.hpp"

#include <sys/stat.h>

#include <system_error>

#include <fmt/format.h>

namespace isoextract::files {

namespace fs = std::filesystem;

std::string LocationKeys::key(const fs::path& path) {
  if (path == "-") return "-";
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) return fmt::format("{}:{}", status.st_dev, status.st_ino);
  return by_name(path);
}

std::string LocationKeys::by_name(const fs::path& path) {
  return fmt::format("{}/{}", folder(path.parent_path().string()), path.filename().string());
}

const std::string& LocationKeys::folder(const std::string& name) {
  const auto [known, fresh] = folders_.try_emplace(name);
  if (fresh) {
    std::error_code none;
    const fs::path absolute = fs::absolute(name.empty() ? "." : name, none);
    fs::path canonical = fs::weakly_canonical(absolute, none);
    if (none) canonical = absolute.lexically_normal();
    if (!canonical.has_filename()) canonical = canonical.parent_path();  // the path ended with a slash
    known->second = canonical.string();
  }
  return known->second;
}

}  // namespace isoextract::files
