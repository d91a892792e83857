// A range of a file as memory: nothing is copied, and the system may drop its pages and read them again.
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

// A read-only mapping. It keeps the file's content alive where the file is removed or replaced by a rename. If the
// file is written to in place meanwhile, the memory changes.
//
// Where the file was cut off, or its disk fails, what is missing reads as zeros from then on, and lost() tells so: who
// works on the memory asks when the work is done, and throws away what came of it. (The system itself fills the last
// page that a shorter file still has with zeros; a cut that leaves all pages is not noticed.) This is done by a handler
// of SIGBUS that the first mapping installs. It passes on what is not about a mapping.
class MappedFile {
 public:
  // Nothing where the range is not all in the file (nor empty), or where the system cannot map it: reading it then says
  // what is wrong, if anything is. The system is told that the range will be walked through from its start on. The
  // range counts as read.
  [[nodiscard]] static std::optional<MappedFile> map(const InputFile& file, std::uint64_t offset, std::uint64_t bytes);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile();

  // The byte at the range's offset; aligned as that offset is, up to a page.
  [[nodiscard]] const std::byte* data() const { return static_cast<const std::byte*>(pages_) + lead_; }

  // Set when something was missing. It lives as long as the mapping.
  [[nodiscard]] const std::atomic<bool>& lost() const;

 private:
  MappedFile(void* pages, std::size_t lead, std::size_t length);

  void* pages_ = nullptr;                 // from a page of the file on
  std::size_t lead_ = 0;                  // from there to the range
  std::size_t length_ = 0;                // from pages_ to the range's end; 0 where there is no mapping
  detail::MappedRange* range_ = nullptr;  // null until it is watched
};

}  // namespace isoextract::files
