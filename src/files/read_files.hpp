// What a run reads, so that nothing that it writes takes its place.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "base/error.hpp"

namespace isoextract::files {

class ReadFiles {
 public:
  // `what` it does stands in messages: "is the input". "-" is what standard input is; what is not there is left out.
  void add(const std::filesystem::path& file, const std::string& what);

  // Fails with ErrorCode::usage where `written` is one of them on the disk, whatever names and links lead there.
  [[nodiscard]] Result<void> check(const std::filesystem::path& written) const;

 private:
  std::map<std::pair<dev_t, ino_t>, std::string> files_;
};

}  // namespace isoextract::files
