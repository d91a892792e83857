// Groups names into sequences: names that differ in one number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace isoextract::batch {

// Stands for each number in a skeleton (a name without its numbers). No path contains this character.
inline constexpr char kNumberMark = '\0';

// Returns whether `c` is a letter or digit. Bytes beyond ASCII count as letters.
[[nodiscard]] bool is_part_of_word(char c);

struct SequenceMember {
  std::size_t name = 0;  // index of the name
  std::int64_t number = 0;
};

struct Sequence {
  std::vector<SequenceMember> members;  // in the order of the names
  // Pattern that FramePattern::parse() takes; for a single name, the name itself, not escaped.
  std::string pattern;
};

// Groups the names; each is in one sequence. Sequences are in the order of their first names. If names differ in
// several groups of digits, the last of these is the frame number, and names that differ in another one are in
// different sequences.
//
// A minus sign is part of the number unless it follows a letter or digit in all names of the sequence. More than
// kMaxFrameDigits digits are no number. Numbers may repeat (f_1, f_01). A single name has trailing_number(), or else 1.
[[nodiscard]] std::vector<Sequence> sequences_of(std::span<const std::string> names);

// Returns the last number in the file name, not in its extension: 42 for shot_3/sim_042.vdb. Returns nullopt if there
// is none.
[[nodiscard]] std::optional<std::int64_t> trailing_number(std::string_view path);

}  // namespace isoextract::batch
