#include "files/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/buffer.hpp"
#include "files/content_hash.hpp"
#include "files/detail/retry_interrupted.hpp"
#include "files/detail/temporary_name.hpp"

namespace isoextract::files {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
constexpr std::size_t kUnbufferedBytes = std::size_t{1} << 16;  // spans of at least this size are not copied
constexpr mode_t kPermissionBits = S_IRWXU | S_IRWXG | S_IRWXO;
constexpr int kMostOldFiles = 1000;
constexpr const char* kAnotherPlace = "choose another place for the file";

Error system_error(const std::string& shown, std::string_view action, int code) {
  const auto error = [&](std::string_view reason, std::string hint) {
    return Error{ErrorCode::output, fmt::format("{}: cannot {}: {}", shown, action, reason), std::move(hint)};
  };
  switch (code) {
    case ENOSPC: return error("no space left on the device", fmt::format("free some space or {}", kAnotherPlace));
    case EDQUOT: return error("the disk quota has no space left", fmt::format("free some space or {}", kAnotherPlace));
    case EFBIG:
      return error("the file would be larger than the file system or the limit of this shell allows",
                   fmt::format("raise the limit with ulimit -f or {}", kAnotherPlace));
    case EACCES:
    case EPERM: return error("no permission", fmt::format("change the permissions or {}", kAnotherPlace));
    case EROFS: return error("read-only file system", kAnotherPlace);
    case EPIPE: return error("the reader closed the pipe", {});
    case EBADF: return error("the output is not open", kAnotherPlace);
    default: return error(std::generic_category().message(code), kAnotherPlace);
  }
}

// Returns the file at the end of a chain of symbolic links; it need not exist. A stat() call has ruled out loops
// before.
fs::path follow_links(fs::path path) {
  std::error_code ignored;
  while (fs::is_symlink(fs::symlink_status(path, ignored))) {
    const fs::path link = fs::read_symlink(path, ignored);
    path = link.is_absolute() ? link : path.parent_path() / link;
  }
  return path;
}

// Returns whether the user may write to the file: rename and unlink would not respect write protection.
bool may_replace(const fs::path& target) { return ::faccessat(AT_FDCWD, target.c_str(), W_OK, AT_EACCESS) == 0; }

bool status_of(const fs::path& path, struct stat& status) {
  return (path == "-" ? ::fstat(STDOUT_FILENO, &status) : ::stat(path.c_str(), &status)) == 0;
}

// Returns whether the path is a regular file that an output of this name would replace.
bool is_old_file(const fs::path& path) {
  struct stat old {};
  return path != "-" && ::stat(path.c_str(), &old) == 0 && S_ISREG(old.st_mode);
}

std::string descriptor_link(int fd) { return fmt::format("/proc/self/fd/{}", fd); }

}  // namespace

struct OutputFile::State {
  enum class Kind { file, device, standard_output, joined };

  Kind kind = Kind::file;
  std::string shown;  // name for messages
  fs::path target;    // Kind::file: the name after commit
  fs::path folder;
  bool replaces = false;   // the target exists
  bool is_shared = false;  // needs a name from the start
  int fd = -1;
  TemporaryName temporary;  // the name on disk before commit; may be empty
  Buffer<std::byte> buffer;
  std::size_t buffered = 0;
  std::uint64_t bytes = 0;
  std::optional<Error> failure;
  bool keeps_hash = false;
  std::optional<ContentHasher> hasher;  // empty also after bytes were written out of order

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    if (fd >= 0 && kind != Kind::standard_output) ::close(fd);
  }

  [[nodiscard]] tl::unexpected<Error> failed(std::string_view action, int code) {
    failure = system_error(shown, action, code);
    return tl::unexpected<Error>(*failure);
  }

  [[nodiscard]] Result<void> open_device(const fs::path& path);
  [[nodiscard]] Result<void> open_file(const fs::path& path, const std::optional<mode_t>& old_mode);
  [[nodiscard]] Result<void> write_through(std::span<const std::byte> span);
  [[nodiscard]] Result<void> flush();
  [[nodiscard]] Result<void> prepare_change();
  [[nodiscard]] Result<void> write_to(std::uint64_t place, std::span<const std::byte> span);
  [[nodiscard]] Result<void> set_size(std::uint64_t size);
  [[nodiscard]] Result<void> read_from(std::uint64_t place, std::span<std::byte> span);
  [[nodiscard]] Result<void> hash_again();
  [[nodiscard]] Result<void> prepare();
  [[nodiscard]] Result<void> publish();
};

Result<void> OutputFile::State::open_device(const fs::path& path) {
  kind = Kind::device;
  fd = retry_interrupted([&] { return ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY); });
  if (fd < 0) return failed("open the file for writing", errno);
  return {};
}

