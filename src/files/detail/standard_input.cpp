#include "files/detail/standard_input.hpp"

#include <cerrno>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/buffer.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::files::detail {
namespace {

constexpr std::size_t kPart = std::size_t{1} << 20;
// Step of reservations: small beside useful memory limits, large enough to make few calls.
constexpr std::uint64_t kReserved = std::uint64_t{16} << 20;

tl::unexpected<Error> cannot_read(int error) {
  return fail(ErrorCode::input,
              fmt::format("{}: reading failed: {}", kStandardInputName, std::generic_category().message(error)));
}

// Reads the bytes that are available, at least one unless the input ends; waits for a slow pipe.
Result<std::size_t> read_some(int descriptor, std::span<std::byte> bytes, const Context& context) {
  while (true) {
    TRY(context.check());
    const ssize_t got = ::read(descriptor, bytes.data(), bytes.size());
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno == EAGAIN) {
      pollfd wait{descriptor, POLLIN, 0};
      static_cast<void>(::poll(&wait, 1, -1));
    } else if (errno != EINTR) {
      return cannot_read(errno);
    }
  }
}

Result<void> write_all(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(descriptor, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) {
      return fail(ErrorCode::input, fmt::format("{}: storing it in memory failed: {}", kStandardInputName,
                                                std::generic_category().message(errno)));
    }
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return {};
}

// Copies everything into `kept`; reserves each part before writing it.
Result<std::vector<Reservation>> copy_all(int descriptor, int kept, const Context& context) {
  std::vector<Reservation> memory;
  Buffer<std::byte> part(kPart);
  std::uint64_t total = 0;
  std::uint64_t reserved = 0;
  while (true) {
    const auto got = TRY(read_some(descriptor, part.span(), context));
    if (got == 0) break;
    total += got;
    if (total > reserved) {
      const std::string what = fmt::format("{}: the first {} bytes", kStandardInputName, total);
      auto more = context.reserve(kReserved, what);
      if (!more) more = context.reserve(total - reserved, what);
      if (!more) return tl::unexpected(more.error());
      reserved += more->bytes();
      memory.push_back(std::move(*more));
    }
    TRY(write_all(kept, part.span().first(got)));
    context.progress().advance(got);
  }
  if (!memory.empty()) memory.back().shrink(memory.back().bytes() - (reserved - total));
  return memory;
}

int open_again(int descriptor) {
  return ::open(fmt::format("/proc/self/fd/{}", descriptor).c_str(), O_RDONLY | O_CLOEXEC);
}

}  // namespace

Result<BufferedInput> BufferedInput::take(int descriptor, const Context& context) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return cannot_read(errno);
  if (::isatty(descriptor) == 1) {
    return fail(ErrorCode::usage, fmt::format("{}: expected a pipe or a file, found a terminal", kStandardInputName),
                "pipe a file into the program, or give the path of a file");
  }
  // Uses the file directly only if nothing was read from it yet: bytes already consumed are not part of the input.
  if (S_ISREG(status.st_mode) && ::lseek(descriptor, 0, SEEK_CUR) == 0) {
    if (const int file = open_again(descriptor); file >= 0) return BufferedInput(file, {});
  }
  const int kept = ::memfd_create("isoextract-input", MFD_CLOEXEC);
  if (kept < 0) return cannot_read(errno);
  BufferedInput input(kept, {});
  context.progress().begin("reading standard input", 0);
  input.memory_ = TRY(copy_all(descriptor, kept, context));
  return input;
}

BufferedInput::BufferedInput(int descriptor, std::vector<Reservation> memory)
    : descriptor_(descriptor), memory_(std::move(memory)) {}

BufferedInput::BufferedInput(BufferedInput&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), memory_(std::move(other.memory_)) {}

BufferedInput::~BufferedInput() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

int BufferedInput::open() const { return open_again(descriptor_); }

Result<int> kept_standard_input(const Context& context) {
  // Also keeps a failure, as bytes already read cannot be read again.
  static std::mutex mutex;
  static std::optional<Result<BufferedInput>> kept;
  const std::scoped_lock lock(mutex);
  if (!kept) kept.emplace(BufferedInput::take(STDIN_FILENO, context));
  if (!*kept) return tl::unexpected(kept->error());
  return (*kept)->descriptor();
}

Result<int> open_standard_input(const Context& context) {
  const int kept = TRY(kept_standard_input(context));
  const int descriptor = open_again(kept);
  if (descriptor < 0) return cannot_read(errno);
  return descriptor;
}

}  // namespace isoextract::files::detail
