// Whether a file is still the one that it was.
#pragma once

#include <cstdint>

#include <filesystem>
#include <optional>

#include "base/error.hpp"

struct stat;

namespace isoextract::files {

class InputFile;

// Tells a file that was written to from the one it was, as far as the system's clock does.
struct FileVersion {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  // nanoseconds since 1970
  std::int64_t changed = 0;   // likewise, its entry too: nobody can set this one back

  // Whether the next write will give another version: one that follows at once may fall into the same tick of the
  // clock, of 2 s where a file system keeps whole seconds.
  [[nodiscard]] bool is_settled() const;

  friend bool operator==(const FileVersion&, const FileVersion&) = default;
};

// What the path names now; nothing where that is no regular file, or cannot be told.
[[nodiscard]] std::optional<FileVersion> version_of(const std::filesystem::path& path);
// What the system tells of an open file, or of one by its name.
[[nodiscard]] FileVersion version_of(const struct ::stat& status);

// What the file is now. Fails with ErrorCode::input where the system does not tell.
[[nodiscard]] Result<FileVersion> version_of(const InputFile& file);

// Fails with ErrorCode::input where the file was written to since it was `before`; for readers that go through it
// twice.
[[nodiscard]] Result<void> check_unchanged(const InputFile& file, const FileVersion& before);

}  // namespace isoextract::files
