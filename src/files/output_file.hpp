// Output that is whole or not there: bytes go to an unnamed file in the target's folder, and only commit() gives them
// the target's name. Destroying an OutputFile that was not committed leaves nothing behind.
//
// What is promised: whoever opens the target sees the old file or the whole new one, also if this process fails, is
// killed or runs out of space. Not promised: that a committed file survives a power cut. The data is not forced to the
// disk, which would cost as much as writing it again.
// On file systems without unnamed files (O_TMPFILE) the bytes go to a file `.isoextract-HOST-PID-N` beside the target;
// elsewhere a file has such a name for the moment before it takes the target's. It is removed when this process ends in
// any way but SIGKILL or a crash; what those leave behind, the next process of the same user and machine removes that
// writes into that folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract::files {

// What messages call an output.
[[nodiscard]] std::string shown_output_name(const std::filesystem::path& path);

// Takes away the regular file that an OutputFile of this name would replace, through symbolic links. False where there
// is none: nothing, a folder, a device or a pipe, standard output. Fails with ErrorCode::output.
[[nodiscard]] Result<bool> remove_old_file(const std::filesystem::path& path);

// The same, but the file stays under another name: NAME.old or, where that is taken, NAME.old.2 and so on. Nothing
// where there is none.
[[nodiscard]] Result<std::optional<std::filesystem::path>> set_aside_old_file(const std::filesystem::path& path);

// Standard output, a pipe or a device: what was written there cannot be taken back.
[[nodiscard]] bool is_stream(const std::filesystem::path& path);

// Whether what is written to both would come to one place, be it a file, a pipe or a device, by whatever names ("-" is
// standard output), and would not be lost there (/dev/null). Files that do not exist are compared by their names.
[[nodiscard]] bool same_place(const std::filesystem::path& a, const std::filesystem::path& b);

// Whether a file, a folder or anything else has the name. False where that cannot be told.
[[nodiscard]] bool is_there(const std::filesystem::path& path);

class OutputFile {
 public:
  // `path` may name a regular file (replaced on commit, through symbolic links, with its permission bits), something
  // that does not exist yet (made with the permissions the umask leaves), or a device or pipe (written directly).
  // "-" is standard output; SIGPIPE must be ignored for a closed pipe to be an error. Fails with ErrorCode::output.
  [[nodiscard]] static Result<OutputFile> create(const std::filesystem::path& path);

  OutputFile(OutputFile&&) noexcept;
  OutputFile& operator=(OutputFile&&) noexcept;
  ~OutputFile();

  // Buffered; large spans go to the system without a copy. After a failure every later call fails alike.
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> write(std::string_view text);

  // Both are for regular files; a device, a pipe or standard output cannot take back what it got, and fails.
  // Puts `bytes` in the place of some that were written, all of which must be there.
  [[nodiscard]] Result<void> overwrite(std::uint64_t place, std::span<const std::byte> bytes);
  // Makes what was written from byte `from` on begin at byte `to`. Where that is later, the room holds anything.
  [[nodiscard]] Result<void> move_end(std::uint64_t from, std::uint64_t to);

  // Hashes what is written from now on; call before the first byte.
  void keep_hash();
  // As content_hash.hpp has it. Nothing without keep_hash(), and where bytes were changed after they were written.
  [[nodiscard]] std::optional<std::string> hash() const;

  [[nodiscard]] std::uint64_t bytes_written() const;

  // What messages call it: the path, or "standard output".
  [[nodiscard]] const std::string& shown_name() const;

  // Flushes and gives the file its name. Call once, last.
  [[nodiscard]] Result<void> commit();

  // Commits files that belong together; a later one may refer to those before it. All that can fail for want of space
  // or permission is done before any gets its name; then they get theirs in order. If one cannot get its own, those
  // before it lose theirs again, and files that they replaced are put back (where the file system has hard links). A
  // process killed between two renames leaves new files beside old ones.
  [[nodiscard]] static Result<void> commit_all(std::span<OutputFile* const> files);
  [[nodiscard]] static Result<void> commit_pair(OutputFile& first, OutputFile& last);

  // Removes what this process has not committed; nothing can be written after it. For handlers of signals that end the
  // process: async-signal-safe.
  static void remove_unfinished() noexcept;

 private:
  struct State;
  explicit OutputFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// A file whose content is there already: created, written and committed.
[[nodiscard]] Result<void> write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace isoextract::files