Result<void> OutputFile::State::open_file(const fs::path& path, const std::optional<mode_t>& old_mode) {
  target = follow_links(path);
  folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (!target.has_filename()) {
    return fail(ErrorCode::output, fmt::format("{}: expected a file name, found the name of a folder", shown),
                "add a file name");
  }
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return fail(ErrorCode::output, fmt::format("{}: there is no folder {}", shown, folder.string()),
                fmt::format("make the folder (mkdir -p) or {}", kAnotherPlace));
  }
  replaces = old_mode.has_value();
  if (replaces && !may_replace(target)) return failed("replace the file", errno);
  constexpr mode_t kNewFile = 0666;  // minus the umask
  const std::string action = fmt::format("make a file in {}", folder.string());
  errno = EOPNOTSUPP;
  if (!is_shared) {
    fd = retry_interrupted([&] { return ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, kNewFile); });
  }
  if (fd >= 0 && ::access(descriptor_link(fd).c_str(), F_OK) != 0) {  // without /proc the file could never get a name
    ::close(fd);
    fd = -1;
    errno = EOPNOTSUPP;
  }
  if (fd < 0 && (errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL)) {
    if (auto made = TemporaryName::make_file(folder)) {
      temporary = std::move(made->name);
      fd = made->fd;
    }
  }
  if (fd < 0) return failed(action, errno);
  struct stat made {};
  if (replaces && ::fstat(fd, &made) == 0 && (made.st_mode & kPermissionBits) != *old_mode &&
      ::fchmod(fd, *old_mode) != 0) {
    return failed("copy the permissions of the old file", errno);
  }
  return {};
}

