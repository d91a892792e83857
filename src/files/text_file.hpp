// Small files of text, as a whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/context.hpp"
#include "base/error.hpp"

namespace isoextract::files {

// All of a text file. Fails with ErrorCode::input where it is longer than `most` bytes, before memory is taken; `what`
// stands for it in the message: "a table of labels".
[[nodiscard]] Result<std::string> read_text_file(const std::filesystem::path& path, std::string_view what,
                                                 std::uint64_t most, const Context& context);

}  // namespace isoextract::files
