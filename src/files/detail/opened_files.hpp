// Keeps input files open during the work in a context, so that probing, reading and hashing use the same file even if
// its name is given to another one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "files/file_version.hpp"

namespace isoextract::files {

// Owns its descriptor and closes it.
struct OpenFile {
  OpenFile() = default;
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile();

  int descriptor = -1;
  FileVersion version;  // at the time of opening
};

// The kMost files opened last. Safe to use from several threads.
class OpenedFiles {
 public:
  static constexpr std::size_t kMost = 8;

  // Also searches `before`, without changing it; may be null.
  explicit OpenedFiles(std::shared_ptr<OpenedFiles> before) : before_(std::move(before)) {}

  // Returns the open file that the path names now, if it was not written to since it was opened; else null.
  [[nodiscard]] std::shared_ptr<const OpenFile> find(const std::filesystem::path& path) const;
  void add(std::shared_ptr<const OpenFile> file);

 private:
  [[nodiscard]] std::shared_ptr<const OpenFile> find(const FileVersion& version) const;

  std::shared_ptr<OpenedFiles> before_;
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<const OpenFile>> files_;  // most recent last
};

}  // namespace isoextract::files
