#include "files/mapped_file.hpp"

#include <utility>

#include <sys/mman.h>
#include <unistd.h>

#include "files/detail/mapped_ranges.hpp"

namespace isoextract::files {

std::optional<MappedFile> MappedFile::map(const InputFile& file, std::uint64_t offset, std::uint64_t bytes) {
  if (bytes == 0 || offset > file.size() || bytes > file.size() - offset) return std::nullopt;
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const std::uint64_t lead = offset % page;
  const std::uint64_t length = lead + bytes;
  void* pages = ::mmap(nullptr, length, PROT_READ, MAP_PRIVATE, file.descriptor(), static_cast<off_t>(offset - lead));
  if (pages == MAP_FAILED) return std::nullopt;
  MappedFile mapped(pages, lead, length);
  static_cast<void>(::madvise(pages, length, MADV_SEQUENTIAL));
  mapped.range_ = detail::watch_range(pages, length);
  file.add_bytes_read(bytes);
  return mapped;
}

MappedFile::MappedFile(void* pages, std::size_t lead, std::size_t length)
    : pages_(pages), lead_(lead), length_(length) {}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : pages_(other.pages_), lead_(other.lead_), length_(std::exchange(other.length_, 0)), range_(other.range_) {}

MappedFile::~MappedFile() {
  if (length_ == 0) return;
  if (range_ != nullptr) detail::unwatch_range(range_);
  ::munmap(pages_, length_);
}

const std::atomic<bool>& MappedFile::lost() const { return range_->lost; }

}  // namespace isoextract::files
