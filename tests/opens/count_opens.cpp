// A library to preload. It writes lines "NUMBER WAY PATH" into the file that COUNT_OPENS names. For each file that the
// process opens it writes a line "1 read PATH" or "1 write PATH". When the file is closed or the process ends, it
// writes the bytes that calls read from the file ("BYTES bytes PATH"). Mapped files are read without calls.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

constexpr int kMostDescriptors = 4096;
constexpr std::size_t kMostPath = 1024;

struct Opened {
  std::array<char, kMostPath> path{};
  std::atomic<std::uint64_t> bytes{0};
};
std::array<Opened, kMostDescriptors> opened;

bool is_known(int descriptor) {
  return descriptor >= 0 && descriptor < kMostDescriptors && opened[descriptor].path[0] != '\0';
}

void note(unsigned long long number, const char* way, const char* path) {
  const char* const log = std::getenv("COUNT_OPENS");
  if (log == nullptr) return;
  std::array<char, kMostPath + 64> line{};
  const int length = std::snprintf(line.data(), line.size(), "%llu %s %s\n", number, way, path);
  const long file = ::syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) return;
  static_cast<void>(::syscall(SYS_write, file, line.data(), length));
  ::syscall(SYS_close, file);
}

int note_opened(int descriptor, const char* path, int flags) {
  if (descriptor < 0 || (flags & O_DIRECTORY) != 0) return descriptor;
  note(1, (flags & O_ACCMODE) == O_RDONLY ? "read" : "write", path);
  if (descriptor < kMostDescriptors) {
    std::snprintf(opened[descriptor].path.data(), kMostPath, "%s", path);
    opened[descriptor].bytes = 0;
  }
  return descriptor;
}

void note_closed(int descriptor) {
  if (!is_known(descriptor)) return;
  note(opened[descriptor].bytes, "bytes", opened[descriptor].path.data());
  opened[descriptor].path[0] = '\0';
}

ssize_t note_read(int descriptor, ssize_t got) {
  if (got > 0 && is_known(descriptor)) opened[descriptor].bytes += static_cast<std::uint64_t>(got);
  return got;
}

mode_t mode_of(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

int open_at(int folder, const char* path, int flags, va_list arguments) {
  const mode_t mode = mode_of(flags, arguments);
  return note_opened(static_cast<int>(::syscall(SYS_openat, folder, path, flags, mode)), path, flags);
}

struct AtTheEnd {
  ~AtTheEnd() {
    for (int descriptor = 0; descriptor < kMostDescriptors; ++descriptor) note_closed(descriptor);
  }
} at_the_end;

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const int descriptor = open_at(AT_FDCWD, path, flags, arguments);
  va_end(arguments);
  return descriptor;
}
int open64(const char* path, int flags, ...) __attribute__((alias("open")));

int openat(int folder, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const int descriptor = open_at(folder, path, flags, arguments);
  va_end(arguments);
  return descriptor;
}
int openat64(int folder, const char* path, int flags, ...) __attribute__((alias("openat")));

FILE* fopen(const char* path, const char* mode) {
  using Function = FILE* (*)(const char*, const char*);
  static const auto next = reinterpret_cast<Function>(::dlsym(RTLD_NEXT, "fopen"));
  FILE* const file = next(path, mode);
  if (file != nullptr) note_opened(::fileno(file), path, std::strchr(mode, 'r') != nullptr ? O_RDONLY : O_WRONLY);
  return file;
}
FILE* fopen64(const char* path, const char* mode) __attribute__((alias("fopen")));

int close(int descriptor) {
  note_closed(descriptor);
  return static_cast<int>(::syscall(SYS_close, descriptor));
}

ssize_t read(int descriptor, void* bytes, std::size_t count) {
  return note_read(descriptor, ::syscall(SYS_read, descriptor, bytes, count));
}
ssize_t pread(int descriptor, void* bytes, std::size_t count, off_t place) {
  return note_read(descriptor, ::syscall(SYS_pread64, descriptor, bytes, count, place));
}
ssize_t pread64(int descriptor, void* bytes, std::size_t count, off64_t place) __attribute__((alias("pread")));

}  // extern "C"
