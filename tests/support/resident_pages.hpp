// Tells which pages of a mapping are in the memory of this process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

namespace isoextract::test {

// Returns for each page from `begin` on whether it is in this process's memory: bit 63 of its entry in pagemap. Returns
// nothing if the system does not tell.
inline std::vector<bool> resident_pages(const void* begin, std::size_t pages) {
  const auto page_size = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const int file = ::open("/proc/self/pagemap", O_RDONLY | O_CLOEXEC);
  std::vector<std::uint64_t> entries(pages);
  const std::size_t bytes = pages * sizeof(std::uint64_t);
  const auto at = static_cast<off_t>(reinterpret_cast<std::uintptr_t>(begin) / page_size * sizeof(std::uint64_t));
  const bool is_known = file >= 0 && ::pread(file, entries.data(), bytes, at) == static_cast<ssize_t>(bytes);
  if (file >= 0) ::close(file);
  std::vector<bool> result;
  if (!is_known) return result;
  for (const std::uint64_t entry : entries) result.push_back((entry >> 63) != 0);
  return result;
}

}  // namespace isoextract::test
