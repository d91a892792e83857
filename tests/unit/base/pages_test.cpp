#include "base/pages.hpp"

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "support/temp_folder.hpp"

namespace isoextract::test {
namespace {

// Returns for each page whether it is in this process's memory: bit 63 of its entry in pagemap.
std::vector<bool> present(const char* begin, std::size_t pages, std::size_t page_size) {
  const int file = ::open("/proc/self/pagemap", O_RDONLY | O_CLOEXEC);
  std::vector<std::uint64_t> entries(pages);
  const std::size_t bytes = pages * sizeof(std::uint64_t);
  const auto at = static_cast<off_t>(reinterpret_cast<std::uintptr_t>(begin) / page_size * sizeof(std::uint64_t));
  const bool known = file >= 0 && ::pread(file, entries.data(), bytes, at) == static_cast<ssize_t>(bytes);
  if (file >= 0) ::close(file);
  std::vector<bool> result;
  for (const std::uint64_t entry : entries) result.push_back((entry >> 63) != 0);
  return known ? result : std::vector<bool>();
}

TEST(Pages, GivesBackWholePagesAndReadsThemAgain) {
  const auto page_size = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  constexpr std::size_t kPages = 40;
  std::string bytes(kPages * page_size, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i % 251);
  const TempFolder folder;
  write_bytes(folder / "pages", bytes);
  const int file = ::open((folder / "pages").c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(file, 0);
  void* mapping = ::mmap(nullptr, bytes.size(), PROT_READ, MAP_PRIVATE, file, 0);
  ::close(file);
  ASSERT_NE(mapping, MAP_FAILED);
  const char* begin = static_cast<const char*>(mapping);
  EXPECT_EQ(std::memcmp(begin, bytes.data(), bytes.size()), 0);

  release_pages(begin + 4 * page_size + 1, 30 * page_size);      // ends within page 34
  release_pages(begin + 36 * page_size + 1, 2 * page_size - 2);  // holds no whole page
  release_pages(begin, 0);
  const std::vector<bool> held = present(begin, kPages, page_size);
  for (std::size_t page = 0; page < held.size(); ++page) EXPECT_EQ(held[page], page < 5 || page >= 34) << page;
  EXPECT_EQ(std::memcmp(begin, bytes.data(), bytes.size()), 0);
  ::munmap(mapping, bytes.size());
}

}  // namespace
}  // namespace isoextract::test
