// The folders that outputs go to.
#pragma once

#include <filesystem>
#include <span>

#include "base/error.hpp"

namespace isoextract::cli {

// Sees that the folders of the files are there: makes them if `make` says so. Fails with ErrorCode::output.
[[nodiscard]] Result<void> see_to_folders(std::span<const std::filesystem::path> files, bool make);

}  // namespace isoextract::cli
