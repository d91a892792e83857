#include "files/output_file.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <thread>

#include <gtest/gtest.h>

#include "support/hints.hpp"
#include "support/temp_folder.hpp"
#include "unit/files/output_process.hpp"

namespace isoextract::files {
namespace {

namespace fs = std::filesystem;
using test::read_bytes;
using test::TempFolder;
using test::write_bytes;
using testing::Test;

using Names = std::set<std::string>;

mode_t permissions(const fs::path& path) {
  struct stat found {};
  EXPECT_EQ(::stat(path.c_str(), &found), 0);
  return found.st_mode & 07777;
}

TEST(OutputFile, CommitsNameAndBytes) {
  const TempFolder folder;
  auto file = must_create(folder / "out.bin");
  const std::string large(300000, 'x');  // not copied into the buffer; the order must still be right
  ASSERT_TRUE(file.write("start\n"));
  ASSERT_TRUE(file.write(large));
  ASSERT_TRUE(file.write("end"));
  EXPECT_EQ(file.bytes_written(), large.size() + 9);
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(read_bytes(folder / "out.bin"), "start\n" + large + "end");
  EXPECT_EQ(folder.names(), Names{"out.bin"});
}

TEST(OutputFile, FillsReservedBytesFromSeveralThreads) {
  const TempFolder folder;
  auto file = must_create(folder / "out.bin");
  ASSERT_TRUE(file.write("head"));
  constexpr std::size_t kBytes = 100000;
  const auto place = file.extend(2 * kBytes);
  ASSERT_TRUE(place);
  EXPECT_EQ(*place, 4U);
  ASSERT_TRUE(file.write("tail"));  // follows the room
  const auto fill = [&](char letter, std::uint64_t at) {
    const std::string text(kBytes, letter);
    EXPECT_TRUE(file.fill(at, std::as_bytes(std::span(text))));
  };
  std::thread other(fill, 'b', *place + kBytes);
  fill('a', *place);
  other.join();
  EXPECT_EQ(file.bytes_written(), 2 * kBytes + 8);
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(read_bytes(folder / "out.bin"), "head" + std::string(kBytes, 'a') + std::string(kBytes, 'b') + "tail");
}

TEST(OutputFile, KeepsOrderOfSmallWrites) {
  const TempFolder folder;
  auto file = must_create(folder / "out.txt");
  std::string expected;
  for (int i = 0; i < 400000; ++i) {  // fills several buffers
    const std::string text = std::to_string(i) + ' ';
    expected += text;
    ASSERT_TRUE(file.write(text));
  }
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(read_bytes(folder / "out.txt"), expected);
}

TEST(OutputFile, LeavesNothingWithoutCommit) {
  const TempFolder folder;
  {
    auto file = must_create(folder / "out.bin");
    ASSERT_TRUE(file.write(std::string(1 << 21, 'x')));
    EXPECT_EQ(folder.names(), Names{});  // the file has no name while it is written
  }
  EXPECT_EQ(folder.names(), Names{});
}

TEST(OutputFile, KeepsTheOldFileUntilCommit) {
  const TempFolder folder;
  write_bytes(folder / "out.bin", "old");
  {
    auto file = must_create(folder / "out.bin");
    ASSERT_TRUE(file.write(std::string(1 << 21, 'x')));
    EXPECT_EQ(read_bytes(folder / "out.bin"), "old");
  }
  EXPECT_EQ(read_bytes(folder / "out.bin"), "old");
  auto file = must_create(folder / "out.bin");
  ASSERT_TRUE(file.write("new"));
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(read_bytes(folder / "out.bin"), "new");
  EXPECT_EQ(folder.names(), Names{"out.bin"});
}

TEST(OutputFile, LeavesNothingWhenKilled) {
  const TempFolder folder;
  write_bytes(folder / "out.bin", "old");
  in_child([&] {
    auto file = must_create(folder / "out.bin");
    (void)file.write(std::string(1 << 21, 'x'));
    return ::raise(SIGKILL);
  });
  EXPECT_EQ(read_bytes(folder / "out.bin"), "old");
  EXPECT_EQ(folder.names(), Names{"out.bin"});
}

TEST(OutputFile, ReplacesTheTargetOfASymbolicLink) {
  const TempFolder folder;
  fs::create_directory(folder / "real");
  fs::create_symlink("real/out.bin", folder / "second");
  fs::create_symlink("second", folder / "first");
  for (const std::string content : {"made", "replaced"}) {  // the link is dangling at first
    auto file = must_create(folder / "first");
    ASSERT_TRUE(file.write(content));
    ASSERT_TRUE(file.commit());
    EXPECT_TRUE(fs::is_symlink(folder / "first") && fs::is_symlink(folder / "second"));
    EXPECT_EQ(read_bytes(folder / "real/out.bin"), content);
  }
}

TEST(OutputFile, AppliesTheUmaskToNewFiles) {
  const TempFolder folder;
  const mode_t old = ::umask(027);
  auto file = must_create(folder / "out.bin");
  ::umask(old);
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(permissions(folder / "out.bin"), 0640U);
}

TEST(OutputFile, KeepsPermissionsOfAReplacedFile) {
  const TempFolder folder;
  write_bytes(folder / "out.bin", "old");
  fs::permissions(folder / "out.bin", fs::perms(0606));
  auto file = must_create(folder / "out.bin");
  ASSERT_TRUE(file.write("new"));
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(read_bytes(folder / "out.bin"), "new");
  EXPECT_EQ(permissions(folder / "out.bin"), 0606U);
}

TEST(OutputFile, WorksWithoutUnnamedFiles) {
  const TempFolder folder;
  write_bytes(folder / "kept.bin", "old");
  fs::permissions(folder / "kept.bin", fs::perms(0604));
  const int code = in_child([&] {
    if (!forbid_unnamed_files()) return 77;
    ::umask(027);
    {
      auto dropped = must_create(folder / "dropped.bin");
      if (folder.names().size() != 2) return 1;  // otherwise unnamed files were used
    }
    auto made = must_create(folder / "made.bin");
    auto kept = must_create(folder / "kept.bin");
    if (!made.write("made") || !kept.write("kept") || !made.commit() || !kept.commit()) return 2;
    return 0;
  });
  if (code == 77) GTEST_SKIP() << "this system does not let a process filter its system calls";
  ASSERT_EQ(code, 0);
  EXPECT_EQ(folder.names(), (Names{"kept.bin", "made.bin"}));
  EXPECT_EQ(read_bytes(folder / "made.bin"), "made");
  EXPECT_EQ(read_bytes(folder / "kept.bin"), "kept");
  EXPECT_EQ(permissions(folder / "made.bin"), 0640U);
  EXPECT_EQ(permissions(folder / "kept.bin"), 0604U);
}

TEST(OutputFile, WritesDevicesDirectly) {
  auto file = must_create("/dev/null");
  ASSERT_TRUE(file.write("gone"));
  ASSERT_TRUE(file.commit());
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(OutputFile, WritesPipesDirectly) {
  const TempFolder folder;
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::string sent(1 << 20, 'p');  // larger than a pipe's buffer, so that writes are short
  std::string received;
  std::thread reader([&] { received = read_bytes(pipe); });
  {
    auto file = must_create(pipe);
    EXPECT_TRUE(file.write(sent));
    EXPECT_TRUE(file.commit());
  }
  reader.join();
  EXPECT_EQ(received, sent);
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(OutputFile, RepeatsTheErrorOfAFullDevice) {
  auto file = must_create("/dev/full");
  const auto first = file.write(std::string(1 << 20, 'x'));
  ASSERT_FALSE(first);
  EXPECT_EQ(first.error().code, ErrorCode::output);
  EXPECT_EQ(first.error().message, "/dev/full: cannot write: no space left on the device");
  EXPECT_EQ(test::text_of(first.error().hint), "free some space or choose another place for the file");
  const auto later = file.write("y");
  ASSERT_FALSE(later);
  EXPECT_EQ(later.error().message, first.error().message);
  EXPECT_FALSE(file.commit());
}

TEST(OutputFile, FailsAtCommitOnAFullDevice) {
  auto file = must_create("/dev/full");
  ASSERT_TRUE(file.write("in the buffer"));
  const auto committed = file.commit();
  ASSERT_FALSE(committed);
  EXPECT_EQ(committed.error().code, ErrorCode::output);
}

TEST(OutputFile, KeepsTheOldFileOnFailedWrite) {
  const TempFolder folder;
  write_bytes(folder / "out.bin", "old");
  const int code = in_child([&] {
    const rlimit limit{1 << 16, 1 << 16};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0 || ::signal(SIGXFSZ, SIG_IGN) == SIG_ERR) return 1;
    auto file = must_create(folder / "out.bin");
    const auto written = file.write(std::string(1 << 20, 'x'));
    if (written || written.error().code != ErrorCode::output) return 2;
    if (written.error().message.find("out.bin") == std::string::npos) return 3;
    return file.commit() ? 4 : 0;
  });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(read_bytes(folder / "out.bin"), "old");
  EXPECT_EQ(folder.names(), Names{"out.bin"});
}

TEST(OutputFile, FailsForAClosedReader) {
  const int code = in_child([] {
    int ends[2];
    if (::pipe(ends) != 0 || ::dup2(ends[1], STDOUT_FILENO) < 0) return 1;
    ::close(ends[0]);
    ::signal(SIGPIPE, SIG_IGN);
    auto file = must_create("-");
    const auto written = file.write(std::string(1 << 20, 'x'));
    if (written) return 2;
    return written.error().message == "standard output: cannot write: the reader closed the pipe" ? 0 : 3;
  });
  EXPECT_EQ(code, 0);
}

TEST(OutputFile, WritesStandardOutputAndKeepsItOpen) {
  const TempFolder folder;
  const fs::path captured = folder / "stdout";
  const int code = in_child([&] {
    const int fd = ::open(captured.c_str(), O_WRONLY | O_CREAT, 0600);
    if (::dup2(fd, STDOUT_FILENO) < 0) return 1;
    {
      auto file = must_create("-");
      if (!file.write("mesh") || !file.commit()) return 2;
    }
    return ::write(STDOUT_FILENO, "!", 1) == 1 ? 0 : 3;
  });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(read_bytes(captured), "mesh!");
}

struct BadPath {
  std::string path;
  std::string expected;
};

TEST(OutputFile, ExplainsInvalidPaths) {
  const TempFolder folder;
  write_bytes(folder / "file", "");
  fs::create_directory(folder / "inner");
  fs::create_symlink("loop", folder / "loop");
  const std::vector<BadPath> cases = {
      {"missing/out.bin", "there is no folder"},
      {"inner", "expected a file, found a folder"},
      {"new/", "expected a file name, found the name of a folder"},
      {"file/out.bin", "Not a directory"},
      {"loop", "Too many levels of symbolic links"},
      {std::string(300, 'n'), "File name too long"},
  };
  for (const BadPath& bad : cases) {
    const auto file = OutputFile::create(folder / bad.path);
    ASSERT_FALSE(file) << bad.path;
    EXPECT_EQ(file.error().code, ErrorCode::output);
    EXPECT_TRUE(file.error().message.starts_with((folder / bad.path).string() + ": ")) << file.error().message;
    EXPECT_NE(file.error().message.find(bad.expected), std::string::npos) << file.error().message;
    EXPECT_NE(test::text_of(file.error().hint).find("file"), std::string::npos) << file.error().message;
  }
  EXPECT_EQ(folder.names(), (Names{"file", "inner", "loop"}));
}

TEST(OutputFile, FailsWithoutPermission) {
  constexpr uid_t kOtherUser = 65534;
  const TempFolder folder;
  fs::create_directory(folder / "closed");
  write_bytes(folder / "closed/protected.bin", "old");
  fs::create_directory(folder / "open");
  write_bytes(folder / "open/protected.bin", "old");
  fs::permissions(folder / "open/protected.bin", fs::perms(0444));
  fs::permissions(folder / "open", fs::perms(0777));
  fs::permissions(folder.path(), fs::perms(0755));
  const int code = in_child([&] {
    fs::permissions(folder / "closed", fs::perms(0555));
    if (::geteuid() == 0 && ::seteuid(kOtherUser) != 0) return 77;
    const auto in_closed = OutputFile::create(folder / "closed/out.bin");
    if (in_closed || in_closed.error().code != ErrorCode::output) return 1;
    if (in_closed.error().message.find("no permission") == std::string::npos) return 2;
    // The folder permits a rename, but the file's permissions protect it.
    const auto replaced = OutputFile::create(folder / "open/protected.bin");
    if (replaced || replaced.error().message.find("no permission") == std::string::npos) return 3;
    return 0;
  });
  fs::permissions(folder / "closed", fs::perms(0755));
  if (code == 77) GTEST_SKIP() << "cannot give up the rights of root";
  EXPECT_EQ(code, 0);
}

class OutputFilePair : public Test {
 protected:
  TempFolder folder_;
  fs::path first_ = folder_ / "a.bin";
  fs::path last_ = folder_ / "a.gltf";

  Result<void> commit_pair(const std::function<void()>& before_commit = [] {}) {
    auto first = must_create(first_);
    auto last = must_create(last_);
    if (!first.write("new data") || !last.write("new model")) throw std::runtime_error("cannot write");
    before_commit();
    return OutputFile::commit_pair(first, last);
  }

  // Makes the last rename fail after all earlier steps have succeeded.
  void block_last() { fs::create_directories(last_ / "in the way"); }
};

TEST_F(OutputFilePair, CommitsBoth) {
  for (int round = 0; round < 2; ++round) {  // a new file, then a replaced one
    ASSERT_TRUE(commit_pair());
    EXPECT_EQ(read_bytes(first_), "new data");
    EXPECT_EQ(read_bytes(last_), "new model");
    EXPECT_EQ(folder_.names(), (Names{"a.bin", "a.gltf"}));
    write_bytes(first_, "old data");
  }
}

TEST_F(OutputFilePair, RemovesTheNewFirstFileIfTheLastFails) {
  const auto committed = commit_pair([this] { block_last(); });
  ASSERT_FALSE(committed);
  EXPECT_EQ(committed.error().code, ErrorCode::output);
  EXPECT_EQ(folder_.names(), Names{"a.gltf"});
}

TEST_F(OutputFilePair, RestoresTheOldFirstFileIfTheLastFails) {
  write_bytes(first_, "old data");
  ASSERT_FALSE(commit_pair([this] { block_last(); }));
  EXPECT_EQ(read_bytes(first_), "old data");
  EXPECT_EQ(folder_.names(), (Names{"a.bin", "a.gltf"}));
}

TEST_F(OutputFilePair, KeepsTheLastFileIfTheFirstFails) {
  write_bytes(last_, "old model");
  ASSERT_FALSE(commit_pair([this] { fs::create_directories(first_ / "in the way"); }));
  EXPECT_EQ(read_bytes(last_), "old model");
  EXPECT_EQ(folder_.names(), (Names{"a.bin", "a.gltf"}));
}

TEST(RemoveOldFile, RemovesTheFileToBeReplaced) {
  const TempFolder folder;
  write_bytes(folder / "old", "old");
  fs::create_symlink("old", folder / "link");
  EXPECT_TRUE(remove_old_file(folder / "link").value());
  EXPECT_EQ(folder.names(), Names{"link"}) << "as a file that is written would have taken its place";
  EXPECT_FALSE(remove_old_file(folder / "link").value());
  write_bytes(folder / "old", "old");
  EXPECT_TRUE(remove_old_file(folder / "old").value());
  EXPECT_FALSE(remove_old_file(folder / "old").value());
}

TEST(RemoveOldFile, KeepsEverythingElse) {
  const TempFolder folder;
  fs::create_directory(folder / "folder");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const fs::path& path :
       {folder / "folder", folder / "pipe", fs::path("/dev/null"), fs::path("-"), fs::path("")}) {
    const auto removed = remove_old_file(path);
    ASSERT_TRUE(removed) << removed.error().message;
    EXPECT_FALSE(*removed) << path;
  }
  EXPECT_EQ(folder.names(), (Names{"folder", "pipe"}));
}

TEST(SamePlace, ComparesFilesNotNames) {
  const TempFolder folder;
  write_bytes(folder / "a", "");
  write_bytes(folder / "b", "");
  fs::create_symlink("a", folder / "link");
  fs::create_hard_link(folder / "a", folder / "hard");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  fs::create_hard_link(folder / "pipe", folder / "twin");
  EXPECT_TRUE(is_same_output(folder / "a", folder / "link"));
  EXPECT_TRUE(is_same_output(folder / "hard", folder / "a"));
  EXPECT_TRUE(is_same_output(folder / "pipe", folder / "twin"));
  EXPECT_FALSE(is_same_output(folder / "a", folder / "b"));
  EXPECT_FALSE(is_same_output(folder / "a", folder / "pipe"));
  EXPECT_FALSE(is_same_output(folder / "a", folder / "c"));
  EXPECT_TRUE(is_same_output(folder / "c", folder / "." / "c")) << "neither is there";
  fs::create_symlink("c", folder / "to_c");
  fs::create_symlink("to_c", folder / "to_to_c");
  EXPECT_TRUE(is_same_output(folder / "c", folder / "to_to_c")) << "what is written through a link makes its file";
  EXPECT_FALSE(is_same_output(folder / "d", folder / "to_c"));
  EXPECT_TRUE(is_same_output("-", "/dev/stdout"));
  EXPECT_TRUE(is_same_output("/proc/self/fd/1", "-"));
  EXPECT_FALSE(is_same_output("-", folder / "a"));
  EXPECT_FALSE(is_same_output("-", folder / "c"));
}

}  // namespace
}  // namespace isoextract::files
