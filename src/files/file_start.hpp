// The first bytes of a file, from which formats recognize their files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::files {

inline constexpr std::size_t kStartBytes = 1024;
// The first kStartBytes of a file's content, or all of it if it is shorter. Owns neither the path nor the bytes.
struct FileStart {
  const std::filesystem::path& path;
  std::span<const std::byte> bytes;  // decompressed if the file is gzip
  bool packed = false;               // whether the file is gzip
};

[[nodiscard]] bool starts_with(std::span<const std::byte> content, std::string_view magic);

// Returns whether the content starts as a tar archive does (POSIX ustar).
[[nodiscard]] bool is_tar(std::span<const std::byte> content);

// Returns the error (ErrorCode::input) for a file that does not start with the signature of its format, which the
// extension or an option has chosen. The message names the format, the expected signature, and the first 16 bytes of
// the file (decompressed if it is gzip).
[[nodiscard]] tl::unexpected<Error> bad_signature_error(const InputFile& file, std::string_view format,
                                                        std::string_view expected);

}  // namespace isoextract::files
