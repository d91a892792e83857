#include "files/detail/temporary_name.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "files/detail/retry_interrupted.hpp"

namespace isoextract::files {
namespace {

namespace fs = std::filesystem;

// Names for the signal handler. A remover first takes the name out of its slot, so a file is removed once. Names
// beyond the last slot are invisible to the handler and left to the next run.
constexpr std::size_t kSlots = 256;
constinit std::array<std::atomic<const std::string*>, kSlots> slots{};
constinit std::atomic<int> being_made{0};
constinit std::atomic<bool> ending{false};
static_assert(std::atomic<const std::string*>::is_always_lock_free);

// Blocks signals on this thread while a file exists whose name is in no slot. The handler waits for that moment to end,
// so it must not run on this thread.
class Making {
 public:
  Making() {
    sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before_);
    being_made.fetch_add(1);
  }
  Making(const Making&) = delete;
  Making& operator=(const Making&) = delete;
  ~Making() {
    being_made.fetch_sub(1);
    ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }

 private:
  sigset_t before_{};
};

int put_into_slot(const std::string* name) {
  for (std::size_t s = 0; s < kSlots; ++s) {
    const std::string* none = nullptr;
    if (slots[s].compare_exchange_strong(none, name)) return static_cast<int>(s);
  }
  return -1;
}

// Contains the host name, to tell apart files of different machines in a shared folder.
const std::string& name_prefix() {
  static const std::string prefix = [] {
    std::array<char, 65> host{};
    if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
    std::string name(host.data());
    for (char& c : name) {
      const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '.';
      if (!plain) c = '_';
    }
    return ".isoextract-" + name + "-";
  }();
  return prefix;
}

// Returns the process in a name that has exactly this program's form: the prefix, then PID-N.
std::optional<pid_t> owner_of(std::string_view file_name) {
  const std::string& prefix = name_prefix();
  if (!file_name.starts_with(prefix)) return std::nullopt;
  file_name.remove_prefix(prefix.size());
  const char* const end = file_name.data() + file_name.size();
  pid_t pid = 0;
  const auto owner = std::from_chars(file_name.data(), end, pid);
  if (owner.ec != std::errc() || pid <= 0 || owner.ptr == end || *owner.ptr != '-') return std::nullopt;
  int number = -1;
  const auto last = std::from_chars(owner.ptr + 1, end, number);
  if (last.ec != std::errc() || last.ptr != end || number < 0) return std::nullopt;
  return pid;
}

// Removes the file only if no process owns it: its process does not exist, and its lock is free. The lock also works
// across containers, which do not see each other's processes. Without support for locks, the file stays.
void remove_abandoned(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return;
  struct stat found {};
  const bool own = ::fstat(fd, &found) == 0 && S_ISREG(found.st_mode) && found.st_uid == ::geteuid();
  struct stat named {};
  const bool locked = own && ::flock(fd, LOCK_EX | LOCK_NB) == 0;
  // Another process may have removed the file meanwhile, and a third one made its own under the same name.
  const bool same =
      locked && ::lstat(path.c_str(), &named) == 0 && named.st_dev == found.st_dev && named.st_ino == found.st_ino;
  if (same) ::unlink(path.c_str());
  ::close(fd);
}

void clean_once(const fs::path& folder) {
  static std::mutex mutex;
  static std::set<fs::path> cleaned;
  std::error_code error;
  const fs::path absolute = fs::absolute(folder, error);
  {
    const std::lock_guard lock(mutex);
    if (error || !cleaned.insert(absolute).second) return;
  }
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const auto owner = owner_of(entry->path().filename().native());
    if (owner && ::kill(*owner, 0) != 0 && errno == ESRCH) remove_abandoned(entry->path());
  }
}

}  // namespace

// Calls make(name) with new names until one is free. Allocates the name before the file exists, as a later failure
// could leave a file without an owner.
template <class Make>
std::optional<TemporaryName> TemporaryName::make(const fs::path& folder, Make make) {
  constexpr int kAttempts = 10000;
  for (int i = 0; i < kAttempts; ++i) {
    auto name =
        std::make_unique<const std::string>((folder / fmt::format("{}{}-{}", name_prefix(), ::getpid(), i)).string());
    const Making making;
    errno = EINTR;
    if (!ending && make(name->c_str())) {
      TemporaryName made;
      made.slot_ = put_into_slot(name.get());
      made.name_ = std::move(name);
      return made;
    }
    if (errno != EEXIST) return std::nullopt;
  }
  return std::nullopt;
}

