#include "batch/output_template.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "convert/surface_edits.hpp"
#include "files/frame_pattern.hpp"
#include "files/name_parts.hpp"

namespace isoextract::batch {

Result<OutputTemplate> OutputTemplate::parse(std::string_view name) {
  const auto parts = TRY(files::name_parts(name));
  OutputTemplate result;
  for (const files::NamePart& part : parts) {
    if (part.kind == files::NamePart::Kind::text) {
      result.end_ += part.text;
      continue;
    }
    const auto word = part.kind == files::NamePart::Kind::number ? OutputWord::frame : value_of<OutputWord>(part.word);
    if (!word) {
      return fail(
          ErrorCode::usage,
          fmt::format(
              "{}: expected {{stem}}, {{frame}}, {{frame:04}}, {{step}}, {{grid}}, {{iso}}, {{label}}, {{name}} or "
              "{{piece}}, found '{}'",
              printable(name), printable(part.text)),
          "write {{ and }} for braces");
    }
    result.parts_.push_back({std::exchange(result.end_, {}), *word, part.width});
  }
  return result;
}

bool OutputTemplate::uses(OutputWord word) const {
  return std::ranges::any_of(parts_, [&](const Part& part) { return part.word == word; });
}

std::string OutputTemplate::expand(const OutputWords& words) const {
  std::string name;
  for (const Part& part : parts_) {
    name += part.text;
    switch (part.word) {
      case OutputWord::stem: name += files::safe_file_name(words.stem); break;
      case OutputWord::frame: name += files::frame_digits(words.frame, part.width); break;
      case OutputWord::step: name += files::frame_digits(words.step, part.width); break;
      case OutputWord::grid: name += files::safe_file_name(words.grid); break;
      case OutputWord::iso: name += words.iso; break;
      case OutputWord::label: name += convert::kLabelPlaceholder; break;
      case OutputWord::name: name += convert::kNamePlaceholder; break;
      case OutputWord::piece: name += convert::kPiecePlaceholder; break;
    }
  }
  return name + end_;
}

std::string template_of(std::string_view name) { return files::escaped_name(name); }

}  // namespace isoextract::batch
