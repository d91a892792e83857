// A temporary file for data that the memory limit does not hold, mapped into memory. The system keeps the pages in use
// and writes the others to the disk.
#pragma once

#include <atomic>
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
  // Makes a file of `bytes` bytes, filled with zeros, in the folder for temporary files (the environment variable
  // TMPDIR, else /tmp), and takes its disk space. Returns the reason if the folder has too little space, cannot be
  // written, or is in memory (tmpfs).
  [[nodiscard]] static tl::expected<ScratchFile, std::string> make(std::uint64_t bytes);

  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&&) = delete;
  ~ScratchFile();

  // Returns all bytes, at the start of a page; writable until protect().
  [[nodiscard]] std::span<std::byte> bytes() const { return {pages_, length_}; }
  // Makes the bytes read-only. From now on, bytes that the disk cannot give become 0, and lost() becomes true. May
  // throw std::bad_alloc.
  void protect();
  // Returns the flag of lost bytes, which lives as long as the mapping. Call protect() first.
  [[nodiscard]] const std::atomic<bool>& lost() const;

 private:
  explicit ScratchFile(std::span<std::byte> pages) : pages_(pages.data()), length_(pages.size()) {}

  std::byte* pages_ = nullptr;
  std::size_t length_ = 0;  // 0 after a move
  detail::MappedRange* range_ = nullptr;
};

}  // namespace isoextract::files
