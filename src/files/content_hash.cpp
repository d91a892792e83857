#include "files/content_hash.hpp"

#include <algorithm>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

// Compiles the hash into this file: no library is needed at run time.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/buffer.hpp"
#include "files/file_bytes.hpp"
#include "files/file_version.hpp"

namespace isoextract::files {
namespace {

std::string text_of(const XXH128_hash_t& hash) { return fmt::format("{:016x}{:016x}", hash.high64, hash.low64); }

// Caches the states of recent files, so that a file with thousands of frames is not hashed again for each frame's
// record.
class StateCache {
 public:
  std::optional<ContentState> find(const FileVersion& version) {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find(states_, version, &std::pair<FileVersion, ContentState>::first);
    if (found == states_.end()) return std::nullopt;
    std::rotate(found, found + 1, states_.end());  // the most recently used one goes last
    return states_.back().second;
  }
  void add(const FileVersion& version, const ContentState& state) {
    constexpr std::size_t kMost = 16;
    const std::lock_guard lock(mutex_);
    if (states_.size() == kMost) states_.erase(states_.begin());
    states_.emplace_back(version, state);
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<FileVersion, ContentState>> states_;
};

StateCache& known_states() {
  static StateCache known;
  return known;
}

Result<void> add_range(const InputFile& file, const ByteRange& range, ContentHasher& hasher) {
  constexpr std::uint64_t kPiece = 1 << 20;
  Buffer<std::byte> piece(std::min(kPiece, range.bytes));
  for (std::uint64_t done = 0; done < range.bytes; done += piece.size()) {
    const std::span<std::byte> bytes = piece.span().first(std::min<std::uint64_t>(piece.size(), range.bytes - done));
    TRY(file.read_at(range.offset + done, bytes));
    hasher.add(bytes);
  }
  return {};
}

}  // namespace

ContentHasher::ContentHasher() : state_(XXH3_createState()) {
  if (state_ == nullptr) throw std::bad_alloc();
  XXH3_128bits_reset(static_cast<XXH3_state_t*>(state_.get()));
}
ContentHasher::ContentHasher(ContentHasher&&) noexcept = default;
ContentHasher& ContentHasher::operator=(ContentHasher&&) noexcept = default;
ContentHasher::~ContentHasher() = default;

void ContentHasher::Free::operator()(void* state) const { XXH3_freeState(static_cast<XXH3_state_t*>(state)); }

void ContentHasher::add(std::span<const std::byte> bytes) {
  XXH3_128bits_update(static_cast<XXH3_state_t*>(state_.get()), bytes.data(), bytes.size());
}

std::string ContentHasher::hash() const {
  return text_of(XXH3_128bits_digest(static_cast<const XXH3_state_t*>(state_.get())));
}

Result<ContentState> hash_file(const std::filesystem::path& path, const Context& context) {
  const auto file = TRY(InputFile::open(path, context.beside()));
  const auto version = TRY(version_of(file));
  const bool settled = version.is_reliable();
  if (settled) {
    if (auto known = known_states().find(version)) return std::move(*known);
  }
  ContentHasher hasher;
  TRY(add_range(file, {0, file.size()}, hasher));
  TRY(check_unchanged(file, version));
  const ContentState state{file.size(), version.modified, hasher.hash()};
  if (settled) known_states().add(version, state);
  return state;
}

Result<ContentState> hash_part(const FilePart& part, const Context& context) {
  if (part.ranges.empty()) return hash_file(part.path, context);
  const auto file = TRY(InputFile::open(part.path, context.beside()));
  const auto version = TRY(version_of(file));
  ContentHasher hasher;
  for (const ByteRange& range : part.ranges) {
    const std::uint64_t found = file.size() - std::min(file.size(), range.offset);
    if (found < range.bytes) {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected {} bytes from byte {} on, found {}: the file became shorter during the run",
                              file.name(), range.bytes, range.offset, found));
    }
    TRY(add_range(file, range, hasher));
  }
  return ContentState{file.size(), version.modified, hasher.hash()};
}

std::string content_hash(std::string_view text) { return text_of(XXH3_128bits(text.data(), text.size())); }

}  // namespace isoextract::files
