#include "volume_io/formats/nrrd_segments.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "volume_io/formats/nrrd_header.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::size_t kSegmentShown = 60;  // most bytes of a value shown in a message

struct Segment {
  std::string id;
  std::string name;
  std::optional<std::int64_t> label;
  std::optional<std::uint64_t> layer;
  std::optional<glm::dvec3> color;
};

template <class T>
std::optional<T> only_number(std::string_view text) {
  const auto number = take_number<T>(text);
  return trimmed(text).empty() ? number : std::nullopt;
}

std::optional<glm::dvec3> color_of(std::string_view text) {
  glm::dvec3 color(0.0);
  for (int c = 0; c < 3; ++c) {
    const auto channel = take_number<double>(text);
    if (!channel || !std::isfinite(*channel)) return std::nullopt;
    color[c] = std::clamp(*channel, 0.0, 1.0);
  }
  return trimmed(text).empty() ? std::optional(color) : std::nullopt;
}

// Returns the text of a value: NRRD writes a line break as \n and a backslash as \\. Blanks replace line breaks.
std::string unescaped(std::string_view value) {
  std::string text;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const char next = i + 1 < value.size() ? value[i + 1] : ' ';
    const bool is_escape = value[i] == '\\' && (next == 'n' || next == '\\');
    text += !is_escape ? value[i] : next == 'n' ? ' ' : '\\';
    if (is_escape) ++i;
  }
  return std::string(trimmed(text));
}

Error bad_value(const std::string& file, std::string_view key, std::string_view expected, std::string_view value) {
  return {ErrorCode::input,
          fmt::format("{}: expected {} as {}, found '{}'", file, expected, printable(key, kSegmentShown),
                      printable(value, kSegmentShown)),
          {}};
}

// Sets the property of a segment that one line states.
Result<void> set_property(const std::string& file, std::string_view key, std::string_view property,
                          std::string_view value, Segment& segment) {
  if (property == "ID") segment.id = unescaped(value);
  if (property == "Name") segment.name = unescaped(value);
  if (property == "LabelValue" && !(segment.label = only_number<std::int64_t>(value))) {
    return tl::unexpected(bad_value(file, key, "an integer", value));
  }
  if (property == "Layer" && !(segment.layer = only_number<std::uint64_t>(value))) {
    return tl::unexpected(bad_value(file, key, "a whole number", value));
  }
  if (property == "Color" && !(segment.color = color_of(value))) {
    return tl::unexpected(bad_value(file, key, "three numbers from 0 to 1", value));
  }
  return {};
}

// Returns the segments by their numbers.
Result<std::map<std::uint64_t, Segment>> collect_segments(const std::string& file, std::span<const std::string> lines) {
  std::map<std::uint64_t, Segment> segments;
  for (const std::string& line : lines) {
    const std::size_t equals = line.find(":=");
    if (equals == std::string::npos) continue;
    const std::string_view key = std::string_view(line).substr(0, equals);
    std::string_view rest = key.substr(kSegmentKey.size());
    const auto number = take_number<std::uint64_t>(rest);
    if (!number || !rest.starts_with('_')) continue;
    TRY(set_property(file, key, rest.substr(1), std::string_view(line).substr(equals + 2), segments[*number]));
  }
  return segments;
}

}  // namespace

Result<std::vector<field::LabelName>> parse_segments(const std::string& file, std::span<const std::string> lines,
                                                     std::uint64_t layers) {
  const auto segments = TRY(collect_segments(file, lines));
  std::vector<field::LabelName> labels;
  for (const auto& [number, segment] : segments) {
    field::LabelName label;
    label.label = segment.label.value_or(1);
    label.name = !segment.name.empty() ? segment.name
                 : !segment.id.empty() ? segment.id
                                       : fmt::format("{}{}", kSegmentKey, number);
    label.color = segment.color;
    const std::uint64_t layer = segment.layer.value_or(layers > 1 ? number : 0);
    if (layer >= layers) {
      return fail(ErrorCode::input, fmt::format("{}: expected layers from 0 to {}, found layer {} of segment '{}'",
                                                file, layers - 1, layer, printable(label.name, kSegmentShown)));
    }
    if (layers > 1) label.layer = static_cast<std::int64_t>(layer);
    labels.push_back(std::move(label));
  }
  const auto place = [](const field::LabelName& label) { return std::tuple(label.label, label.layer); };
  std::ranges::stable_sort(labels, {}, place);
  const auto twice = std::ranges::adjacent_find(labels, {}, place);
  if (twice == labels.end()) return labels;
  return fail(
      ErrorCode::input,
      fmt::format("{}: expected one segment for each label of a layer, found label {} as '{}' and as '{}'", file,
                  twice->label, printable(twice->name, kSegmentShown), printable((twice + 1)->name, kSegmentShown)));
}

}  // namespace isoextract::volume_io
