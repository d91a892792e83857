#include "sandbox/shared_memory.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <limits>

namespace isoextract::sandbox {

std::optional<SharedMemory> SharedMemory::create(std::uint64_t bytes) {
  if (bytes > static_cast<std::uint64_t>(std::numeric_limits<off_t>::max())) return std::nullopt;
  Descriptor descriptor(::memfd_create("isoextract", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!descriptor.is_open() || ::ftruncate(descriptor.get(), static_cast<off_t>(bytes)) != 0) return std::nullopt;
  if (::fcntl(descriptor.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) return std::nullopt;
  return SharedMemory(std::move(descriptor), bytes);
}

Mapping::Mapping(int descriptor, std::uint64_t bytes, Access access) {
  if (bytes == 0) return;
  const int protection = access == Access::read ? PROT_READ : PROT_READ | PROT_WRITE;
  // Populates all pages at once, which is faster than a page fault for each.
  void* start = ::mmap(nullptr, static_cast<std::size_t>(bytes), protection, MAP_SHARED | MAP_POPULATE, descriptor, 0);
  if (start != MAP_FAILED) bytes_ = {static_cast<std::byte*>(start), static_cast<std::size_t>(bytes)};
}

Mapping::~Mapping() {
  if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
}

}  // namespace isoextract::sandbox
