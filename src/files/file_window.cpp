#include "files/file_window.hpp"

#include <utility>

#include <sys/mman.h>
#include <unistd.h>

#include "files/detail/mapped_ranges.hpp"

namespace isoextract::files {

std::optional<FileWindow> FileWindow::make(const InputFile& file, std::uint64_t room) {
  // A part may begin anywhere in its first page.
  const std::uint64_t length = room + static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  void* pages = ::mmap(nullptr, length, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (pages == MAP_FAILED) return std::nullopt;
  FileWindow window(file, static_cast<std::byte*>(pages), length);
  window.range_ = detail::watch_range(pages, length);
  return window;
}

FileWindow::FileWindow(InputFile file, std::byte* pages, std::size_t length)
    : file_(std::move(file)), pages_(pages), length_(length) {}

FileWindow::FileWindow(FileWindow&& other) noexcept
    : file_(std::move(other.file_)),
      pages_(other.pages_),
      length_(std::exchange(other.length_, 0)),
      range_(std::exchange(other.range_, nullptr)) {}

FileWindow::~FileWindow() {
  if (range_ != nullptr) detail::unwatch_range(range_);
  if (length_ != 0) ::munmap(pages_, length_);
}

const std::byte* FileWindow::move_to(std::uint64_t offset, std::uint64_t bytes) {
  const std::uint64_t lead = offset % static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const std::uint64_t mapped = lead + bytes;
  if (mapped > length_) return nullptr;
  if (::mmap(pages_, mapped, PROT_READ, MAP_PRIVATE | MAP_FIXED, file_.descriptor(),
             static_cast<off_t>(offset - lead)) == MAP_FAILED) {
    // The addresses may be free now, and soon in use by others: this object may not unmap them.
    length_ = 0;
    detail::unwatch_range(std::exchange(range_, nullptr));
    return nullptr;
  }
  static_cast<void>(::madvise(pages_, mapped, MADV_SEQUENTIAL));
  return pages_ + lead;
}

bool FileWindow::lost() const { return range_ != nullptr && range_->lost.load(std::memory_order_acquire); }

}  // namespace isoextract::files
