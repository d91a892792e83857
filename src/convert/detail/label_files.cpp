#include "convert/detail/label_files.hpp"

#include <string_view>

#include <fmt/format.h>

#include "convert/surface_edits.hpp"
#include "files/name_parts.hpp"

namespace isoextract::convert {
namespace {

void replace_all(std::string& text, std::string_view word, const std::string& by) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + by.size())) {
    text.replace(at, word.size(), by);
  }
}

}  // namespace

bool LabelFileNames::in_use() const {
  return pattern_.find(kLabelPlaceholder) != std::string::npos || pattern_.find(kNamePlaceholder) != std::string::npos;
}

std::string LabelFileNames::next(std::int64_t label, const std::string& name) {
  const std::string number = fmt::format("{}", label);
  const std::string text = files::safe_file_name(name.empty() ? "label " + number : name);
  for (int repeat = 0;; ++repeat) {
    const std::string again = repeat > 1 ? fmt::format("_{}", repeat) : std::string();
    std::string path = pattern_;
    // Inserts the name last, because the name may contain a placeholder.
    replace_all(path, kLabelPlaceholder, number + again);
    replace_all(path, kNamePlaceholder, repeat == 0 ? text : fmt::format("{}_{}{}", text, number, again));
    if (used_.insert(path).second) return path;
  }
}

}  // namespace isoextract::convert
