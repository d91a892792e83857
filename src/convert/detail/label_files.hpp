// Names the files of labels if each label has its own file: the pattern contains kLabelPlaceholder or kNamePlaceholder.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_set>

namespace isoextract::convert {

class LabelFileNames {
 public:
  explicit LabelFileNames(std::string pattern) : pattern_(std::move(pattern)) {}

  // Returns whether each label has its own file.
  [[nodiscard]] bool in_use() const;

  // Returns the name of a label's file: the placeholders replaced by its number and by `name`, made safe as part of a
  // file name, or by "label 5" if it has none. If an earlier label has this file name, appends _5, then _5_2 and so on.
  [[nodiscard]] std::string next(std::int64_t label, const std::string& name);

 private:
  std::string pattern_;
  std::unordered_set<std::string> used_;
};

}  // namespace isoextract::convert
