// Keeps input files open during the work in a context, so that probing, reading and hashing open a file once. After the
// path was given to another file, or the file was written to, the next open() opens the path anew.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "files/file_version.hpp"

namespace isoextract::files {

class ParkedStreams;  // parked_streams.hpp
class UnpackedFiles;  // unpacked_files.hpp

// Owns its descriptor and closes it.
struct OpenFile {
  OpenFile() = default;
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile();

  int descriptor = -1;
  FileVersion version;  // at the time of opening
};

// Holds the kMost files opened last. Safe to use from several threads.
class OpenedFiles {
 public:
  static constexpr std::size_t kMost = 8;

  // find() also searches `before`, which may be null, and does not change it.
  explicit OpenedFiles(std::shared_ptr<OpenedFiles> before) : before_(std::move(before)) {}

  // Returns the open file that the path names now, if it was not written to since it was opened; else null.
  [[nodiscard]] std::shared_ptr<const OpenFile> find(const std::filesystem::path& path) const;
  void add(std::shared_ptr<const OpenFile> file);

  // Returns the files unpacked from this version of a file; also searches `before`. Null if there are none.
  [[nodiscard]] std::shared_ptr<const UnpackedFiles> find_unpacked(const FileVersion& version) const;
  void keep_unpacked(const FileVersion& version, std::shared_ptr<const UnpackedFiles> unpacked);

  // Sets the streams that readers of this table may keep; null: none.
  void keep_streams(std::shared_ptr<ParkedStreams> streams);
  // Returns the streams of this table, else the streams of `before`; null if there are none.
  [[nodiscard]] std::shared_ptr<ParkedStreams> streams() const;

 private:
  [[nodiscard]] std::shared_ptr<const OpenFile> find(const FileVersion& version) const;

  std::shared_ptr<OpenedFiles> before_;
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<const OpenFile>> files_;  // most recent last
  std::shared_ptr<ParkedStreams> streams_;
  std::vector<std::pair<FileVersion, std::shared_ptr<const UnpackedFiles>>> unpacked_;
};

// Returns the table of the context; makes it if there is none.
[[nodiscard]] std::shared_ptr<OpenedFiles> opened_files_of(const Context& context);

}  // namespace isoextract::files
