#include "files/text_file.hpp"

#include <span>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::files {

Result<std::string> read_text_file(const std::filesystem::path& path, std::string_view what, std::uint64_t most,
                                   const Context& context) {
  const auto file = TRY(InputFile::open(path, context));
  if (file.size() > most) {
    return fail(ErrorCode::input, fmt::format("{}: expected {} of at most {}, found {}", file.name(), what,
                                              format_byte_size(most), format_byte_size(file.size())));
  }
  auto memory = TRY(context.reserve(file.size(), file.name()));
  std::string text(static_cast<std::size_t>(file.size()), '\0');
  TRY(file.read_at(0, std::as_writable_bytes(std::span(text))));
  return text;
}

}  // namespace isoextract::files
