#include "files/detail/standard_input.hpp"

#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "files/file_bytes.hpp"
#include "files/mapped_file.hpp"
#include "support/temp_folder.hpp"
#include "unit/files/output_process.hpp"

namespace isoextract::files {
namespace {

using detail::BufferedInput;

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { ::close(number_); }
  [[nodiscard]] int get() const { return number_; }

 private:
  int number_;
};

// A pipe into which a thread writes `text`, `step` bytes at a time, with pauses.
class WrittenPipe {
 public:
  explicit WrittenPipe(std::string text, std::size_t step = std::size_t{1} << 20, int wait_ms = 0) {
    if (::pipe2(ends_.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    writer_ = std::jthread([this, text = std::move(text), step, wait_ms] {
      for (std::size_t at = 0; at < text.size(); at += step) {
        const std::string part = text.substr(at, step);
        for (std::size_t put = 0; put < part.size();) {
          const ssize_t now = ::write(ends_[1], part.data() + put, part.size() - put);
          if (now < 0) break;
          put += static_cast<std::size_t>(now);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
      }
      ::close(ends_[1]);
    });
  }
  ~WrittenPipe() {
    writer_.join();
    ::close(ends_[0]);
  }
  [[nodiscard]] int get() const { return ends_[0]; }

 private:
  std::array<int, 2> ends_{};
  std::jthread writer_;
};

std::string random_text(std::size_t size) {
  std::string text(size, '\0');
  std::uint32_t state = 1;
  for (char& c : text) c = static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
  return text;
}

std::string all_of(const BufferedInput& input) {
  const Descriptor file(input.open());
  struct stat status {};
  EXPECT_EQ(::fstat(file.get(), &status), 0);
  std::string text(static_cast<std::size_t>(status.st_size), '\0');
  EXPECT_EQ(::pread(file.get(), text.data(), text.size(), 0), status.st_size);
  return text;
}

TEST(StandardInput, KeepsAPipeForRepeatedReading) {
  const std::string text = random_text((std::size_t{3} << 20) + 17);
  const WrittenPipe pipe(text);
  const Context context;
  {
    const auto input = BufferedInput::take(pipe.get(), context);
    ASSERT_TRUE(input) << input.error().message;
    EXPECT_EQ(all_of(*input), text);
    const Descriptor first(input->open());
    const Descriptor second(input->open());
    ASSERT_EQ(::lseek(first.get(), 100, SEEK_SET), 100);
    EXPECT_EQ(::lseek(second.get(), 0, SEEK_CUR), 0);
    EXPECT_EQ(context.memory().reserved(), text.size());
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

TEST(StandardInput, WaitsForASlowPipe) {
  const std::string text = random_text(50);
  for (const bool blocking : {true, false}) {
    const WrittenPipe pipe(text, 7, 5);
    ASSERT_EQ(::fcntl(pipe.get(), F_SETFL, blocking ? 0 : O_NONBLOCK), 0);
    const auto input = BufferedInput::take(pipe.get(), Context());
    ASSERT_TRUE(input) << input.error().message;
    EXPECT_EQ(all_of(*input), text);
  }
}

TEST(StandardInput, RespectsTheMemoryLimit) {
  const std::string text = random_text((std::size_t{2} << 20) + 1);
  const Context enough(MemoryBudget(text.size()));
  {
    const WrittenPipe pipe(text);
    EXPECT_TRUE(BufferedInput::take(pipe.get(), enough));
  }
  const Context little(MemoryBudget(text.size() - 1));
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  std::jthread writer([&] {
    for (std::size_t put = 0; put < text.size();) {
      put += static_cast<std::size_t>(::write(ends[1], text.data() + put, text.size() - put));
    }
    ::close(ends[1]);
  });
  const auto input = BufferedInput::take(ends[0], little);
  std::string rest(text.size(), '\0');
  while (::read(ends[0], rest.data(), rest.size()) > 0) {
  }
  writer.join();
  ::close(ends[0]);
  ASSERT_FALSE(input);
  EXPECT_EQ(input.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(input.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_TRUE(input.error().message.starts_with("standard input: "));
  EXPECT_EQ(little.memory().reserved(), 0U);
}

TEST(StandardInput, OpensAFileWithoutCopying) {
  const test::TempFolder folder;
  const std::string text = random_text(1000);
  test::write_bytes(folder / "v", text);
  const Context context;
  const Descriptor file(::open((folder / "v").c_str(), O_RDONLY | O_CLOEXEC));
  const auto input = BufferedInput::take(file.get(), context);
  ASSERT_TRUE(input);
  EXPECT_EQ(context.memory().reserved(), 0U);
  EXPECT_EQ(all_of(*input), text);
  const Descriptor again(input->open());
  struct stat first {};
  struct stat second {};
  ASSERT_EQ(::fstat(file.get(), &first), 0);
  ASSERT_EQ(::fstat(again.get(), &second), 0);
  EXPECT_EQ(first.st_ino, second.st_ino);
}

TEST(StandardInput, ReadsTheRestOfAPartlyReadFile) {
  const test::TempFolder folder;
  test::write_bytes(folder / "v", "headertext");
  const Descriptor file(::open((folder / "v").c_str(), O_RDONLY | O_CLOEXEC));
  ASSERT_EQ(::lseek(file.get(), 6, SEEK_SET), 6);
  const auto input = BufferedInput::take(file.get(), Context());
  ASSERT_TRUE(input);
  EXPECT_EQ(all_of(*input), "text");
}

TEST(StandardInput, RejectsFoldersAndTerminals) {
  const test::TempFolder folder;
  const Descriptor directory(::open(folder.path().c_str(), O_RDONLY | O_CLOEXEC));
  const auto of_folder = BufferedInput::take(directory.get(), Context());
  ASSERT_FALSE(of_folder);
  EXPECT_EQ(of_folder.error().code, ErrorCode::input);
  EXPECT_FALSE(BufferedInput::take(-1, Context()));

  const Descriptor ours(::posix_openpt(O_RDWR | O_NOCTTY));
  ASSERT_EQ(::grantpt(ours.get()), 0);
  ASSERT_EQ(::unlockpt(ours.get()), 0);
  const Descriptor terminal(::open(::ptsname(ours.get()), O_RDWR | O_NOCTTY));
  const auto typed = BufferedInput::take(terminal.get(), Context());
  ASSERT_FALSE(typed);
  EXPECT_EQ(typed.error().code, ErrorCode::usage);
  EXPECT_NE(typed.error().message.find("terminal"), std::string::npos);
}

TEST(StandardInput, CanBeCancelled) {
  const WrittenPipe pipe("text");
  const Context context;
  context.cancel();
  const auto input = BufferedInput::take(pipe.get(), context);
  ASSERT_FALSE(input);
  EXPECT_EQ(input.error().code, ErrorCode::cancelled);
}

// Runs `body` in a process whose standard input is a pipe that contains `text`.
int with_input(const std::string& text, const std::function<int()>& body) {
  return in_child([&] {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) return 101;
    if (::write(ends[1], text.data(), text.size()) != static_cast<ssize_t>(text.size())) return 102;
    ::close(ends[1]);
    ::dup2(ends[0], STDIN_FILENO);
    return body();
  });
}

TEST(StandardInput, OpensAsAnInputFile) {
  EXPECT_EQ(with_input("sixteen bytes .!",
                       [] {
                         for (int again = 0; again < 2; ++again) {
                           const auto file = InputFile::open("-", Context());
                           if (!file || file->name() != "standard input" || file->size() != 16) return 1;
                           const auto mapped = MappedFile::map(*file, 8, 5);
                           if (!mapped || std::memcmp(mapped->data(), "bytes", 5) != 0) return 2;
                           const auto first = first_bytes(*file, 7);
                           if (!first || first->size() != 7 || first->back() != std::byte{'n'}) return 3;
                         }
                         return 0;
                       }),
            0);
  EXPECT_EQ(with_input("",
                       [] {
                         const auto file = InputFile::open("-", Context());
                         return !file && file.error().message == "standard input: it is empty" ? 0 : 1;
                       }),
            0);
}

// Bytes read before the failure are gone: a second attempt must not return a shorter file.
TEST(StandardInput, RepeatsTheErrorOfAFailedRead) {
  EXPECT_EQ(with_input(std::string(1000, 'x'),
                       [] {
                         if (InputFile::open("-", Context(MemoryBudget(10)))) return 1;
                         const auto again = InputFile::open("-", Context());
                         return !again && again.error().hint == Hint(Remedy::raise, Setting::memory_limit) ? 0 : 2;
                       }),
            0);
}

TEST(StandardInput, RejectsDetachedDataFiles) {
  const auto beside = resolve_beside("-", "CMakeLists.txt");
  ASSERT_FALSE(beside);
  EXPECT_NE(beside.error().message.find("standard input"), std::string::npos);
  EXPECT_TRUE(is_standard_input("-"));
  EXPECT_FALSE(is_standard_input("./-"));
}

}  // namespace
}  // namespace isoextract::files
