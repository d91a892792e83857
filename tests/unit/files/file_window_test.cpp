// Tests windows that show one part of a file after another.
#include "files/file_window.hpp"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "support/temp_folder.hpp"

namespace isoextract::test {
namespace {

const auto kWindowPage = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));

files::FileWindow must_make(const std::filesystem::path& path, std::uint64_t room) {
  const auto file = files::InputFile::open(path, Context());
  if (!file) throw std::runtime_error(file.error().message);
  auto window = files::FileWindow::make(*file, room);
  if (!window) throw std::runtime_error("no window");
  return std::move(*window);
}

// Returns the content of a file of eight pages, in which each byte differs from its neighbors and from page to page.
std::string content_of_pages() {
  std::string content(8 * kWindowPage, '\0');
  for (std::size_t i = 0; i < content.size(); ++i) content[i] = static_cast<char>(i % 251);
  return content;
}

TEST(FileWindow, ShowsAnyPartThatFits) {
  const TempFolder folder;
  const std::string content = content_of_pages();
  write_bytes(folder / "v", content);
  files::FileWindow window = must_make(folder / "v", 2 * kWindowPage);
  std::filesystem::remove(folder / "v");
  for (const std::size_t offset :
       {std::size_t{0}, kWindowPage - 1, 6 * kWindowPage, std::size_t{5}, 3 * kWindowPage + 7}) {
    for (const std::size_t bytes : {2 * kWindowPage, std::size_t{1}}) {
      const std::byte* shown = window.move_to(offset, bytes);
      ASSERT_NE(shown, nullptr) << offset;
      const auto* text = reinterpret_cast<const char*>(shown);
      EXPECT_TRUE(std::equal(text, text + bytes, content.data() + offset)) << offset;
    }
  }
  EXPECT_FALSE(window.lost());
  EXPECT_EQ(window.move_to(0, 3 * kWindowPage + 1), nullptr);
  EXPECT_NE(window.move_to(0, kWindowPage), nullptr);
}

TEST(FileWindow, ReadsZerosAndRemembersTheLossOfATruncatedFile) {
  const TempFolder folder;
  write_bytes(folder / "v", content_of_pages());
  files::FileWindow window = must_make(folder / "v", 2 * kWindowPage);
  std::filesystem::resize_file(folder / "v", 3 * kWindowPage);
  EXPECT_EQ(window.move_to(kWindowPage, 2 * kWindowPage)[0], static_cast<std::byte>(kWindowPage % 251));
  EXPECT_FALSE(window.lost());
  const std::byte* cut = window.move_to(2 * kWindowPage, 2 * kWindowPage);
  EXPECT_EQ(cut[0], static_cast<std::byte>(2 * kWindowPage % 251));
  EXPECT_EQ(cut[kWindowPage], std::byte{0});
  EXPECT_TRUE(window.lost());
  // A part that is still there can be read even so.
  EXPECT_EQ(window.move_to(7, 1)[0], std::byte{7});
  EXPECT_TRUE(window.lost());
}

}  // namespace
}  // namespace isoextract::test
