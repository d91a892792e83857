#include "files/input_file_set.hpp"

#include <sys/stat.h>

#include <fmt/format.h>

#include "files/file_bytes.hpp"

namespace isoextract::files {

void InputFileSet::add(const std::filesystem::path& file, const std::string& what) {
  struct stat status {};
  const std::filesystem::path path = is_standard_input(file.string()) ? "/dev/stdin" : file;
  if (::stat(path.c_str(), &status) == 0) files_.try_emplace({status.st_dev, status.st_ino}, what);
}

Result<void> InputFileSet::check(const std::filesystem::path& written) const {
  struct stat status {};
  if (written == "-" || ::stat(written.c_str(), &status) != 0) return {};
  const auto found = files_.find({status.st_dev, status.st_ino});
  if (found == files_.end()) return {};
  return fail(ErrorCode::usage, fmt::format("{}: this {}; it is not overwritten", written.string(), found->second),
              "choose another name for the output");
}

}  // namespace isoextract::files
