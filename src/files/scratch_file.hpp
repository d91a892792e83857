// A temporary file for data that the memory limit does not hold, mapped into memory. The system keeps the pages in use
// and writes the others to the disk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace isoextract::files {

namespace detail {
struct MappedRange;
}

// Has no name in any file system, so the system frees it when the process ends, however it ends. Owns its disk space.
class ScratchFile {
 public:
  // Makes a file of `bytes` bytes, filled with zeros, in the folder for temporary files, and takes its disk space.
  // std::filesystem::temp_directory_path() gives the folder: the environment variable TMPDIR, TMP, TEMP or TEMPDIR,
  // else /tmp. Returns the reason if the folder has too little space, cannot be written, or is in memory (tmpfs).
  [[nodiscard]] static tl::expected<ScratchFile, std::string> make(std::uint64_t bytes);

  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&&) = delete;
  ~ScratchFile();

  // Returns all bytes, at the start of a page; writable until protect().
  [[nodiscard]] std::span<std::byte> bytes() const { return {pages_, length_}; }
  // Makes the bytes read-only.
  void protect();
  // Returns whether the disk could not give or take some bytes, which are then 0. Call it after each use of the bytes
  // that counts.
  [[nodiscard]] bool lost() const;

 private:
  ScratchFile(std::span<std::byte> pages, int descriptor);

  std::byte* pages_ = nullptr;
  std::size_t length_ = 0;  // 0 after a move
  int descriptor_ = -1;
  bool is_layered_ = false;  // on overlayfs, as in containers
  detail::MappedRange* range_ = nullptr;
};

}  // namespace isoextract::files
