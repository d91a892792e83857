// A choice among the labels of a label map by numbers, ranges and names.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isoextract::convert {

class LabelSelection {
 public:
  // Parses terms with commas between them:
  //
  //   7 or -7        a number
  //   1-40           a range of numbers, both ends included
  //   Hippocampus*   names; * stands for any text, ? for any character; upper and lower case differ
  //   all            every label
  //   !TERM          not these labels, whatever the other terms say
  //
  // Selects all other labels if all terms begin with "!". Returns nullopt for an empty term or a range that ends before
  // it begins.
  [[nodiscard]] static std::optional<LabelSelection> parse(std::string_view text);

  // Returns whether the selection has the label. `name`: empty if the label has none. Remembers which terms matched.
  [[nodiscard]] bool contains(std::int64_t label, std::string_view name);

  // Returns whether it is one name, without "!", * and ?. Several labels can still have that name.
  [[nodiscard]] bool is_one_name() const;

  struct UnmatchedTerm {
    std::string text;
    bool is_one_label = false;  // a number, or a name without * and ?

    friend bool operator==(const UnmatchedTerm&, const UnmatchedTerm&) = default;
  };
  // Returns the terms without "!" that no label matched so far, as they were given.
  [[nodiscard]] std::vector<UnmatchedTerm> unmatched() const;

 private:
  struct Term {
    std::string text;
    bool excludes = false;
    bool is_name = false;
    std::int64_t first = 0;
    std::int64_t last = 0;
    bool matched = false;
  };
  std::vector<Term> terms_;
  bool only_excludes_ = true;
};

}  // namespace isoextract::convert
