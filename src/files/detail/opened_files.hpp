// Input files that stay open while work goes on in a context: what was probed, what is read and what is hashed is one
// file, whatever gets its name meanwhile.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "files/file_version.hpp"

namespace isoextract::files {

// Closes its descriptor.
struct OpenFile {
  OpenFile() = default;
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile();

  int descriptor = -1;
  FileVersion version;  // when it was opened
};

// The files that were opened last, of which kMost stay open. Used by several threads.
class OpenedFiles {
 public:
  static constexpr std::size_t kMost = 8;

  // `before` is searched as well, and stays as it is; null: there is none.
  explicit OpenedFiles(std::shared_ptr<OpenedFiles> before) : before_(std::move(before)) {}

  // The open file that the path names now, if nobody has written to it since it was opened; else null.
  [[nodiscard]] std::shared_ptr<const OpenFile> find(const std::filesystem::path& path) const;
  void add(std::shared_ptr<const OpenFile> file);

 private:
  [[nodiscard]] std::shared_ptr<const OpenFile> find(const FileVersion& version) const;

  std::shared_ptr<OpenedFiles> before_;
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<const OpenFile>> files_;  // the last one last
};

}  // namespace isoextract::files
