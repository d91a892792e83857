#include "files/name_parts.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "files/frame_pattern.hpp"

namespace isoextract::files {
namespace {

// Parses "04" and "4" as 4, "" as 0; nullopt if it is no number. Too large numbers become kMaxFrameDigits + 1.
std::optional<int> width_of(std::string_view digits) {
  int width = 0;
  for (const char c : digits) {
    if (!is_digit(c)) return std::nullopt;
    width = std::min(10 * width + (c - '0'), kMaxFrameDigits + 1);
  }
  return width;
}

bool parts_names(std::string_view name, std::size_t at) {
  return at >= name.size() || std::string_view("._-/").find(name[at]) != std::string_view::npos;
}

// Returns the length of the run of # or @ at `at` that stands for a number; 0 if it is text.
std::size_t marks_length(std::string_view name, std::size_t at) {
  const std::size_t end = std::min(name.find_first_not_of(name[at], at), name.size());
  if (end > at + 1) return end - at;
  return (at == 0 || parts_names(name, at - 1)) && parts_names(name, end) ? 1 : 0;
}

// Returns the length of $F, $F4, ${F} or ${F4} at the start of `text`; 0 without one, as in $FF or $F42.
std::size_t houdini_length(std::string_view text) {
  const bool in_braces = text.starts_with("${F");
  if (!in_braces && !text.starts_with("$F")) return 0;
  std::size_t end = in_braces ? 3 : 2;
  if (end < text.size() && is_digit(text[end])) ++end;
  if (in_braces) return end < text.size() && text[end] == '}' ? end + 1 : 0;
  const bool goes_on = end < text.size() && (is_digit(text[end]) || is_letter(text[end]));
  return goes_on ? 0 : end;
}

class NameScanner {
 public:
  explicit NameScanner(std::string_view name) : name_(name) {}

  Result<std::vector<NamePart>> scan() {
    while (at_ < name_.size()) {
      if (escape("{{", '{') || escape("}}", '}') || escape("%%", '%')) continue;
      if (escape("{#}", '#') || escape("{@}", '@') || escape("{$}", '$')) continue;
      const auto taken = TRY(numbering());
      if (!taken) add_text(name_[at_++]);
    }
    return std::move(parts_);
  }

 private:
  Result<bool> numbering() {
    switch (name_[at_]) {
      case '{': return braces();
      case '%': return percent();
      case '$': return houdini();
      case '#':
      case '@': return marks();
      default: return false;
    }
  }

  bool escape(std::string_view written, char meant) {
    if (!name_.substr(at_).starts_with(written)) return false;
    add_text(meant);
    at_ += written.size();
    return true;
  }

  void add_text(char c) {
    if (parts_.empty() || parts_.back().kind != NamePart::Kind::text) parts_.emplace_back();
    parts_.back().text += c;
  }

  Result<bool> add_number(std::size_t length, std::optional<int> width, NamePart::Kind kind = NamePart::Kind::number,
                          std::string_view word = {}) {
    const std::string_view written = name_.substr(at_, length);
    if (!width) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected digits after the colon, as in {{:04}}, found '{}'", printable(name_),
                              printable(written)),
                  kBracesHint);
    }
    if (*width > kMaxFrameDigits) {
      return fail(ErrorCode::usage, fmt::format("{}: expected a width of at most {} digits, found '{}'",
                                                printable(name_), kMaxFrameDigits, printable(written, 40)));
    }
    parts_.push_back({kind, std::string(written), std::string(word), *width});
    at_ += length;
    return true;
  }

  // {}, {:04}, {word}, {step:04}. An unclosed brace, or one with numbering inside, is text.
  Result<bool> braces() {
    const std::size_t close = name_.find('}', at_);
    if (close == std::string_view::npos) return false;
    const std::string_view inside = name_.substr(at_ + 1, close - at_ - 1);
    if (inside.find_first_of("{%#") != std::string_view::npos) return false;
    const std::size_t colon = std::min(inside.find(':'), inside.size());
    const std::string_view word = inside.substr(0, colon);
    const auto width = width_of(inside.substr(std::min(colon + 1, inside.size())));
    const std::size_t length = inside.size() + 2;
    if (word.empty() || word == "frame") return add_number(length, width);
    if (word == "step") return add_number(length, width, NamePart::Kind::word, word);
    parts_.push_back({NamePart::Kind::word, std::string(name_.substr(at_, length)), std::string(inside), 0});
    at_ += length;
    return true;
  }

  // %d, %04d. A percent sign before anything else is text.
  Result<bool> percent() {
    std::size_t end = at_ + 1;
    while (end < name_.size() && is_digit(name_[end])) ++end;
    if (end == name_.size() || name_[end] != 'd') return false;
    return add_number(end + 1 - at_, width_of(name_.substr(at_ + 1, end - at_ - 1)));
  }

  // $F, $F4, ${F}, ${F4}, as in Houdini.
  Result<bool> houdini() {
    const std::size_t length = houdini_length(name_.substr(at_));
    if (length == 0) return false;
    const std::string_view digits = name_.substr(at_, length);
    const std::size_t first = std::min(digits.find_first_of("0123456789"), length);
    return add_number(length, width_of(digits.substr(first, digits.find_last_of("0123456789") + 1 - first)));
  }

  // ##, ###, @@, ..., or a single one between dots, dashes, underscores and the ends of a name. Elsewhere a single one
  // is text, because it is common in names.
  Result<bool> marks() {
    const std::size_t length = marks_length(name_, at_);
    if (length == 0) return false;
    return add_number(length, length == 1 ? 0 : static_cast<int>(std::min<std::size_t>(length, kMaxFrameDigits + 1)));
  }

  static constexpr const char* kBracesHint = "write {{ and }} for braces";

  std::string_view name_;
  std::size_t at_ = 0;
  std::vector<NamePart> parts_;
};

}  // namespace

Result<std::vector<NamePart>> name_parts(std::string_view name) { return NameScanner(name).scan(); }

std::string escaped_name(std::string_view text) {
  std::string escaped;
  for (std::size_t i = 0; i < text.size(); ++i) {
    switch (const char c = text[i]) {
      case '{': escaped += "{{"; break;
      case '}': escaped += "}}"; break;
      case '%': escaped += "%%"; break;
      case '$': escaped += houdini_length(text.substr(i)) > 0 ? "{$}" : "$"; break;
      case '#':
      case '@': {
        const bool repeats = i > 0 && text[i - 1] == c;
        if (repeats || marks_length(text, i) == 1) {
          escaped += fmt::format("{{{}}}", c);
        } else {
          escaped += c;
        }
        break;
      }
      default: escaped += c;
    }
  }
  return escaped;
}

std::string safe_file_name(std::string_view text) {
  constexpr std::string_view kUnsafe = "/\\:*?\"<>|";
  std::string safe;
  for (std::size_t at = 0; at < text.size();) {
    const auto lead = static_cast<unsigned char>(text[at]);
    const std::size_t bytes = lead < 0xc0 ? 1 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
    const std::string_view character = text.substr(at, bytes);
    const bool fits = kUnsafe.find(text[at]) == std::string_view::npos && printable(character) == character;
    safe += fits ? character : "_";
    at += fits ? character.size() : 1;  // replaces every byte of an invalid character
  }
  for (char& c : safe) {
    if (c != '.') break;
    c = '_';
  }
  return safe;
}

}  // namespace isoextract::files
