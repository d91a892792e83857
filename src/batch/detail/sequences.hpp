// Which names belong together: those that differ in one number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace isoextract::batch {

// Stands for a number in the skeleton of a name; no path holds it.
inline constexpr char kNumberMark = '\0';

// Whether `c` is a letter or a digit. Bytes of other scripts are letters.
[[nodiscard]] bool is_part_of_word(char c);

struct SequenceMember {
  std::size_t name = 0;  // which of the names
  std::int64_t number = 0;
};

struct Sequence {
  std::vector<SequenceMember> members;  // in the order of the names
  std::string pattern;                  // as FramePattern::parse() takes it; of a single name that name, unescaped
};

// Each name is in one sequence; sequences come in the order of their first names. Where names differ in several groups
// of digits, the last of these numbers the frames, and names that differ in another one are of different sequences. A
// sign is part of a number where it follows none of letters and digits, or where not all names have it. Digits beyond
// kMaxFrameDigits are no number. Numbers may repeat (f_1, f_01). The number of a single name is single_number() of it.
[[nodiscard]] std::vector<Sequence> sequences_of(std::span<const std::string> names);

// The last group of digits in the name of the file, which is not in its extension: 42 of shot_3/sim_042.vdb. Nothing
// where there is none.
[[nodiscard]] std::optional<std::int64_t> single_number(std::string_view path);

}  // namespace isoextract::batch
