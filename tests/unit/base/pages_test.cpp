#include "base/pages.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "support/resident_pages.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::test {
namespace {

// A mapped file that repeats the numbers 0 to 250.
class PagesOfFile : public testing::Test {
 protected:
  void map(std::size_t bytes) {
    content_.resize(bytes);
    for (std::size_t i = 0; i < bytes; ++i) content_[i] = static_cast<char>(i % 251);
    write_bytes(folder_ / "pages", content_);
    file_ = ::open((folder_ / "pages").c_str(), O_RDONLY | O_CLOEXEC);
    ASSERT_GE(file_, 0);
    mapping_ = ::mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, file_, 0);
    ASSERT_NE(mapping_, MAP_FAILED);
  }
  void TearDown() override {
    if (mapping_ != MAP_FAILED) ::munmap(mapping_, content_.size());
    if (file_ >= 0) ::close(file_);
  }

  [[nodiscard]] const char* begin() const { return static_cast<const char*>(mapping_); }

  // Returns how many bytes of [first, first + bytes) are in the system's cache of the file.
  [[nodiscard]] std::size_t cached(std::size_t first, std::size_t bytes) const {
    std::vector<unsigned char> pages(bytes / page_size_);
    if (::mincore(const_cast<char*>(begin()) + first, bytes, pages.data()) != 0) return 0;
    return page_size_ * static_cast<std::size_t>(std::ranges::count_if(pages, [](auto page) { return page & 1U; }));
  }

  // Removes the file from the system's cache. Returns false if the system keeps some of it.
  [[nodiscard]] bool drop_cached() const {
    ::madvise(mapping_, content_.size(), MADV_DONTNEED);
    ::fsync(file_);
    ::posix_fadvise(file_, 0, 0, POSIX_FADV_DONTNEED);
    return cached(0, content_.size()) == 0;
  }

  std::size_t page_size_ = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  std::string content_;
  TempFolder folder_;
  int file_ = -1;
  void* mapping_ = MAP_FAILED;
};

TEST_F(PagesOfFile, GivesBackWholePagesAndReadsThemAgain) {
  constexpr std::size_t kPages = 40;
  map(kPages * page_size_);
  EXPECT_EQ(std::memcmp(begin(), content_.data(), content_.size()), 0);

  release_pages(begin() + 4 * page_size_ + 1, 30 * page_size_);      // ends within page 34
  release_pages(begin() + 36 * page_size_ + 1, 2 * page_size_ - 2);  // holds no whole page
  release_pages(begin(), 0);
  const std::vector<bool> held = resident_pages(begin(), kPages);
  for (std::size_t page = 0; page < held.size(); ++page) EXPECT_EQ(held[page], page < 5 || page >= 34) << page;
  EXPECT_EQ(std::memcmp(begin(), content_.data(), content_.size()), 0);
}

TEST_F(PagesOfFile, AreRequestedAheadOfReadingOnce) {
  constexpr std::size_t kBlock = PageRequests::kBlock;
  constexpr std::size_t kAhead = PageRequests::kAhead;
  constexpr std::size_t kBytes = 3 * kAhead;
  constexpr std::size_t kStart = 100;  // the range begins within a page
  map(kBytes);
  // The system reads without being waited for.
  const auto becomes_cached = [&](std::size_t first, std::size_t bytes) {
    for (int tries = 0; tries < 500 && cached(first, bytes) < bytes; ++tries) ::usleep(10'000);
    return cached(first, bytes) == bytes;
  };
  // Pages that are still being read can neither be dropped nor be seen.
  const auto becomes_empty = [&] {
    for (int tries = 0; tries < 5; ++tries) {
      static_cast<void>(drop_cached());
      ::usleep(50'000);
    }
    return drop_cached();
  };
  if (!becomes_empty()) GTEST_SKIP() << "the system keeps the test file in its cache";
  ::madvise(mapping_, kBlock / 4, MADV_WILLNEED);
  if (!becomes_cached(0, kBlock / 4)) GTEST_SKIP() << "the file system does not take requests";
  ASSERT_TRUE(becomes_empty());

  PageRequests requests(begin() + kStart, kBytes - kStart);
  requests.come_to(begin() + kStart);
  EXPECT_TRUE(becomes_cached(0, kAhead));
  EXPECT_EQ(cached(kAhead + kBlock, kBytes - kAhead - kBlock), 0U);
  requests.come_to(begin() + kBytes - 1);
  EXPECT_TRUE(becomes_cached(kBytes - kBlock + page_size_, kBlock - page_size_));

  ASSERT_TRUE(becomes_empty());
  requests.come_to(begin() + kStart);
  requests.come_to(begin() + kBytes - 1);
  PageRequests().come_to(begin());
  ::usleep(100'000);
  EXPECT_EQ(cached(0, kBytes), 0U);

  requests.come_to(begin() + kAhead);  // the rest
  EXPECT_TRUE(becomes_cached(kAhead + kBlock, kAhead - kBlock));
  EXPECT_EQ(std::memcmp(begin(), content_.data(), content_.size()), 0);
}

}  // namespace
}  // namespace isoextract::test
