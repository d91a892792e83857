// Counts with their nouns.
#pragma once

#include <string>
#include <string_view>

#include <fmt/format.h>

namespace isoextract {

// Returns "1 hole", "2 holes" or "1.5 holes"; `many` is the plural of nouns that take more than an s.
template <class Number>
[[nodiscard]] std::string counted(Number count, std::string_view one, std::string_view many = {}) {
  if (count == Number{1}) return fmt::format("{} {}", count, one);
  return many.empty() ? fmt::format("{} {}s", count, one) : fmt::format("{} {}", count, many);
}

}  // namespace isoextract
