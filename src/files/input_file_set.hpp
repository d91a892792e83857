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
  // Adds an input; "-" adds the file or pipe of standard input. `what` is the input's role in messages: "is the input".
  // The first role of a file stays. Ignores files that do not exist.
  void add(const std::filesystem::path& file, const std::string& what);

  // Fails with ErrorCode::usage if `written` is one of the inputs under any name or link. "-" (standard output) passes.
  [[nodiscard]] Result<void> check(const std::filesystem::path& written) const;

 private:
  std::map<std::pair<dev_t, ino_t>, std::string> files_;
};

}  // namespace isoextract::files
