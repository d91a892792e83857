// Requirements that the fuzz targets check on readers. A violation ends the target, and libFuzzer keeps its input.
#pragma once

#include <cstdlib>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract::fuzz {

inline void require(bool holds) {
  if (!holds) std::abort();
}

// Damaged files may ask for more memory than there is, or begin like packed files, whose plug-in the targets lack.
inline void require_refusal(const Error& error, std::string_view file) {
  const bool is_packed = error.code == ErrorCode::unavailable && error.message.find("plug-in") != std::string::npos;
  require(error.code == ErrorCode::input || error.code == ErrorCode::out_of_memory || is_packed);
  require(error.message.starts_with(file));
}

}  // namespace isoextract::fuzz
