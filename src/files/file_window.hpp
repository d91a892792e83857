// Maps parts of a file, one after another, at the same addresses: for files larger than the address space.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "files/file_bytes.hpp"

namespace isoextract::files {

namespace detail {
struct MappedRange;
}

// A read-only mapping of a part of a file, which move_to() replaces by another part. Takes no more address space than
// its room, and no memory but the pages in use. Handles files that are truncated, and failing disks, as MappedFile
// does. For one thread.
class FileWindow {
 public:
  // Returns a window in which parts of up to `room` bytes fit, without a part yet. Returns nothing if the system has no
  // address space for it. The file may be closed afterwards. May throw std::bad_alloc.
  [[nodiscard]] static std::optional<FileWindow> make(const InputFile& file, std::uint64_t room);

  FileWindow(FileWindow&& other) noexcept;
  FileWindow& operator=(FileWindow&&) = delete;
  ~FileWindow();

  // Maps a range of the file in place of the part before, whose addresses become invalid. Returns the address of its
  // first byte, aligned as MappedFile::data(); null if the system cannot map it: do not use the window afterwards.
  // Does not count the range as read.
  [[nodiscard]] const std::byte* move_to(std::uint64_t offset, std::uint64_t bytes);

  // Returns whether some of the data in this or in earlier parts was missing; false after move_to() returned null.
  [[nodiscard]] bool lost() const;

 private:
  FileWindow(InputFile file, std::byte* pages, std::size_t length);

  InputFile file_;
  std::byte* pages_;
  std::size_t length_;  // of the addresses from pages_ on; 0 without any
  detail::MappedRange* range_ = nullptr;
};

}  // namespace isoextract::files
