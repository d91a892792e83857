// Detects whether a file was written to.
#pragma once

#include <cstdint>

#include <filesystem>
#include <optional>

#include "base/error.hpp"

struct stat;

namespace isoextract::files {

class InputFile;

// Identifies one version of a file by its metadata. Two writes within one tick of the system's clock may give the same
// version (is_reliable()).
struct FileVersion {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  // nanoseconds since 1970
  std::int64_t changed = 0;   // time of the last change of the inode (ctime): no program can set it back

  // Returns whether any later write will give a different version. A write soon after the last one may fall into the
  // same clock tick, so returns false for 100 ms after the last change; for 2 s on file systems that store whole
  // seconds.
  [[nodiscard]] bool is_reliable() const;

  friend bool operator==(const FileVersion&, const FileVersion&) = default;
};

// Returns the version of the file that the path names; nothing if it is not a regular file or stat() fails.
[[nodiscard]] std::optional<FileVersion> version_of(const std::filesystem::path& path);
// Returns the version from the result of stat() or fstat().
[[nodiscard]] FileVersion version_of(const struct ::stat& status);

// Returns the current version of an open file. Fails with ErrorCode::input if fstat() fails.
[[nodiscard]] Result<FileVersion> version_of(const InputFile& file);

// Fails with ErrorCode::input if size or modification time differ from `before`, or if fstat() fails; for readers that
// make two passes. Ignores `changed`: renaming or unlinking the file sets it as well.
[[nodiscard]] Result<void> check_unchanged(const InputFile& file, const FileVersion& before);

}  // namespace isoextract::files
