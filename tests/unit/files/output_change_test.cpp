// Tests changes in the middle of unfinished files, and files that are committed together.
#include <filesystem>

#include <gtest/gtest.h>

#include "files/content_hash.hpp"
#include "files/output_file.hpp"
#include "support/temp_folder.hpp"
#include "unit/files/output_process.hpp"

namespace isoextract::files {
namespace {

namespace fs = std::filesystem;
using test::read_bytes;
using test::TempFolder;
using test::write_bytes;

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

std::string pattern(std::size_t size) {
  std::string text(size, '\0');
  for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>('a' + (i * i / 7 + i) % 26);
  return text;
}

TEST(OutputFileChange, OverwritesBytesInBufferAndFile) {
  const TempFolder folder;
  auto file = must_create(folder / "out");
  const std::string large = pattern(3 << 20);  // larger than the buffer
  ASSERT_TRUE(file.write("0123456789"));
  ASSERT_TRUE(file.overwrite(2, bytes_of("ab")));  // still in the buffer
  ASSERT_TRUE(file.write(large));
  ASSERT_TRUE(file.write("end"));
  ASSERT_TRUE(file.overwrite(0, bytes_of("-")));
  EXPECT_EQ(file.bytes_written(), large.size() + 13);
  ASSERT_TRUE(file.write("!"));
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(read_bytes(folder / "out"), "-1ab456789" + large + "end!");
}

TEST(OutputFileChange, HashesChangedBytesWhenItCommits) {
  const TempFolder folder;
  auto file = must_create(folder / "out");
  file.keep_hash();
  const std::string room = pattern(2'500'000);  // no multiple of a block
  ASSERT_TRUE(file.write("head"));
  EXPECT_EQ(file.hash(), content_hash("head"));
  ASSERT_EQ(file.extend(room.size()), std::uint64_t{4});
  ASSERT_TRUE(file.fill(1'000'004, bytes_of(room).subspan(1'000'000)));
  ASSERT_TRUE(file.fill(4, bytes_of(room).first(1'000'000)));
  ASSERT_TRUE(file.write("tail"));
  EXPECT_EQ(file.hash(), std::nullopt);
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(file.hash(), content_hash("head" + room + "tail"));
}

// Moves forward and backward, by more and less than the moved size, and than a block.
TEST(OutputFileChange, MovesTheLastBytes) {
  const TempFolder folder;
  for (const std::size_t size : {std::size_t{0}, std::size_t{100}, std::size_t{5} << 20}) {
    for (const std::size_t step : {0, 1, 99, 1 << 20, (2 << 20) + 3}) {
      const std::string tail = pattern(size);
      const std::string front(step + 10, 'f');
      auto file = must_create(folder / "out");
      ASSERT_TRUE(file.write(front) && file.write(tail));
      ASSERT_TRUE(file.move_end(front.size(), 10));
      EXPECT_EQ(file.bytes_written(), 10 + size);
      ASSERT_TRUE(file.write("x"));
      ASSERT_TRUE(file.move_end(10, 10 + step));
      ASSERT_TRUE(file.write("y"));
      ASSERT_TRUE(file.commit());
      const std::string found = read_bytes(folder / "out");
      ASSERT_EQ(found.size(), 10 + step + size + 2);
      EXPECT_TRUE(found.ends_with(tail + "xy")) << size << " " << step;
      EXPECT_TRUE(found.starts_with("ffffffffff"));
    }
  }
}

TEST(OutputFileChange, WorksWithoutUnnamedFiles) {
  const TempFolder folder;
  const int code = in_child([&] {
    if (!forbid_unnamed_files()) return 77;
    auto file = must_create(folder / "out");
    if (!file.write("head, tail") || !file.move_end(6, 4) || !file.overwrite(0, bytes_of("HEAD"))) return 1;
    return file.commit() ? 0 : 2;
  });
  if (code == 77) GTEST_SKIP() << "this system does not let a process filter its system calls";
  ASSERT_EQ(code, 0);
  EXPECT_EQ(read_bytes(folder / "out"), "HEADtail");
}

TEST(OutputFileChange, FailsForStreams) {
  auto file = must_create("/dev/null");
  ASSERT_TRUE(file.write("gone"));
  const auto changed = file.overwrite(0, bytes_of("x"));
  ASSERT_FALSE(changed);
  EXPECT_EQ(changed.error().code, ErrorCode::output);
  EXPECT_FALSE(file.commit());
  EXPECT_FALSE(must_create("/dev/null").move_end(0, 0));
  EXPECT_TRUE(is_stream("/dev/null") && is_stream("-"));
  const TempFolder folder;
  write_bytes(folder / "file", "");
  EXPECT_FALSE(is_stream(folder / "file") || is_stream(folder / "none") || is_stream(folder.path()));
}

class OutputFiles : public testing::Test {
 protected:
  Result<void> commit_all(const std::function<void()>& before_commit = [] {}) {
    std::vector<OutputFile> files;
    std::vector<OutputFile*> all;
    for (const char* name : {"c", "b", "a"}) {
      files.push_back(must_create(folder_ / name));
      if (!files.back().write(std::string("new ") + name)) throw std::runtime_error("cannot write");
    }
    for (OutputFile& file : files) all.push_back(&file);
    before_commit();
    return OutputFile::commit_all(all);
  }

  TempFolder folder_;
};

TEST_F(OutputFiles, CommitsAll) {
  write_bytes(folder_ / "b", "old b");
  ASSERT_TRUE(commit_all());
  for (const std::string name : {"a", "b", "c"}) EXPECT_EQ(read_bytes(folder_ / name), "new " + name);
  EXPECT_EQ(folder_.names().size(), 3U);
}

TEST_F(OutputFiles, RestoresEarlierFilesOnFailure) {
  write_bytes(folder_ / "c", "old c");
  ASSERT_FALSE(commit_all([&] { fs::create_directories(folder_ / "a" / "in the way"); }));
  EXPECT_EQ(folder_.names(), (std::set<std::string>{"a", "c"}));
  EXPECT_EQ(read_bytes(folder_ / "c"), "old c");
}

TEST_F(OutputFiles, KeepsLaterFilesOnFailure) {
  write_bytes(folder_ / "a", "old a");
  ASSERT_FALSE(commit_all([&] { fs::create_directories(folder_ / "b" / "in the way"); }));
  EXPECT_EQ(folder_.names(), (std::set<std::string>{"a", "b"}));
  EXPECT_EQ(read_bytes(folder_ / "a"), "old a");
}

}  // namespace
}  // namespace isoextract::files
