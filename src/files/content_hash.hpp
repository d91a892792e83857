// What a file holds, as a short text: to tell later whether it still does.
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

namespace isoextract::files {

struct FileState {
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  // nanoseconds since 1970
  std::string hash;           // 32 hexadecimal digits: XXH3, 128 bits, of its bytes

  friend bool operator==(const FileState&, const FileState&) = default;
};

// Fails with ErrorCode::input where the file cannot be read, or changes meanwhile. What is read does not count in the
// context.
[[nodiscard]] Result<FileState> state_of_file(const std::filesystem::path& path, const Context& context);

// The hash of bytes as they come.
class ContentHasher {
 public:
  ContentHasher();
  ContentHasher(ContentHasher&&) noexcept;
  ContentHasher& operator=(ContentHasher&&) noexcept;
  ~ContentHasher();

  void add(std::span<const std::byte> bytes);
  // Returns the hash of all bytes that were added.
  [[nodiscard]] std::string hash() const;

 private:
  struct Free {
    void operator()(void* state) const;
  };
  std::unique_ptr<void, Free> state_;
};

// 32 hexadecimal digits of a text, the same way.
[[nodiscard]] std::string content_hash(std::string_view text);

}  // namespace isoextract::files
