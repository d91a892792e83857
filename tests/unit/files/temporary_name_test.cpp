#include <sys/file.h>

#include <csignal>

#include <gtest/gtest.h>

#include "support/temp_folder.hpp"
#include "unit/files/output_process.hpp"

namespace isoextract::files {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;
using test::write_bytes;

using Names = std::set<std::string>;

// Writes out.bin in a process that cannot create unnamed files; `before_commit` may end the process.
int write_without_unnamed_files(const fs::path& folder, const std::function<void()>& before_commit) {
  return in_child([&] {
    if (!forbid_unnamed_files()) return 77;
    auto file = must_create(folder / "out.bin");
    if (!file.write(std::string(1 << 21, 'x'))) return 2;
    before_commit();
    return file.commit() ? 0 : 3;
  });
}

// Returns the name of a file left by a process of this machine that has ended. Returns "" if system calls cannot be
// filtered.
std::string leave_one_behind(const TempFolder& folder) {
  if (write_without_unnamed_files(folder.path(), [] { ::raise(SIGKILL); }) == 77) return {};
  const Names names = folder.names();
  EXPECT_EQ(names.size(), 1U);
  return names.empty() ? "none" : *names.begin();
}

TEST(TemporaryName, RemovesFilesOfAKilledProcessWithoutUnnamedFiles) {
  const TempFolder folder;
  const std::string left = leave_one_behind(folder);
  if (left.empty()) GTEST_SKIP() << "this system does not let a process filter its system calls";
  EXPECT_TRUE(left.starts_with(".isoextract-"));
  EXPECT_EQ(write_without_unnamed_files(folder.path(), [] {}), 0);
  EXPECT_EQ(folder.names(), Names{"out.bin"});
}

// With unnamed files, a file has such a name only while it replaces an old one.
TEST(TemporaryName, RemovesFilesOfAKilledProcessWithUnnamedFiles) {
  const TempFolder folder;
  const std::string left = leave_one_behind(folder);
  if (left.empty()) GTEST_SKIP() << "this system does not let a process filter its system calls";
  auto file = must_create(folder / "out.bin");
  ASSERT_TRUE(file.write(std::string("whole")));
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(folder.names(), Names{"out.bin"});
}

TEST(TemporaryName, KeepsFilesOfLiveProcessesAndOtherMachines) {
  const TempFolder folder;
  const std::string left = leave_one_behind(folder);
  if (left.empty()) GTEST_SKIP() << "this system does not let a process filter its system calls";
  // Another process has the lock: it may be invisible from here.
  const int owner = ::open((folder / left).c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(::flock(owner, LOCK_EX | LOCK_NB), 0);
  std::string elsewhere = left;
  elsewhere.insert(elsewhere.find('-') + 1, "elsewhere.");
  write_bytes(folder / elsewhere, "of another machine");
  write_bytes(folder / ".isoextract-notes", "of somebody else");
  const std::string notes = left + "-notes";  // not removed either: names made here end after the number
  write_bytes(folder / notes, "of somebody else");
  const Names kept{left, elsewhere, ".isoextract-notes", notes};

  Names with_output = kept;
  with_output.insert("out.bin");
  EXPECT_EQ(write_without_unnamed_files(folder.path(),
                                        [&] {
                                          // Runs beside the owner of an unfinished file, whose name is still on disk.
                                          if (write_without_unnamed_files(folder.path(), [] {}) != 0) ::_exit(5);
                                        }),
            0);
  EXPECT_EQ(folder.names(), with_output);
  ::close(owner);
}

TEST(TemporaryName, RemovesUnfinishedFilesInSignalHandler) {
  const TempFolder folder;
  const int code = write_without_unnamed_files(folder.path(), [&] {
    if (folder.names().size() != 1) ::_exit(5);
    OutputFile::remove_unfinished();
    if (!folder.names().empty()) ::_exit(6);
    if (OutputFile::create(folder / "late.bin")) ::_exit(7);  // no new files while the process ends
  });
  if (code == 77) GTEST_SKIP() << "this system does not let a process filter its system calls";
  EXPECT_EQ(code, 3);  // nothing is left to commit
  EXPECT_EQ(folder.names(), Names{});
}

}  // namespace
}  // namespace isoextract::files
