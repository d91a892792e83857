// Files unpacked from a compressed file or an archive. Their bytes stay in memory; links in a temporary folder give
// them paths that readers and child processes can open.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::files {

struct UnpackedMember {
  std::string name;  // relative path in the archive
  std::uint64_t bytes = 0;
};

class UnpackedFiles {
 public:
  // Splits `content` into the members, which follow one another in it, and stores each as a file in memory
  // (memfd_create). A temporary folder gets a symbolic link to each, in subfolders as their names state, without the
  // leading folders that all names share. Leaves out empty files and, without `as_file`, hidden files. With `as_file`
  // there has to be one member, and path() is its path; otherwise path() is the folder. `source` is the path of the
  // packed file.
  //
  // Fails with ErrorCode::input if no file is left, if a name leads out of the archive, or if a name occurs twice.
  // Fails with ErrorCode::unavailable if the system lacks memfd_create, if the process may not open more files, or if
  // there is no writable temporary folder. Fails as Context::reserve() and Context::check() do.
  [[nodiscard]] static Result<std::shared_ptr<const UnpackedFiles>> make(const std::filesystem::path& source,
                                                                         std::span<const UnpackedMember> members,
                                                                         std::span<const std::byte> content,
                                                                         bool as_file, const Context& context);
  UnpackedFiles(const UnpackedFiles&) = delete;
  UnpackedFiles& operator=(const UnpackedFiles&) = delete;
  ~UnpackedFiles();  // removes the folder

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  UnpackedFiles() = default;
  [[nodiscard]] Result<void> add(const std::filesystem::path& name, std::span<const std::byte> content);

  std::string source_;
  std::filesystem::path folder_;
  std::filesystem::path path_;
  std::vector<int> descriptors_;
  Reservation memory_;
};

// Returns the files that were unpacked from `file` in its context or an enclosing one; null if there are none, or if
// the file has changed since.
[[nodiscard]] std::shared_ptr<const UnpackedFiles> find_unpacked(const InputFile& file);
// Keeps the files for as long as the context of `file` lives.
void keep_unpacked(const InputFile& file, std::shared_ptr<const UnpackedFiles> unpacked);

// Returns the packed file or archive that the unpacked file or folder `path` came from; `path` itself if it was not
// unpacked.
[[nodiscard]] std::filesystem::path packed_source(const std::filesystem::path& path);

// Returns a file name without the ending of a compressed file (.gz, .xz, .zst, .bz2), so that the ending before it
// tells the format: "a.nii.xz" is "a.nii". Case does not matter.
[[nodiscard]] std::string name_without_packing(std::string name);

// Returns a path by which this process and its children can open the file; for standard input, a path in /proc.
[[nodiscard]] std::string openable_path(const InputFile& file);

}  // namespace isoextract::files
