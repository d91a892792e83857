#include "cli/output_folders.hpp"

#include <set>

#include <fmt/format.h>

#include "files/output_file.hpp"

namespace isoextract::cli {

namespace fs = std::filesystem;

bool is_folder(const std::string& output) {
  std::error_code none;
  return output.ends_with('/') || fs::is_directory(output, none);
}

Result<void> check_or_make_folders(std::span<const fs::path> files, bool make) {
  std::set<fs::path> folders;
  for (const fs::path& file : files) folders.insert(file.parent_path());
  for (const fs::path& folder : folders) {
    if (folder.empty() || files::is_there(folder)) continue;
    if (!make) {
      return fail(ErrorCode::output, fmt::format("{}: there is no such folder", folder.string()),
                  "make the folder, or give --mkdir");
    }
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) {
      return fail(ErrorCode::output, fmt::format("{}: cannot make the folder: {}", folder.string(), error.message()));
    }
  }
  return {};
}

}  // namespace isoextract::cli
