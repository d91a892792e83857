// Reads small text files as a whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/context.hpp"
#include "base/error.hpp"

namespace isoextract::files {

// Returns the whole file. Fails as InputFile::open() and read_at() do, so also for an empty file. Fails with
// ErrorCode::input, before it allocates memory, if the file is longer than `most` bytes. Fails as Context::reserve()
// does. `what` describes the file in the message: "a table of labels".
[[nodiscard]] Result<std::string> read_text_file(const std::filesystem::path& path, std::string_view what,
                                                 std::uint64_t most, const Context& context);

}  // namespace isoextract::files
