#include "volume_io/label_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <span>
#include <system_error>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "files/content_hash.hpp"
#include "files/file_bytes.hpp"
#include "files/text_file.hpp"
#include "volume_io/detail/dense_format.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::string_view kTableExtension = ".ctbl";  // extension of 3D Slicer
constexpr std::size_t kTableShown = 60;                // most bytes of a line shown in a message

std::optional<std::int64_t> whole_number(std::string_view word) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return number;
}

std::vector<std::string_view> words_of_line(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(" \t"); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(" \t", end);
  }
  return words;
}

std::optional<glm::dvec3> color_from_text(std::span<const std::string_view> words) {
  glm::dvec3 color(0.0);
  for (int c = 0; c < 3; ++c) {
    const auto channel = whole_number(words[static_cast<std::size_t>(c)]);
    if (!channel || *channel < 0 || *channel > 255) return std::nullopt;
    color[c] = static_cast<double>(*channel) / 255;
  }
  return color;
}

// Returns nothing if the line is not a label.
std::optional<field::LabelName> entry_of(std::string_view line) {
  const bool is_text = std::ranges::none_of(
      line, [](char c) { return (static_cast<unsigned char>(c) < ' ' && c != '\t') || c == '\x7f'; });
  if (!is_text) return std::nullopt;
  field::LabelName entry;
  std::optional<glm::dvec3> color;
  const std::size_t quote = line.find('"');
  const std::vector<std::string_view> words = words_of_line(line.substr(0, quote));
  if (quote != std::string_view::npos) {
    if (words.size() != 7 || line.size() < quote + 2 || line.back() != '"') return std::nullopt;
    entry.name = line.substr(quote + 1, line.size() - quote - 2);
    color = color_from_text(std::span(words).subspan(1, 3));
  } else {
    if (words.size() != 6 || !whole_number(words[5])) return std::nullopt;
    entry.name = words[1];
    color = color_from_text(std::span(words).subspan(2, 3));
  }
  const auto label = whole_number(words[0]);
  if (!label || !color || entry.name.empty()) return std::nullopt;
  entry.label = *label;
  entry.color = color;
  return entry;
}

}  // namespace

Result<LabelTable> LabelTable::parse(std::string_view text, const std::string& source) {
  LabelTable table;
  table.hash_ = files::content_hash(text);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::size_t number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = trimmed(text.substr(at, end - at));
    at = end + 1;
    ++number;
    if (line.empty() || line.front() == '#') continue;
    auto entry = entry_of(line);
    if (!entry) {
      return fail(ErrorCode::input,
                  fmt::format("{}: line {}: expected a label line of ITK-SNAP (number, red, green, blue, alpha, two "
                              "flags, \"name\") or of FreeSurfer (number, name, red, green, blue, alpha), with colors "
                              "from 0 to 255, found '{}'",
                              source, number, printable(line, kTableShown)));
    }
    table.entries_.push_back(std::move(*entry));
  }
  if (table.entries_.empty()) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected at least one label, found only empty lines and comments", source));
  }
  std::ranges::stable_sort(table.entries_, {}, &field::LabelName::label);
  const auto twice = std::ranges::adjacent_find(table.entries_, {}, &field::LabelName::label);
  if (twice != table.entries_.end()) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected each label once, found {} as '{}' and as '{}'", source, twice->label,
                            printable(twice->name, kTableShown), printable((twice + 1)->name, kTableShown)));
  }
  return table;
}

Result<LabelTable> LabelTable::read(const std::string& path, const Context& context) {
  const auto text = TRY(files::read_text_file(path, "a table of labels", kMaxBytes, context));
  return parse(text, files::input_label(path));
}

std::optional<std::filesystem::path> find_label_table(const std::filesystem::path& label_map) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::path folder = label_map.has_parent_path() ? label_map.parent_path() : fs::path(".");
  const std::string stem = stem_of(label_map);
  for (const std::string_view ending :
       {kTableExtension, std::string_view("_ColorTable.ctbl"), std::string_view("_LUT.txt")}) {
    fs::path table = label_map.parent_path() / (stem + std::string(ending));
    if (fs::is_regular_file(table, none)) return table;
  }
  std::optional<fs::path> found;
  for (fs::directory_iterator entry(folder, none), end; !none && entry != end; entry.increment(none)) {
    if (to_lower(entry->path().extension().string()) != kTableExtension) continue;
    if (found) return std::nullopt;
    found = label_map.parent_path() / entry->path().filename();
  }
  return found;
}

glm::dvec3 default_label_color(std::int64_t label) {
  // Steps of the golden ratio around the hue circle keep hues far from all earlier ones.
  constexpr double kGolden = 0.6180339887498949;
  constexpr double kSaturation = 0.6;
  constexpr double kValue = 0.9;
  // A product with a label beyond 2^40 has too few digits after the point, so these labels take the color of their
  // remainder modulo 2^40.
  constexpr std::int64_t kExact = std::int64_t{1} << 40;
  const double turns = std::fmod(static_cast<double>(label % kExact) * kGolden, 1.0);
  const double hue = 6 * (turns < 0 ? turns + 1 : turns);
  glm::dvec3 color(0.0);
  constexpr std::array<double, 3> kShift{5, 3, 1};
  for (int c = 0; c < 3; ++c) {
    const double k = std::fmod(kShift[static_cast<std::size_t>(c)] + hue, 6.0);
    color[c] = kValue * (1 - kSaturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
  }
  return color;
}

}  // namespace isoextract::volume_io
