// Output that is whole or not there: bytes go to an unnamed file in the target's folder, and only commit() gives them
// the target's name. Destroying an OutputFile that was not committed leaves nothing behind.
//
// What is promised: whoever opens the target sees the old file or the whole new one, also if this process fails, is
// killed or runs out of space. Not promised: that a committed file survives a power cut. The data is not forced to the
// disk, which would cost as much as writing it again.
// On file systems without unnamed files (O_TMPFILE) the bytes go to a file `.isoextract-HOST-PID-N` beside the target,
// which is removed when this process ends in any way but SIGKILL or a crash; what those leave behind, the next process
// of the same user and machine removes that writes into that folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract::files {

// Takes away the regular file that an OutputFile of this name would replace, through symbolic links. False where there
// is none: nothing, a folder, a device or a pipe, standard output. Fails with ErrorKind::output.
[[nodiscard]] Result<bool> remove_old_file(const std::filesystem::path& path);

// Whether what is written to both would come to one place, be it a file, a pipe or a device, by whatever names ("-" is
// standard output), and would not be lost there (/dev/null). Files that do not exist are compared by their names.
[[nodiscard]] bool same_place(const std::filesystem::path& a, const std::filesystem::path& b);

class OutputFile {
 public:
  // `path` may name a regular file (replaced on commit, through symbolic links, with its permission bits), something
  // that does not exist yet (made with the permissions the umask leaves), or a device or pipe (written directly).
  // "-" is standard output; SIGPIPE must be ignored for a closed pipe to be an error. Fails with ErrorKind::output.
  [[nodiscard]] static Result<OutputFile> create(const std::filesystem::path& path);

  OutputFile(OutputFile&&) noexcept;
  OutputFile& operator=(OutputFile&&) noexcept;
  ~OutputFile();

  // Buffered; large spans go to the system without a copy. After a failure every later call fails alike.
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> write(std::string_view text);

  [[nodiscard]] std::uint64_t bytes_written() const;

  // What messages call it: the path, or "standard output".
  [[nodiscard]] const std::string& shown_name() const;

  // Flushes and gives the file its name. Call once, last.
  [[nodiscard]] Result<void> commit();

  // Commits two files of which `last` refers to `first`. All that can fail for want of space or permission is done
  // before either gets its name; `first` gets it first. If `last` then cannot get its own, `first` loses it again, and
  // a file that it replaced is put back (where the file system has hard links). A process killed between the two
  // renames leaves the new `first` beside the old `last`.
  [[nodiscard]] static Result<void> commit_pair(OutputFile& first, OutputFile& last);

  // Removes what this process has not committed; nothing can be written after it. For handlers of signals that end the
  // process: async-signal-safe.
  static void remove_unfinished() noexcept;

 private:
  struct State;
  explicit OutputFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::files
