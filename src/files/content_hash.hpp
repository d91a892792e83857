// What a file holds, as a short text: to tell later whether it still does.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract::files {

struct FileState {
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  // nanoseconds since 1970
  std::string hash;           // 32 hexadecimal digits: XXH3, 128 bits, of its bytes

  friend bool operator==(const FileState&, const FileState&) = default;
};

// Fails with ErrorCode::input where the file cannot be read, or changes meanwhile.
[[nodiscard]] Result<FileState> state_of_file(const std::filesystem::path& path);

// 32 hexadecimal digits of a text, the same way.
[[nodiscard]] std::string content_hash(std::string_view text);

}  // namespace isoextract::files
