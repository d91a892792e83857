// Atomic output: bytes go to an unnamed file in the target's folder, and only commit() gives it the target's name.
// Destroying an OutputFile that was not committed leaves nothing behind.
//
// Guarantee: anyone who opens the target sees the old file or the whole new one, even if this process fails, is killed
// or runs out of space. No guarantee: a committed file may be lost in a power failure. Forcing the data to disk would
// cost as much as writing it again.
//
// On file systems without unnamed files (O_TMPFILE) the bytes go to `.isoextract-HOST-PID-N` in the target's folder. On
// file systems with unnamed files, commit() gives the file such a name briefly, before the rename to the target. The
// name is removed when this process ends, except by SIGKILL or a crash. Then, if the file system has locks, the next
// process of the same user and machine that writes into the folder removes it.
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

// Returns the name of an output for messages.
[[nodiscard]] std::string output_label(const std::filesystem::path& path);

// Removes the regular file that an OutputFile of this name would replace; follows symbolic links to it. Returns false
// if there is none: no file, a folder, a device, a pipe or standard output. Fails with ErrorCode::output.
[[nodiscard]] Result<bool> remove_old_file(const std::filesystem::path& path);

// Renames the regular file that an OutputFile of this name would replace. The new name is NAME.old or, if that exists,
// NAME.old.2 and so on up to NAME.old.1000. Returns the new path, or nothing if there is no file to rename. Fails with
// ErrorCode::output.
[[nodiscard]] Result<std::optional<std::filesystem::path>> rename_old_file(const std::filesystem::path& path);

// Returns whether the path is standard output, a pipe or a device: bytes written there cannot be taken back.
[[nodiscard]] bool is_stream(const std::filesystem::path& path);

// Returns whether both paths write to the same file, pipe or device, under whatever names ("-" is standard output).
// Returns false for places that discard data (/dev/null). If one of the paths does not exist, compares the absolute
// paths after resolving links.
[[nodiscard]] bool is_same_output(const std::filesystem::path& a, const std::filesystem::path& b);

// Returns whether anything exists at the path, after following symbolic links. Returns false if the system cannot tell.
[[nodiscard]] bool is_there(const std::filesystem::path& path);

class OutputFile {
 public:
  // Opens an output. `path` may be a regular file (replaced on commit, through symbolic links, keeping its permission
  // bits), a new name (permissions from the umask), or a device or pipe (written directly). "-" is standard output;
  // SIGPIPE must be ignored so that a closed pipe is reported as an error. Fails with ErrorCode::output.
  [[nodiscard]] static Result<OutputFile> create(const std::filesystem::path& path);

  // Creates a regular file that several ranks (base/ranks.hpp) write, each a part of it. Rank 0 creates and commits the
  // file. The other ranks join it by the name that shared_name() returns at rank 0, and then make the same calls.
  // There, write() and extend() only count bytes, which rank 0 writes. fill() writes the given bytes; commit() closes
  // the file; resize(), overwrite() and move_end() fail. All ranks must see one file system, and rank 0 commits last.
  [[nodiscard]] static Result<OutputFile> create_shared(const std::filesystem::path& path);
  [[nodiscard]] static Result<OutputFile> join(const std::filesystem::path& path, const std::string& shared_name);
  [[nodiscard]] std::string shared_name() const;

  OutputFile(OutputFile&&) noexcept;
  OutputFile& operator=(OutputFile&&) noexcept;
  ~OutputFile();

  // Appends bytes. Buffered; large spans go to the system without a copy. After a failure every later call but fill()
  // fails with the same error.
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> write(std::string_view text);

  // extend(), resize(), overwrite() and move_end() need a regular file; they fail for a device, a pipe or standard
  // output, which cannot be rewritten.
  //
  // Makes room for `count` bytes at the end and returns the file offset of the first. Fill all of it with fill().
  [[nodiscard]] Result<std::uint64_t> extend(std::uint64_t count);
  // Gives the file this size: cuts its end off, or makes room there as extend() does.
  [[nodiscard]] Result<void> resize(std::uint64_t size);
  // Writes into room that extend() made, or behind the end before resize(), from file offset `place` on. Several
  // threads may fill disjoint ranges at once. Do not commit after a failure: commit() does not know of the failure.
  [[nodiscard]] Result<void> fill(std::uint64_t place, std::span<const std::byte> bytes) const;
  // Replaces bytes from file offset `place` on; the whole range must have been written already.
  [[nodiscard]] Result<void> overwrite(std::uint64_t place, std::span<const std::byte> bytes);
  // Moves all bytes from offset `from` on, so that they begin at offset `to`. If `to` is larger, the gap has undefined
  // content.
  [[nodiscard]] Result<void> move_end(std::uint64_t from, std::uint64_t to);

  // Hashes everything written from now on; call before the first byte.
  void keep_hash();
  // Returns the hash in the form of content_hash.hpp, or nothing without keep_hash(). After extend(), resize(),
  // overwrite() or move_end(), returns nothing until commit(), which then reads the whole file back.
  [[nodiscard]] std::optional<std::string> hash() const;

  [[nodiscard]] std::uint64_t bytes_written() const;

  // Returns the name for messages: the path, or "standard output".
  [[nodiscard]] const std::string& shown_name() const;

  // Flushes the buffer and gives the file its name. Call once, last.
  [[nodiscard]] Result<void> commit();

  // Commits files that belong together; a file may refer to earlier ones. First takes, for all files, every step that
  // can fail for lack of space or permission, then renames the files in order. If a rename fails, undoes the earlier
  // ones and restores the files that they replaced (if the file system has hard links). A process killed between two
  // renames leaves new files beside old ones.
  [[nodiscard]] static Result<void> commit_all(std::span<OutputFile* const> files);
  [[nodiscard]] static Result<void> commit_pair(OutputFile& first, OutputFile& last);

  // Removes the temporary files of this process; no regular file can be committed afterwards. Async-signal-safe, for
  // handlers of signals that end the process.
  static void remove_unfinished() noexcept;

 private:
  struct State;
  explicit OutputFile(std::unique_ptr<State> state);
  [[nodiscard]] static Result<OutputFile> open(const std::filesystem::path& path, bool is_shared);
  std::unique_ptr<State> state_;
};

// Creates a file with the given content and commits it.
[[nodiscard]] Result<void> write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace isoextract::files
