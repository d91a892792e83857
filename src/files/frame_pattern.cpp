#include "files/frame_pattern.hpp"

#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/name_parts.hpp"

namespace isoextract::files {

Result<std::optional<FramePattern>> FramePattern::parse(std::string_view name) {
  const auto parts = TRY(name_parts(name));
  const NamePart* number = nullptr;
  std::string prefix;
  std::string suffix;
  for (const NamePart& part : parts) {
    if (part.kind != NamePart::Kind::number) {
      (number == nullptr ? prefix : suffix) += part.text;
    } else if (number == nullptr) {
      number = &part;
    } else {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected one placeholder of the frame number, found '{}' and '{}'", printable(name),
                              number->text, part.text),
                  "to use such a character as text, double it or put braces around it: {{ }} %% {#} {@} {$}");
    }
  }
  if (number == nullptr) return std::nullopt;
  return FramePattern(std::move(prefix), number->width, std::move(suffix));
}

FramePattern::FramePattern(std::string prefix, int width, std::string suffix)
    : prefix_(std::move(prefix)), width_(width), suffix_(std::move(suffix)) {}

std::string FramePattern::expand(std::int64_t number) const { return prefix_ + frame_digits(number, width_) + suffix_; }

std::optional<std::int64_t> FramePattern::match(std::string_view name) const {
  if (name.size() < prefix_.size() + suffix_.size() || !name.starts_with(prefix_) || !name.ends_with(suffix_)) {
    return std::nullopt;
  }
  const std::string_view written = name.substr(prefix_.size(), name.size() - prefix_.size() - suffix_.size());
  const bool negative = written.starts_with('-');
  const std::string_view digits = written.substr(negative ? 1 : 0);
  if (digits.empty() || digits.size() > kMaxFrameDigits) return std::nullopt;
  std::int64_t number = 0;
  const char* const end = digits.data() + digits.size();
  // The explicit test rejects a second minus sign, which from_chars() would accept.
  if (digits.front() == '-' || std::from_chars(digits.data(), end, number).ptr != end) return std::nullopt;
  if (negative && number == 0) return std::nullopt;
  if (negative) number = -number;
  if (width_ > 0 && frame_digits(number, width_) != written) return std::nullopt;
  return number;
}

std::string FramePattern::text() const {
  return escaped_name(prefix_) + (width_ > 0 ? fmt::format("{{:0{}}}", width_) : "{}") + escaped_name(suffix_);
}

std::string frame_digits(std::int64_t number, int width) {
  return fmt::format("{}{:0{}}", number < 0 ? "-" : "", number < 0 ? -number : number, width);
}

}  // namespace isoextract::files