Result<void> OutputFile::State::write_through(std::span<const std::byte> span) {
  while (!span.empty()) {
    const ssize_t written = retry_interrupted([&] { return ::write(fd, span.data(), span.size()); });
    if (written < 0) return failed("write", errno);
    span = span.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

Result<void> OutputFile::State::flush() {
  if (failure) return tl::unexpected<Error>(*failure);
  const std::size_t size = std::exchange(buffered, 0);
  return write_through(std::span<const std::byte>(buffer.span()).first(size));
}

// Prepares a change of bytes already written.
Result<void> OutputFile::State::prepare_change() {
  if (kind != Kind::file && !failure) return failed("change bytes already written", ESPIPE);
  hasher.reset();
  return flush();
}

// Writes bytes at `place`; returns the code of the system's error, or 0. Several threads may write at once.
int write_at(int fd, std::uint64_t place, std::span<const std::byte> span) {
  while (!span.empty()) {
    const ssize_t written =
        retry_interrupted([&] { return ::pwrite(fd, span.data(), span.size(), static_cast<off_t>(place)); });
    if (written < 0) return errno;
    place += static_cast<std::uint64_t>(written);
    span = span.subspan(static_cast<std::size_t>(written));
  }
  return 0;
}

Result<void> OutputFile::State::write_to(std::uint64_t place, std::span<const std::byte> span) {
  if (const int code = write_at(fd, place, span); code != 0) return failed("write", code);
  return {};
}

// Changes the size of the file; later bytes are appended at its end.
Result<void> OutputFile::State::set_size(std::uint64_t size) {
  bytes = size;
  if (::ftruncate(fd, static_cast<off_t>(size)) != 0) return failed("write", errno);
  if (::lseek(fd, 0, SEEK_END) < 0) return failed("write", errno);
  return {};
}

Result<void> OutputFile::State::read_from(std::uint64_t place, std::span<std::byte> span) {
  while (!span.empty()) {
    const ssize_t got =
        retry_interrupted([&] { return ::pread(fd, span.data(), span.size(), static_cast<off_t>(place)); });
    if (got <= 0) return failed("read the written bytes back", got < 0 ? errno : EIO);
    place += static_cast<std::uint64_t>(got);
    span = span.subspan(static_cast<std::size_t>(got));
  }
  return {};
}

// Hashes the file as it is on disk. Call it when the buffer is empty.
Result<void> OutputFile::State::hash_again() {
  hasher.emplace();
  for (std::uint64_t done = 0; done < bytes;) {
    const auto block = buffer.span().first(std::min<std::uint64_t>(buffer.size(), bytes - done));
    TRY(read_from(done, block));
    hasher->add(block);
    done += block.size();
  }
  return {};
}

// Does everything that can fail for lack of space; only a rename remains.
Result<void> OutputFile::State::prepare() {
  TRY(flush());
  if (kind == Kind::file && keeps_hash && !hasher) TRY(hash_again());
  if (kind == Kind::standard_output) return {};
  if (kind == Kind::file && temporary.empty()) {
    auto name = TemporaryName::name_file(folder, fd);
    if (!name) return failed("give the written file a name", errno);
    temporary = std::move(*name);
  }
  // Some network file systems report failed writes only here. On Linux, an interrupted close() has closed the
  // descriptor.
  if (::close(std::exchange(fd, -1)) != 0 && errno != EINTR) return failed("close the file", errno);
  return {};
}

Result<void> OutputFile::State::publish() {
  if (kind != Kind::file) return {};
  if (!temporary.rename_to(target)) return failed("give the written file its name", errno);
  return {};
}

Result<bool> remove_old_file(const fs::path& path) {
  if (!is_old_file(path)) return false;
  const fs::path target = follow_links(path);
  if (may_replace(target) && ::unlink(target.c_str()) == 0) return true;
  return tl::unexpected<Error>(system_error(path.string(), "remove the old file", errno));
}

Result<std::optional<fs::path>> rename_old_file(const fs::path& path) {
  if (!is_old_file(path)) return std::nullopt;
  const fs::path target = follow_links(path);
  const auto failed = [&](int code) {
    return tl::unexpected<Error>(system_error(path.string(), "rename the old file", code));
  };
  if (!may_replace(target)) return failed(errno);
  for (int number = 1; number <= kMostOldFiles; ++number) {
    fs::path old = target.string() + (number == 1 ? ".old" : fmt::format(".old.{}", number));
    if (::renameat2(AT_FDCWD, target.c_str(), AT_FDCWD, old.c_str(), RENAME_NOREPLACE) == 0) return old;
    if (errno == EEXIST) continue;
    if (errno != EINVAL && errno != ENOSYS) return failed(errno);
    // The file system does not support RENAME_NOREPLACE.
    struct stat taken {};
    if (::lstat(old.c_str(), &taken) == 0) continue;
    if (::rename(target.c_str(), old.c_str()) == 0) return old;
    return failed(errno);
  }
  return failed(EEXIST);
}

bool is_stream(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return path == "-" || (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status));
}

bool is_same_output(const fs::path& a, const fs::path& b) {
  struct stat one {};
  struct stat other {};
  if (status_of(a, one) && status_of(b, other)) {
    const bool same = one.st_dev == other.st_dev && one.st_ino == other.st_ino;
    struct stat nowhere {};  // /dev/null, where no data can be lost
    const bool is_lost = S_ISCHR(one.st_mode) && ::stat("/dev/null", &nowhere) == 0 && one.st_rdev == nowhere.st_rdev;
    return same && !is_lost;
  }
  if (a == "-" || b == "-") return a == b;
  const auto place = [](const fs::path& path) {
    std::error_code none;
    return fs::weakly_canonical(fs::absolute(follow_links(path), none), none);
  };
  return place(a) == place(b);
}

bool is_there(const fs::path& path) {
  std::error_code none;
  return fs::exists(path, none);
}

std::string output_label(const fs::path& path) { return path == "-" ? "standard output" : path.string(); }

Result<OutputFile> OutputFile::create(const fs::path& path) { return open(path, false); }
Result<OutputFile> OutputFile::create_shared(const fs::path& path) { return open(path, true); }

Result<OutputFile> OutputFile::join(const fs::path& path, const std::string& shared_name) {
  auto state = std::make_unique<State>();
  state->kind = State::Kind::joined;
  state->shown = output_label(path);
  state->fd = retry_interrupted([&] { return ::open(shared_name.c_str(), O_WRONLY | O_CLOEXEC); });
  if (state->fd < 0) {
    auto failed = state->failed(fmt::format("open {} for writing", shared_name), errno);
    failed.value().hint = "the folder must be on a file system that all machines share";
    return failed;
  }
  return OutputFile(std::move(state));
}

std::string OutputFile::shared_name() const { return fs::absolute(state_->temporary.c_str()).string(); }

Result<OutputFile> OutputFile::open(const fs::path& path, bool is_shared) {
  auto state = std::make_unique<State>();
  state->is_shared = is_shared;
  state->buffer = Buffer<std::byte>(kBufferBytes);
  state->shown = output_label(path);
  if (path == "-") {
    state->kind = State::Kind::standard_output;
    state->fd = STDOUT_FILENO;
    return OutputFile(std::move(state));
  }
  struct stat found {};
  const bool exists = ::stat(path.c_str(), &found) == 0;
  if (!exists && errno != ENOENT) return state->failed("write", errno);
  if (exists && S_ISDIR(found.st_mode)) {
    return fail(ErrorCode::output, fmt::format("{}: expected a file, found a folder", state->shown), "add a file name");
  }
  const auto old_mode = exists ? std::optional<mode_t>(found.st_mode & kPermissionBits) : std::nullopt;
  auto opened = exists && !S_ISREG(found.st_mode) ? state->open_device(path) : state->open_file(path, old_mode);
  if (!opened) return tl::unexpected<Error>(std::move(opened.error()));
  return OutputFile(std::move(state));
}

OutputFile::OutputFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
OutputFile::OutputFile(OutputFile&&) noexcept = default;
OutputFile& OutputFile::operator=(OutputFile&&) noexcept = default;
OutputFile::~OutputFile() = default;

Result<void> OutputFile::write(std::span<const std::byte> bytes) {
  State& state = *state_;
  if (state.failure) return tl::unexpected<Error>(*state.failure);
  state.bytes += bytes.size();
  if (state.kind == State::Kind::joined) return {};
  if (state.hasher) state.hasher->add(bytes);
  if (bytes.size() >= kUnbufferedBytes) {
    TRY(state.flush());
    return state.write_through(bytes);
  }
  if (bytes.size() > state.buffer.size() - state.buffered) {
    TRY(state.flush());
  }
  std::copy(bytes.begin(), bytes.end(), state.buffer.begin() + state.buffered);
  state.buffered += bytes.size();
  return {};
}

Result<void> OutputFile::write(std::string_view text) { return write(std::as_bytes(std::span(text))); }

Result<std::uint64_t> OutputFile::extend(std::uint64_t count) {
  State& state = *state_;
  const std::uint64_t place = state.bytes;
  if (state.kind == State::Kind::joined) {
    state.bytes += count;
    return place;
  }
  TRY(state.prepare_change());
  TRY(state.set_size(place + count));
  return place;
}

Result<void> OutputFile::resize(std::uint64_t size) {
  TRY(state_->prepare_change());
  return state_->set_size(size);
}

Result<void> OutputFile::fill(std::uint64_t place, std::span<const std::byte> bytes) const {
  const int code = write_at(state_->fd, place, bytes);
  if (code != 0) return tl::unexpected<Error>(system_error(state_->shown, "write", code));
  return {};
}

Result<void> OutputFile::overwrite(std::uint64_t place, std::span<const std::byte> bytes) {
  TRY(state_->prepare_change());
  return state_->write_to(place, bytes);
}

Result<void> OutputFile::move_end(std::uint64_t from, std::uint64_t to) {
  State& state = *state_;
  if (auto ready = state.prepare_change(); !ready || from == to) return ready;
  const std::uint64_t count = state.bytes - from;
  // The buffer is empty here. The order of the blocks ensures that none is overwritten before it was read.
  const std::span<std::byte> block(state.buffer.span());
  for (std::uint64_t done = 0; done < count;) {
    const std::size_t size = std::min<std::uint64_t>(block.size(), count - done);
    const std::uint64_t at = to < from ? done : count - done - size;
    TRY(state.read_from(from + at, block.first(size)));
    TRY(state.write_to(to + at, block.first(size)));
    done += size;
  }
  return state.set_size(to + count);
}

void OutputFile::keep_hash() {
  state_->keeps_hash = true;
  state_->hasher.emplace();
}

std::optional<std::string> OutputFile::hash() const {
  return state_->hasher ? std::optional(state_->hasher->hash()) : std::nullopt;
}

std::uint64_t OutputFile::bytes_written() const { return state_->bytes; }

const std::string& OutputFile::shown_name() const { return state_->shown; }

Result<void> OutputFile::commit() {
  TRY(state_->prepare());
  return state_->publish();
}

Result<void> OutputFile::commit_all(std::span<OutputFile* const> files) {
  for (OutputFile* file : files) {
    TRY(file->state_->prepare());
  }
  std::vector<TemporaryName> old(files.size());  // second names of the files to be replaced
  for (std::size_t f = 0; f < files.size(); ++f) {
    State& state = *files[f]->state_;
    if (state.replaces && f + 1 < files.size()) {
      if (auto name = TemporaryName::add_second_name(state.folder, state.target)) old[f] = std::move(*name);
    }
    Result<void> published = state.publish();
    if (published) continue;
    while (f-- > 0) {
      State& before = *files[f]->state_;
      if (!old[f].empty()) {
        const std::string name = old[f].c_str();
        if (!old[f].rename_to(before.target)) {
          old[f].keep();
          published.error().message += fmt::format("; the previous file {} is now {}", before.shown, name);
        }
      } else if (before.kind == State::Kind::file && !before.replaces) {
        ::unlink(before.target.c_str());
      }
    }
    return published;
  }
  return {};
}

Result<void> OutputFile::commit_pair(OutputFile& first, OutputFile& last) {
  return commit_all(std::array{&first, &last});
}

void OutputFile::remove_unfinished() noexcept { TemporaryName::remove_all(); }

Result<void> write_file(const fs::path& path, std::string_view text) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected<Error>(std::move(file.error()));
  TRY(file->write(text));
  return file->commit();
}

}  // namespace isoextract::files
