// Tests mapped files that are truncated while they are in use.
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "files/mapped_file.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::test {
namespace {

const auto kPage = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));

files::MappedFile must_map(const std::filesystem::path& path, std::uint64_t offset, std::uint64_t bytes) {
  const auto file = files::InputFile::open(path, Context());
  if (!file) throw std::runtime_error(file.error().message);
  auto mapped = files::MappedFile::map(*file, offset, bytes);
  if (!mapped) throw std::runtime_error("not mapped");
  return std::move(*mapped);
}

TEST(MappedFile, ReadsZerosAndReportsLossOfATruncatedFile) {
  const TempFolder folder;
  write_bytes(folder / "cut", std::string(8 * kPage, 'a'));
  write_bytes(folder / "whole", std::string(8 * kPage, 'b'));
  const files::MappedFile cut = must_map(folder / "cut", kPage + 1, 7 * kPage - 1);
  const files::MappedFile whole = must_map(folder / "whole", 0, 8 * kPage);
  std::filesystem::resize_file(folder / "cut", 4 * kPage);
  EXPECT_EQ(cut.data()[0], std::byte{'a'});
  EXPECT_FALSE(cut.lost());
  EXPECT_EQ(cut.data()[4 * kPage], std::byte{0});
  EXPECT_TRUE(cut.lost());
  // Everything after the cut is zero as well, and nothing before it.
  EXPECT_EQ(cut.data()[7 * kPage - 2], std::byte{0});
  EXPECT_EQ(cut.data()[3 * kPage - 2], std::byte{'a'});
  EXPECT_EQ(whole.data()[8 * kPage - 1], std::byte{'b'});
  EXPECT_FALSE(whole.lost());
}

TEST(MappedFile, StartsANewMappingWithoutLoss) {
  const TempFolder folder;
  for (int i = 0; i < 3; ++i) {
    write_bytes(folder / "v", std::string(4 * kPage, 'a'));
    const files::MappedFile mapped = must_map(folder / "v", 0, 4 * kPage);
    EXPECT_FALSE(mapped.lost());
    std::filesystem::resize_file(folder / "v", kPage);
    EXPECT_EQ(mapped.data()[2 * kPage], std::byte{0});
    EXPECT_TRUE(mapped.lost());
  }
}

TEST(MappedFile, HandlesLossInManyThreads) {
  const TempFolder folder;
  write_bytes(folder / "v", std::string(64 * kPage, 'a'));
  const files::MappedFile mapped = must_map(folder / "v", 0, 64 * kPage);
  std::filesystem::resize_file(folder / "v", kPage);
  std::vector<std::thread> threads;
  std::atomic<int> sum{0};
  for (std::size_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t page = 63 - t; page > 0; --page) sum += static_cast<int>(mapped.data()[page * kPage]);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(sum, 0);
  EXPECT_TRUE(mapped.lost());
}

TEST(MappedFileDeathTest, EndsTheProcessOnOtherBusErrors) {
  const TempFolder folder;
  write_bytes(folder / "v", std::string(kPage, 'a'));
  // A sanitizer's own handler would be called.
  const auto map_and_raise = [&] {
    std::signal(SIGBUS, SIG_DFL);
    const files::MappedFile mapped = must_map(folder / "v", 0, kPage);
    std::raise(SIGBUS);
  };
  EXPECT_EXIT(map_and_raise(), testing::KilledBySignal(SIGBUS), "");
}

TEST(InputFile, CountsBytesInItsContext) {
  const TempFolder folder;
  write_bytes(folder / "v", std::string(100, 'a'));
  const Context context;
  const auto file = files::InputFile::open(folder / "v", context);
  ASSERT_TRUE(file);
  std::byte bytes[30];
  ASSERT_TRUE(file->read_at(70, bytes));
  EXPECT_EQ(context.counters().bytes_read, 30U);
  ASSERT_TRUE(files::MappedFile::map(*file, 0, 100));
  EXPECT_EQ(context.counters().bytes_read, 130U);
}

}  // namespace
}  // namespace isoextract::test
