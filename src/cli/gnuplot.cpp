#include "cli/gnuplot.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include <fmt/format.h>

namespace isoextract::cli {
namespace {

constexpr const char* kHint = "install it with: apt-get install gnuplot-nox";

// An unnamed file in memory; unlike a pipe, it cannot block reader or writer.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(::memfd_create("gnuplot", MFD_CLOEXEC)) {}
  ~MemoryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] int descriptor() const { return descriptor_; }

  [[nodiscard]] bool fill(const std::string& text) const {
    std::size_t done = 0;
    while (done < text.size()) {
      const ssize_t written = ::write(descriptor_, text.data() + done, text.size() - done);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      done += static_cast<std::size_t>(written);
    }
    return ::lseek(descriptor_, 0, SEEK_SET) == 0;
  }

  [[nodiscard]] std::string text() const {
    std::string all;
    std::array<char, 1 << 16> part;
    off_t offset = 0;
    for (;;) {
      const ssize_t count = ::pread(descriptor_, part.data(), part.size(), offset);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return all;
      all.append(part.data(), static_cast<std::size_t>(count));
      offset += count;
    }
  }

 private:
  int descriptor_;
};

struct Finished {
  int error = 0;    // errno of starting the process
  int status = -1;  // from waitpid
  std::string out;
  std::string err;
};

Finished run(const std::string& script) {
  Finished result;
  const MemoryFile in;
  const MemoryFile out;
  const MemoryFile err;
  if (in.descriptor() < 0 || out.descriptor() < 0 || err.descriptor() < 0 || !in.fill(script)) {
    result.error = errno;
    return result;
  }
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, in.descriptor(), STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, out.descriptor(), STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, err.descriptor(), STDERR_FILENO);
  // This program ignores these signals; gnuplot gets their default handling.
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  sigset_t signals;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGPIPE);
  ::sigaddset(&signals, SIGXFSZ);
  ::posix_spawnattr_setsigdefault(&attributes, &signals);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);

  std::string program = "gnuplot";
  std::string defaults = "--default-settings";
  std::array<char*, 3> arguments{program.data(), defaults.data(), nullptr};
  pid_t child = 0;
  result.error = ::posix_spawnp(&child, program.c_str(), &actions, &attributes, arguments.data(), environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  if (result.error != 0) return result;
  while (::waitpid(child, &result.status, 0) < 0 && errno == EINTR) {
  }
  result.out = out.text();
  result.err = err.text();
  return result;
}

bool ended_well(const Finished& finished) {
  return finished.error == 0 && WIFEXITED(finished.status) && WEXITSTATUS(finished.status) == 0;
}

// Returns the first line that is not empty.
std::string first_line(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos) return "no message";
  return text.substr(begin, text.find('\n', begin) - begin);
}

}  // namespace

Result<void> check_gnuplot(std::string_view option) {
  const Finished finished = run("exit\n");
  if (ended_well(finished)) return {};
  return fail(ErrorCode::unavailable,
              fmt::format("{} needs gnuplot, which {}", option,
                          finished.error == ENOENT ? "is not installed"
                          : finished.error != 0    ? fmt::format("does not start: {}", std::strerror(finished.error))
                                                   : fmt::format("does not work: {}", first_line(finished.err))),
              kHint);
}

Result<std::string> run_gnuplot(const std::string& script) {
  Finished finished = run(script);
  if (ended_well(finished) && !finished.out.empty()) return std::move(finished.out);
  return fail(ErrorCode::unavailable, fmt::format("gnuplot made no picture: {}", first_line(finished.err)),
              finished.error != 0 ? kHint : "please report this error with the command");
}

std::string gnuplot_quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += '\'';
    quoted += static_cast<unsigned char>(c) < ' ' ? '?' : c;
  }
  return quoted + "'";
}

std::string plot_terminal(PictureFormat format) {
  return format == PictureFormat::svg
             ? "set terminal svg size 900,600 dynamic font 'Helvetica,Arial,sans-serif,15' background '#ffffff'\n"
             : "set terminal pngcairo size 1350,900 font 'Sans,16' background '#ffffff'\n";
}

std::string_view plot_color(std::size_t n) {
  // Okabe and Ito, "Color universal design", 2008.
  constexpr std::array<std::string_view, 6> kColors{"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"};
  return kColors[n % kColors.size()];
}

}  // namespace isoextract::cli
