// The files a run reads, to prevent its outputs from overwriting them.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "base/error.hpp"

namespace isoextract::files {

class InputFileSet {
 public:
  // Adds an input. `what` is the file's role in messages: "is the input". "-" is the file that standard input is, if
  // any. Ignores files that do not exist.
  void add(const std::filesystem::path& file, const std::string& what);

  // Fails with ErrorCode::usage if `written` is one of the inputs on disk, through whatever names and links.
  [[nodiscard]] Result<void> check(const std::filesystem::path& written) const;

 private:
  std::map<std::pair<dev_t, ino_t>, std::string> files_;
};

}  // namespace isoextract::files
