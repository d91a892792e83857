#include "files/file_start.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/printable.hpp"

namespace isoextract::files {

bool starts_with(std::span<const std::byte> content, std::string_view magic) {
  return content.size() >= magic.size() &&
         std::equal(magic.begin(), magic.end(), content.begin(),
                    [](char m, std::byte b) { return static_cast<std::byte>(m) == b; });
}

bool is_tar(std::span<const std::byte> content) {
  constexpr std::size_t kSignature = 257;  // its offset
  return content.size() > kSignature && starts_with(content.subspan(kSignature), "ustar");
}

tl::unexpected<Error> bad_signature_error(const InputFile& file, std::string_view format, std::string_view expected) {
  const auto content = first_bytes(file, kStartBytes);
  return fail(ErrorCode::input, fmt::format("{}: not {}: expected {} at the start, found '{}'", file.name(), format,
                                            expected, content ? printable(*content, 16) : std::string()));
}

}  // namespace isoextract::files
