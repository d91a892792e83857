// Lists the names in a folder.
#pragma once

#include <filesystem>
#include <string>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/printable.hpp"

namespace isoextract::files {

// Calls visit(name, entry) for each entry of `folder` ("" is the current one), in no order. Fails with ErrorCode::input
// if reading fails, also after some entries.
template <class Visit>
[[nodiscard]] Result<void> visit_folder(const std::string& folder, Visit&& visit) {
  std::error_code error;
  std::filesystem::directory_iterator entries(folder.empty() ? "." : folder, error);
  while (!error && entries != std::filesystem::directory_iterator()) {
    visit(entries->path().filename().string(), *entries);
    entries.increment(error);
  }
  if (!error) return {};
  return fail(ErrorCode::input,
              fmt::format("{}: cannot read the folder: {}", folder.empty() ? "." : printable(folder), error.message()));
}

}  // namespace isoextract::files
