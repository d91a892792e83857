// Tests hashes of files: when they change, and how much is read for them.
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "files/content_hash.hpp"
#include "files/file_version.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::files {
namespace {

// Returns the number of bytes that this process has read from files.
std::uint64_t bytes_read() {
  std::ifstream io("/proc/self/io");
  std::string name;
  std::uint64_t bytes = 0;
  while (io >> name >> bytes) {
    if (name == "rchar:") return bytes;
  }
  throw std::runtime_error("expected rchar in /proc/self/io");
}

void settle() { std::this_thread::sleep_for(std::chrono::milliseconds(200)); }

TEST(ContentHash, HashesAnUnchangedFileOnce) {
  const test::TempFolder folder;
  const std::string path = folder / "a.xyz";
  constexpr std::size_t kBytes = 3'000'000;
  test::write_bytes(path, std::string(kBytes, 'a'));
  settle();
  const std::uint64_t before = bytes_read();
  const auto first = hash_file(path, Context());
  const std::uint64_t once = bytes_read() - before;
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_GE(once, kBytes);
  for (int frame = 0; frame < 100; ++frame) EXPECT_EQ(hash_file(path, Context()).value(), *first);
  EXPECT_LT(bytes_read() - before, once + kBytes);
}

// Such a time is set by a program (touch, tar, a copy from another clock); the next write sets another one.
TEST(FileVersion, IsReliableWithATimeInTheFuture) {
  using namespace std::chrono_literals;
  const std::chrono::nanoseconds now = std::chrono::system_clock::now().time_since_epoch();
  const auto at = [&](std::chrono::nanoseconds modified, std::chrono::nanoseconds changed) {
    return FileVersion{1, 2, 3, (now + modified).count(), (now + changed).count()};
  };
  EXPECT_TRUE(at(-10s, -10s).is_reliable());
  EXPECT_TRUE(at(1h, -10s).is_reliable());
  EXPECT_FALSE(at(1h, 0s).is_reliable());
  EXPECT_FALSE(at(1h, 1h).is_reliable());
  EXPECT_FALSE(at(0s, -10s).is_reliable());
}

TEST(ContentHash, DetectsChanges) {
  const test::TempFolder folder;
  const std::string path = folder / "a.xyz";
  test::write_bytes(path, std::string(1000, 'a'));
  settle();
  const ContentState first = hash_file(path, Context()).value();
  const auto time = std::filesystem::last_write_time(path);
  // The size and modification time stay the same; the ctime reveals the change.
  test::write_bytes(path, std::string(1000, 'b'));
  std::filesystem::last_write_time(path, time);
  const ContentState second = hash_file(path, Context()).value();
  EXPECT_EQ(second.modified, first.modified);
  EXPECT_NE(second.hash, first.hash);
  settle();
  EXPECT_EQ(hash_file(path, Context()).value(), second);
  test::write_bytes(path, std::string(1000, 'a'));
  EXPECT_EQ(hash_file(path, Context()).value().hash, first.hash);
  EXPECT_EQ(content_hash(std::string(1000, 'a')), first.hash);
}

}  // namespace
}  // namespace isoextract::files
