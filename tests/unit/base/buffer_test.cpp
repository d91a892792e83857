#include "base/buffer.hpp"

#include <sys/mman.h>

#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include <gtest/gtest.h>

namespace isoextract {
namespace {

TEST(Buffer, HoldsSmallAndHugePageSizes) {
  for (const std::size_t size : {std::size_t{1}, std::size_t{1000}, std::size_t{3} << 20}) {
    Buffer<std::uint32_t> buffer(size);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(buffer.data()) % 64, 0U);
    std::iota(buffer.begin(), buffer.end(), 0U);
    EXPECT_EQ(buffer[size - 1], size - 1);
    EXPECT_EQ(buffer.size_bytes(), 4 * size);
  }
}

TEST(Buffer, MoveLeavesSourceEmpty) {
  Buffer<int> a(3);
  a[2] = 7;
  Buffer<int> b(std::move(a));
  EXPECT_EQ(b[2], 7);
  EXPECT_EQ(b.size(), 3U);
  EXPECT_EQ(a.size(), 0U);  // NOLINT(bugprone-use-after-move): what a moved-from buffer says is part of its contract
  a = std::move(b);
  EXPECT_EQ(a[2], 7);
  EXPECT_TRUE(b.empty());  // NOLINT(bugprone-use-after-move)
}

TEST(Buffer, ThrowsWhenSizeOverflows) {
  EXPECT_THROW(Buffer<double>(std::numeric_limits<std::size_t>::max() / 4), std::bad_alloc);
}

// The offset of the first huge page within a mapping depends on where the system places the mapping.
TEST(Buffer, ReusesLargeBlockAtAnyOffset) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "blocks are not kept below the address sanitizer";
#endif
  constexpr std::size_t kShift = std::size_t{128} << 10;
  for (int i = 0; i < 32; ++i) {
    detail::trim_kept_blocks(0);
    ASSERT_NE(::mmap(nullptr, kShift, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0), MAP_FAILED);
    const void* first = Buffer<char>(6'600'000).data();
    EXPECT_EQ(Buffer<char>(6'630'000).data(), first) << i;
  }
}

TEST(Buffer, HasNoElementsForSizeZero) {
  const Buffer<int> none(0);
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.begin(), none.end());
}

}  // namespace
}  // namespace isoextract
