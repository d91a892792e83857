// Size, time and hash of a file's content, to detect later changes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/context.hpp"
#include "base/error.hpp"
#include "files/file_part.hpp"

namespace isoextract::files {

struct ContentState {
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  // nanoseconds since 1970
  std::string hash;           // XXH3 of the content, 128 bits as 32 hexadecimal digits

  friend bool operator==(const ContentState&, const ContentState&) = default;
};

// Returns the file's state. Reads the file, unless the state is among the 16 used last in this process and the file has
// not changed since. Fails as InputFile::open() and read_at() do, and with ErrorCode::input if the file changes
// meanwhile. The context does not count the bytes read.
[[nodiscard]] Result<ContentState> hash_file(const std::filesystem::path& path, const Context& context);

// Returns the file's size and modification time with the hash of the part's ranges only. Reads them at every call, and
// does not check whether the file changes meanwhile. Fails as InputFile::open() and read_at() do, and with
// ErrorCode::input if a range exceeds the file. Without ranges, works exactly as hash_file() does.
[[nodiscard]] Result<ContentState> hash_part(const FilePart& part, const Context& context);

// Hashes bytes incrementally.
class ContentHasher {
 public:
  ContentHasher();
  ContentHasher(ContentHasher&&) noexcept;
  ContentHasher& operator=(ContentHasher&&) noexcept;
  ~ContentHasher();

  void add(std::span<const std::byte> bytes);
  // Returns the hash of all bytes added so far.
  [[nodiscard]] std::string hash() const;

 private:
  struct Free {
    void operator()(void* state) const;
  };
  std::unique_ptr<void, Free> state_;
};

// Returns the hash of a text as 32 hexadecimal digits.
[[nodiscard]] std::string content_hash(std::string_view text);

}  // namespace isoextract::files
