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

// Takes the disk space and maps the file. Returns why that failed; "" if it did not.
std::string map_whole(int descriptor, std::uint64_t bytes, void*& pages) {
  if (is_in_memory(descriptor)) return "it is in memory (tmpfs)";
  if (bytes > static_cast<std::uint64_t>(std::numeric_limits<off_t>::max())) return "files cannot be that large";
  // A sparse file could end the process (SIGBUS) once the disk is full.
  const int error = ::posix_fallocate(descriptor, 0, static_cast<off_t>(bytes));
  if (error != 0) return std::generic_category().message(error);
  pages = ::mmap(nullptr, static_cast<std::size_t>(bytes), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  return pages == MAP_FAILED ? std::generic_category().message(errno) : "";
}

}  // namespace

tl::expected<ScratchFile, std::string> ScratchFile::make(std::uint64_t bytes) {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  std::string failure = error ? error.message() : "";
  void* pages = nullptr;
  if (!error) {
    std::string name = folder / "isoextract-scratch-XXXXXX";
    const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor < 0) {
      failure = std::generic_category().message(errno);
    } else {
      ::unlink(name.c_str());
      failure = map_whole(descriptor, bytes, pages);
      ::close(descriptor);
    }
  }
  if (failure.empty()) return ScratchFile({static_cast<std::byte*>(pages), static_cast<std::size_t>(bytes)});
  return tl::unexpected(fmt::format("a temporary file of {} in {} failed: {}", format_byte_size(bytes),
                                    folder.empty() ? "the folder for temporary files" : folder.string(), failure));
}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : pages_(other.pages_), length_(std::exchange(other.length_, 0)), range_(other.range_) {}

ScratchFile::~ScratchFile() {
  if (length_ == 0) return;
  if (range_ != nullptr) detail::unwatch_range(range_);
  ::munmap(pages_, length_);
}

void ScratchFile::protect() {
  static_cast<void>(::mprotect(pages_, length_, PROT_READ));
  range_ = detail::watch_range(pages_, length_);
}

const std::atomic<bool>& ScratchFile::lost() const { return range_->lost; }

}  // namespace isoextract::files
