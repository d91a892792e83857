#include "files/file_version.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>

#include <fmt/format.h>

#include "files/file_bytes.hpp"

namespace isoextract::files {

using namespace std::chrono_literals;

namespace {

std::int64_t nanoseconds(const timespec& time) {
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  return time.tv_sec * kNanoseconds + time.tv_nsec;
}

}  // namespace

FileVersion version_of(const struct ::stat& status) {
  return {status.st_dev, status.st_ino, static_cast<std::uint64_t>(status.st_size), nanoseconds(status.st_mtim),
          nanoseconds(status.st_ctim)};
}

bool FileVersion::is_reliable() const {
  const std::chrono::nanoseconds now = std::chrono::system_clock::now().time_since_epoch();
  // A program set a modification time in the future; the next write sets it back.
  const std::int64_t newest = std::chrono::nanoseconds(modified) > now ? changed : std::max(modified, changed);
  const std::chrono::nanoseconds tick = newest % 1'000'000'000 == 0 ? 2s : 100ms;
  return now - std::chrono::nanoseconds(newest) > tick;
}

std::optional<FileVersion> version_of(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return version_of(status);
}

Result<FileVersion> version_of(const InputFile& file) {
  struct stat status {};
  if (::fstat(file.descriptor(), &status) == 0) return version_of(status);
  return fail(ErrorCode::input,
              fmt::format("{}: cannot read the file: {}", file.name(), std::generic_category().message(errno)));
}

Result<void> check_unchanged(const InputFile& file, const FileVersion& before) {
  const auto now = TRY(version_of(file));
  if (now.bytes == before.bytes && now.modified == before.modified) return {};
  return fail(ErrorCode::input, fmt::format("{}: the file changed while the program read it", file.name()),
              "run again when no other program writes to the file");
}

}  // namespace isoextract::files
