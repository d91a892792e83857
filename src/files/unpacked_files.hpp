// Files that were unpacked from a compressed file or an archive: they stay in memory, under paths of a temporary folder
// that readers and child processes can open.
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
  // Stores `content`, which has the members one after another, each as an anonymous file in memory. The temporary
  // folder has a symbolic link to each, in the folders that the names state. Leaves out a folder that all have in
  // common, and empty and hidden files. With `as_file` there has to be one member, which path() names; otherwise path()
  // is the folder. `source` is the path of the packed file.
  //
  // Fails with ErrorCode::input if no file is left, or for names that lead out of the archive or occur twice. Fails
  // with ErrorCode::unavailable if the system has no memory of this kind, no further file to open, or no temporary
  // folder; and as Context::reserve().
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

// Returns what was unpacked from a file in this context or an enclosing one; null if nothing was, or if the file has
// changed since.
[[nodiscard]] std::shared_ptr<const UnpackedFiles> find_unpacked(const InputFile& file);
// Keeps the files for as long as the context of `file` lives.
void keep_unpacked(const InputFile& file, std::shared_ptr<const UnpackedFiles> unpacked);

// Returns the file that was unpacked to `path`, or that has it as a member; `path` itself if it is no unpacked file.
[[nodiscard]] std::filesystem::path packed_source(const std::filesystem::path& path);

// Returns a file name without the ending of a compressed file (.gz, .xz, .zst, .bz2), so that the ending before it
// tells the format: "a.nii.xz" is "a.nii". Case does not matter.
[[nodiscard]] std::string name_without_packing(std::string name);

// Returns a path by which this process and its children can open the file: its own, or one in /proc for standard input.
[[nodiscard]] std::string openable_path(const InputFile& file);

}  // namespace isoextract::files
