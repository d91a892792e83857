#include "files/scratch_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/mman.h>
#include <sys/vfs.h>
#include <unistd.h>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <mutex>
#include <system_error>
#include <utility>

#include "base/byte_size.hpp"
#include "files/detail/mapped_ranges.hpp"

namespace isoextract::files {
namespace {

namespace fs = std::filesystem;

bool is_in_memory(int descriptor) {
  struct statfs about {};
  if (::fstatfs(descriptor, &about) != 0) return false;
  return about.f_type == TMPFS_MAGIC || about.f_type == RAMFS_MAGIC;
}

bool is_on_overlay(int descriptor) {
  struct statfs about {};
  return ::fstatfs(descriptor, &about) == 0 && about.f_type == OVERLAYFS_SUPER_MAGIC;
}

// Takes the disk space and maps the file. Returns why that failed; "" if it did not.
std::string map_whole(int descriptor, std::uint64_t bytes, void*& pages) {
  if (is_in_memory(descriptor)) return "it is in memory (tmpfs)";
  if (bytes > static_cast<std::uint64_t>(std::numeric_limits<off_t>::max())) return "files cannot be that large";
  // A sparse file could end the process (SIGBUS) once the disk is full.
  int error = EINTR;
  while (error == EINTR) error = ::posix_fallocate(descriptor, 0, static_cast<off_t>(bytes));
  if (error != 0) return std::generic_category().message(error);
  pages = ::mmap(nullptr, static_cast<std::size_t>(bytes), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (pages == MAP_FAILED) return std::generic_category().message(errno);
  // The access to a byte would else bring up to 2 MiB around it into the memory of the process. Only advice.
  static_cast<void>(::madvise(pages, static_cast<std::size_t>(bytes), MADV_NOHUGEPAGE));
  return "";
}

}  // namespace

tl::expected<ScratchFile, std::string> ScratchFile::make(std::uint64_t bytes) {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  std::string failure = error ? error.message() : "";
  void* pages = nullptr;
  int descriptor = -1;
  if (!error) {
    std::string name = folder / "isoextract-scratch-XXXXXX";
    descriptor = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor < 0) {
      failure = std::generic_category().message(errno);
    } else {
      ::unlink(name.c_str());
      failure = map_whole(descriptor, bytes, pages);
    }
  }
  if (failure.empty())
    return ScratchFile({static_cast<std::byte*>(pages), static_cast<std::size_t>(bytes)}, descriptor);
  if (descriptor >= 0) ::close(descriptor);
  return tl::unexpected(fmt::format("a temporary file of {} in {} failed: {}", format_byte_size(bytes),
                                    folder.empty() ? "the folder for temporary files" : folder.string(), failure));
}

ScratchFile::ScratchFile(std::span<std::byte> pages, int descriptor)
    : pages_(pages.data()),
      length_(pages.size()),
      descriptor_(descriptor),
      is_layered_(is_on_overlay(descriptor)),
      range_(detail::watch_range(pages.data(), pages.size())) {}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : pages_(other.pages_),
      length_(std::exchange(other.length_, 0)),
      descriptor_(other.descriptor_),
      is_layered_(other.is_layered_),
      range_(other.range_) {}

ScratchFile::~ScratchFile() {
  if (length_ == 0) return;
  detail::unwatch_range(range_);
  ::munmap(pages_, length_);
  ::close(descriptor_);
}

void ScratchFile::protect() { static_cast<void>(::mprotect(pages_, length_, PROT_READ)); }

bool ScratchFile::lost() const {
  // The kernel drops a page that it cannot write, and reads zeros or older data from then on. It records the error
  // before that, and tells it once, for the whole file, so it is enough to wait for the first page. On overlayfs, only
  // the mapping leads to the file that has the error.
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  const int failed =
      is_layered_ ? ::msync(pages_, 1, MS_SYNC) : ::sync_file_range(descriptor_, 0, 1, SYNC_FILE_RANGE_WAIT_BEFORE);
  if (failed != 0 && errno != ENOSYS && errno != EINVAL) range_->lost.store(true, std::memory_order_release);
  return range_->lost.load(std::memory_order_acquire);
}

}  // namespace isoextract::files