std::optional<TemporaryName::File> TemporaryName::make_file(const fs::path& folder) {
  clean_once(folder);
  int fd = -1;
  int lock = -1;
  auto name = make(folder, [&](const char* fresh) {
    constexpr mode_t kNewFile = 0666;  // minus the umask
    fd = retry_interrupted([&] { return ::open(fresh, O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, kNewFile); });
    if (fd < 0) return false;
    // A second descriptor holds the lock, as the first is closed before the final rename.
    lock = ::fcntl(fd, F_DUPFD_CLOEXEC, 0);
    int reason = lock < 0 ? errno : 0;
    // Until it is locked, another process may remove the new file as one left behind.
    struct stat made {};
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) reason = EEXIST;
    if (::fstat(fd, &made) == 0 && made.st_nlink == 0) reason = EEXIST;
    if (reason == 0) return true;
    if (reason != EEXIST) ::unlink(fresh);
    if (lock >= 0) ::close(std::exchange(lock, -1));
    ::close(std::exchange(fd, -1));
    errno = reason;
    return false;
  });
  if (!name) return std::nullopt;
  name->lock_ = lock;
  return File{std::move(*name), fd};
}

std::optional<TemporaryName> TemporaryName::name_file(const fs::path& folder, int fd) {
  clean_once(folder);
  const std::string from = fmt::format("/proc/self/fd/{}", fd);
  auto name = make(folder, [&](const char* fresh) {
    return ::linkat(AT_FDCWD, from.c_str(), AT_FDCWD, fresh, AT_SYMLINK_FOLLOW) == 0;
  });
  if (!name) return std::nullopt;
  // The lock tells other containers that the owner is alive. Not all file systems have locks.
  name->lock_ = ::fcntl(fd, F_DUPFD_CLOEXEC, 0);
  if (name->lock_ >= 0) static_cast<void>(::flock(name->lock_, LOCK_EX | LOCK_NB));
  return name;
}

std::optional<TemporaryName> TemporaryName::add_second_name(const fs::path& folder, const fs::path& path) {
  return make(folder, [&](const char* fresh) { return ::link(path.c_str(), fresh) == 0; });
}

TemporaryName::TemporaryName(TemporaryName&& other) noexcept
    : name_(std::move(other.name_)), slot_(std::exchange(other.slot_, -1)), lock_(std::exchange(other.lock_, -1)) {}

TemporaryName& TemporaryName::operator=(TemporaryName&& other) noexcept {
  std::swap(name_, other.name_);
  std::swap(slot_, other.slot_);
  std::swap(lock_, other.lock_);
  return *this;
}

TemporaryName::~TemporaryName() {
  if (const auto name = take()) ::unlink(name->c_str());
  if (lock_ >= 0) ::close(lock_);
}

void TemporaryName::keep() {
  take();
  if (lock_ >= 0) ::close(std::exchange(lock_, -1));
}

bool TemporaryName::rename_to(const fs::path& target) {
  if (::rename(c_str(), target.c_str()) != 0) return false;
  keep();
  return true;
}

std::unique_ptr<const std::string> TemporaryName::take() noexcept {
  auto name = std::move(name_);
  const int slot = std::exchange(slot_, -1);
  const std::string* held = name.get();
  if (slot >= 0 && !slots[static_cast<std::size_t>(slot)].compare_exchange_strong(held, nullptr)) {
    static_cast<void>(name.release());  // a handler may still read it; the process is about to end
  }
  return name;
}

void TemporaryName::remove_all() noexcept {
  ending = true;
  // Waits for a file that another thread is making, but at most a second, as the file system may hang.
  for (int i = 0; i < 1000 && being_made != 0; ++i) ::poll(nullptr, 0, 1);
  for (std::atomic<const std::string*>& slot : slots) {
    if (const std::string* const name = slot.exchange(nullptr)) ::unlink(name->c_str());
  }
}

}  // namespace isoextract::files
