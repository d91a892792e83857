// The language of --select: a condition on the attributes and the position of a particle, such as `type == 2 && z >
// 10`.
//
//   condition   or, ||; and, &&; not, !; comparisons == != < <= > >=; `in {O, H}`, `in 1..5`, `in {1, 4..6}`
//   number      + - * /, abs, sqrt, min, max, |v| or length(v): the length of a vector, or the absolute value
//   name        x, y, z: the position; others are attributes: type, v[0], v.x, `odd name`, 'odd name'
//   word        bare or quoted, to the right of == and != or within {}, where the attribute on the left holds words
//
// `and` binds closer than `or`. Ranges include both ends. The names species, element and symbol, without quotes, mean
// the same attribute.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace isoextract::points {

inline constexpr std::size_t kMaxSelectionBytes = 65536;
inline constexpr int kMaxSelectionDepth = 100;  // of parentheses and signs

enum class SelectionOp {
  number,
  name,
  length,
  negate,
  add,
  subtract,
  multiply,
  divide,
  abs,
  sqrt,
  min,
  max,
  equal,
  not_equal,
  less,
  less_equal,
  greater,
  greater_equal,
  in_set,
  invert,
  both,
  either,
};

// One element of a set: a word, a number, or all numbers of a range.
struct SelectionItem {
  std::string word;  // as written, without quotes; empty for ranges
  bool is_number = false;
  double low = 0;
  double high = 0;
};

struct SelectionStep {
  SelectionOp op = SelectionOp::number;
  std::size_t offset = 0;                     // in the text, in bytes
  double number = 0;                          // of SelectionOp::number
  std::string word = {};                      // name, or number as written
  bool bare = false;                          // a name without quotes
  std::optional<std::size_t> component = {};  // of a name: v[1], v.y
  std::string spelled = {};                   // name with its component, as written
  std::vector<SelectionItem> items = {};
};

// An attribute that a condition may refer to.
struct SelectionName {
  std::vector<std::string> names;  // the first one that exists counts
  bool required = true;            // false: the name may be a word instead
  std::string mark;                // SelectionExpression::mark() of its place
};

class SelectionExpression {
 public:
  // Fails with ErrorCode::usage if the text is not a condition, is longer than kMaxSelectionBytes, or is nested deeper
  // than kMaxSelectionDepth. The hint shows the place.
  [[nodiscard]] static Result<SelectionExpression> parse(std::string_view text);

  [[nodiscard]] const std::string& text() const { return text_; }
  // Returns the attributes to read, without the position.
  [[nodiscard]] std::vector<SelectionName> names() const;
  // Returns the operations in postfix order: operands before their operation.
  [[nodiscard]] const std::vector<SelectionStep>& steps() const { return steps_; }
  // Returns a hint of three lines: the second is the text around the place, the third has a caret below the place.
  [[nodiscard]] std::string mark(std::size_t place) const;

 private:
  std::string text_;
  std::vector<SelectionStep> steps_;
};

// Returns the attributes that a name with its component may mean, the most likely first.
[[nodiscard]] std::vector<std::string> meanings_of(const SelectionStep& name);
// Returns 0, 1 or 2 if the step is the name of a coordinate.
[[nodiscard]] std::optional<std::size_t> axis_of(const SelectionStep& name);

// Returns the word as a condition writes it, in quotes of a kind that does not occur in the word. The word must not
// contain all of ' " `.
[[nodiscard]] std::string word_in_selection(std::string_view word);

}  // namespace isoextract::points
