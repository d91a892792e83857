// Checks and makes the folders of outputs.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "base/error.hpp"

namespace isoextract::cli {

// Returns whether `output` is an existing folder or ends with a slash.
[[nodiscard]] bool is_folder(const std::string& output);

// Checks that the folders of the files exist. With `make`, makes missing folders and their parents instead. Fails with
// ErrorCode::output if a folder is missing or cannot be made.
[[nodiscard]] Result<void> check_or_make_folders(std::span<const std::filesystem::path> files, bool make);

}  // namespace isoextract::cli
