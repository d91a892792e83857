#include "files/content_hash.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <memory>
#include <span>

#include <fmt/format.h>

// The hash is compiled into this file: the library is not needed when the program runs.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/buffer.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::files {
namespace {

std::string text_of(const XXH128_hash_t& hash) { return fmt::format("{:016x}{:016x}", hash.high64, hash.low64); }

std::int64_t modified(const struct stat& status) {
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  return status.st_mtim.tv_sec * kNanoseconds + status.st_mtim.tv_nsec;
}

}  // namespace

Result<FileState> state_of_file(const std::filesystem::path& path) {
  const auto file = InputFile::open(path);
  if (!file) return tl::unexpected(file.error());
  struct stat before {};
  struct stat after {};
  constexpr std::uint64_t kPiece = 1 << 20;
  FileState state;
  state.bytes = file->size();
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash(XXH3_createState(), XXH3_freeState);
  if (hash == nullptr) return fail(ErrorKind::input, fmt::format("{}: not enough memory", path.string()));
  XXH3_128bits_reset(hash.get());
  Buffer<std::byte> piece(std::min(kPiece, state.bytes));
  const bool known = ::fstat(file->descriptor(), &before) == 0;
  for (std::uint64_t at = 0; at < state.bytes; at += piece.size()) {
    const std::span<std::byte> bytes = piece.span().first(std::min<std::uint64_t>(piece.size(), state.bytes - at));
    if (auto read = file->read_at(at, bytes); !read) return tl::unexpected(read.error());
    XXH3_128bits_update(hash.get(), bytes.data(), bytes.size());
  }
  if (!known || ::fstat(file->descriptor(), &after) != 0 || modified(before) != modified(after) ||
      after.st_size != before.st_size) {
    return fail(ErrorKind::input, fmt::format("{}: it changed while it was looked at", path.string()));
  }
  state.modified = modified(after);
  state.hash = text_of(XXH3_128bits_digest(hash.get()));
  return state;
}

std::string content_hash(std::string_view text) { return text_of(XXH3_128bits(text.data(), text.size())); }

}  // namespace isoextract::files
