#include "files/detail/opened_files.hpp"

#include <fcntl.h>

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "files/file_bytes.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::files {
namespace {

using test::TempFolder;
using test::write_bytes;

InputFile must_open(const std::filesystem::path& path, const Context& context) {
  auto file = InputFile::open(path, context);
  EXPECT_TRUE(file) << file.error().message;
  return *file;
}

std::string content(const InputFile& file) {
  std::string bytes(file.size(), '\0');
  EXPECT_TRUE(file.read_at(0, std::as_writable_bytes(std::span(bytes))));
  return bytes;
}

bool is_open(int descriptor) { return ::fcntl(descriptor, F_GETFD) != -1; }

TEST(OpenedFiles, OpensAFileOncePerContext) {
  const TempFolder folder;
  write_bytes(folder / "a", "first");
  int descriptor = -1;
  {
    const Context context;
    descriptor = must_open(folder / "a", context).descriptor();
    EXPECT_TRUE(is_open(descriptor));
    EXPECT_EQ(must_open(folder / "a", context).descriptor(), descriptor);
    EXPECT_EQ(must_open(folder / "." / "a", context).descriptor(), descriptor);
    EXPECT_NE(must_open(folder / "a", Context()).descriptor(), descriptor);
  }
  EXPECT_FALSE(is_open(descriptor));
}

TEST(OpenedFiles, OpensAReplacedFile) {
  const TempFolder folder;
  const Context context;
  write_bytes(folder / "a", "first");
  const InputFile first = must_open(folder / "a", context);
  write_bytes(folder / "b", "another one");
  std::filesystem::rename(folder / "b", folder / "a");
  EXPECT_EQ(content(must_open(folder / "a", context)), "another one");
  EXPECT_EQ(content(first), "first");
}

TEST(OpenedFiles, ReopensAModifiedFile) {
  const TempFolder folder;
  const Context context;
  write_bytes(folder / "a", "first");
  EXPECT_EQ(content(must_open(folder / "a", context)), "first");
  write_bytes(folder / "a", "second, and longer");
  EXPECT_EQ(content(must_open(folder / "a", context)), "second, and longer");
}

TEST(OpenedFiles, SharesOpenFilesWithASubcontext) {
  const TempFolder folder;
  write_bytes(folder / "a", "a");
  write_bytes(folder / "b", "b");
  const Context whole;
  const int a = must_open(folder / "a", whole).descriptor();
  int b = -1;
  {
    const Context part = whole.part();
    EXPECT_EQ(must_open(folder / "a", part).descriptor(), a);
    EXPECT_EQ(must_open(folder / "a", part.part()).descriptor(), a);
    b = must_open(folder / "b", part).descriptor();
  }
  EXPECT_TRUE(is_open(a));
  EXPECT_FALSE(is_open(b));
}

TEST(OpenedFiles, CountsBytesPerContext) {
  const TempFolder folder;
  write_bytes(folder / "a", "12345");
  const Context context;
  const Context beside = context.beside();
  const InputFile file = must_open(folder / "a", beside);
  EXPECT_EQ(must_open(folder / "a", context).descriptor(), file.descriptor());
  EXPECT_EQ(content(file), "12345");
  EXPECT_EQ(beside.counters().bytes_read, 5U);
  EXPECT_EQ(context.counters().bytes_read, 0U);
}

TEST(OpenedFiles, LimitsOpenFiles) {
  const TempFolder folder;
  const Context context;
  std::vector<int> descriptors;
  for (std::size_t i = 0; i <= OpenedFiles::kMost; ++i) {
    const std::filesystem::path path = folder / std::to_string(i);
    write_bytes(path, std::to_string(i));
    descriptors.push_back(must_open(path, context).descriptor());
  }
  // The system reuses a descriptor's number once it is closed.
  EXPECT_EQ(content(must_open(folder / "0", context)), "0");
  EXPECT_TRUE(is_open(descriptors.back()));
  EXPECT_EQ(must_open(folder / std::to_string(OpenedFiles::kMost), context).descriptor(), descriptors.back());
}

}  // namespace
}  // namespace isoextract::files
