// Words for the values of an enum, declared beside the enum. Options, reports and jobs spell each value the same way.
//
//   enum class Space { world, index };
//   constexpr auto words_of(Space) { return std::array{Word{Space::world, "world"}, Word{Space::index, "index"}}; }
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace isoextract {

template <class E>
struct Word {
  E value;
  std::string_view word;
};
template <class E>
Word(E, const char*) -> Word<E>;

// Returns the word of `value`, or an empty text if a cast made a value that the enum does not have.
template <class E>
[[nodiscard]] constexpr std::string_view word_of(E value) {
  for (const Word<E>& entry : words_of(E{})) {
    if (entry.value == value) return entry.word;
  }
  return {};
}

// Returns the value that `word` names, or nothing.
template <class E>
[[nodiscard]] constexpr std::optional<E> value_of(std::string_view word) {
  for (const Word<E>& entry : words_of(E{})) {
    if (entry.word == word) return entry.value;
  }
  return std::nullopt;
}

}  // namespace isoextract
