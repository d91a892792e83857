// The words of an enum, beside the enum: options, reports and jobs spell a value in one way.
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

// Every value has a word; one that was made by a cast has none, and comes out empty.
template <class E>
[[nodiscard]] constexpr std::string_view word_of(E value) {
  for (const Word<E>& entry : words_of(E{})) {
    if (entry.value == value) return entry.word;
  }
  return {};
}

template <class E>
[[nodiscard]] constexpr std::optional<E> value_of(std::string_view word) {
  for (const Word<E>& entry : words_of(E{})) {
    if (entry.word == word) return entry.value;
  }
  return std::nullopt;
}

}  // namespace isoextract
