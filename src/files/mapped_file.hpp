// Maps a range of a file into memory: the system pages it in and out, and nothing is copied.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "files/file_bytes.hpp"

namespace isoextract::files {

namespace detail {
struct MappedRange;
}

// A read-only mapping. The content stays alive if the file is removed or replaced by a rename. If the file is written
// to in place, the mapped memory changes.
//
// If the file is truncated or its disk fails, the first access to a missing page replaces it and all later pages of
// the range by zeros, and lost() becomes true. Check lost() after working on the memory, and discard the results if it
// is set. A truncation that keeps all mapped pages is not noticed, as the system fills the rest of the last page with
// zeros. Needs a SIGBUS handler, which the first mapping installs; it forwards signals that do not concern a mapping.
class MappedFile {
 public:
  // Maps a range of the file. Returns nothing if the range is empty or exceeds the file, or if the system cannot map
  // it; reading the range then gives the error, if there is one. Advises the system of sequential access. Counts the
  // range as read. The file may be closed afterwards. May throw std::bad_alloc.
  [[nodiscard]] static std::optional<MappedFile> map(const InputFile& file, std::uint64_t offset, std::uint64_t bytes);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile();

  // Returns the address of the first byte of the range. The address is aligned as the range's offset in the file is,
  // but at most to a page.
  [[nodiscard]] const std::byte* data() const { return static_cast<const std::byte*>(pages_) + lead_; }

  // Returns a flag that is set if some of the data was missing. It lives as long as the mapping.
  [[nodiscard]] const std::atomic<bool>& lost() const;

 private:
  MappedFile(void* pages, std::size_t lead, std::size_t length);

  void* pages_ = nullptr;                 // start of the mapping, at a page of the file
  std::size_t lead_ = 0;                  // bytes from pages_ to the range
  std::size_t length_ = 0;                // bytes from pages_ to the end of the range; 0 without a mapping
  detail::MappedRange* range_ = nullptr;  // null until the range is watched
};

}  // namespace isoextract::files
