#include "batch/iso_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "batch/frame_range.hpp"
#include "files/file_bytes.hpp"
#include "files/frame_pattern.hpp"
#include "files/text_file.hpp"

namespace isoextract::batch {
namespace {

constexpr std::uint64_t kMaxTableBytes = std::uint64_t{256} << 20U;
constexpr std::size_t kShownField = 40;
constexpr std::size_t kShownFrames = 8;
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

// Removes the first line from `text` and returns it.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

// Removes the first field and its separator from `line` and returns the field. `more` tells whether there was a
// separator. Returns nullopt if quotes are wrong.
std::optional<std::string> take_field(std::string_view& line, char separator, bool& more) {
  std::string field;
  std::size_t end = 0;
  const std::size_t first = line.find_first_not_of(separator == '\t' ? " \r" : " \t\r");
  if (first != std::string_view::npos && line[first] == '"') {
    std::size_t at = first + 1;
    for (;; ++at) {
      if (at >= line.size()) return std::nullopt;
      if (line[at] == '"' && !line.substr(at + 1).starts_with('"')) break;
      if (line[at] == '"') ++at;
      field += line[at];
    }
    end = std::min(line.find(separator, at), line.size());
    if (!trimmed(line.substr(at + 1, end - at - 1)).empty()) return std::nullopt;
  } else {
    end = std::min(line.find(separator), line.size());
    field = trimmed(line.substr(0, end));
  }
  more = end < line.size();
  line.remove_prefix(std::min(end + 1, line.size()));
  return field;
}

std::optional<std::vector<std::string>> fields_of(std::string_view line, char separator) {
  std::vector<std::string> fields;
  for (bool more = true; more;) {
    auto field = take_field(line, separator, more);
    if (!field) return std::nullopt;
    fields.push_back(std::move(*field));
  }
  return fields;
}

template <class T>
std::optional<T> field_number(std::string_view text) {
  T number{};
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || rest != end) return std::nullopt;
  return number;
}

std::optional<convert::IsoChoice> iso_of(std::string text, char decimal_mark) {
  const std::size_t comma = text.find(',');
  if (decimal_mark == ',' && comma != std::string::npos) text[comma] = '.';
  const auto number = field_number<double>(text);
  if (!number) return convert::iso_choice_of(text);
  return std::isfinite(*number) ? std::optional<convert::IsoChoice>(*number) : std::nullopt;
}

// Returns '.' or ',', or 0 if the field has neither.
char decimal_mark_of(std::string_view field, char separator) {
  const std::size_t at = field.find_first_of(separator == ',' ? "." : ".,");
  return at == std::string_view::npos ? '\0' : field[at];
}

bool is_separator_line(std::string_view content) { return content.starts_with("sep=") && content.size() <= 5; }

char separator_of(std::string_view header) {
  for (const char separator : {'\t', ';'}) {
    if (header.find(separator) != std::string_view::npos) return separator;
  }
  return ',';
}

struct TableColumns {
  char separator = ',';
  std::size_t count = 0;
  std::size_t frame = 0;
  std::size_t iso = 0;
};

// `place` is "name:line".
Result<TableColumns> columns_of(std::string_view header, const std::string& place) {
  TableColumns columns;
  columns.separator = separator_of(header);
  const auto fields = fields_of(header, columns.separator);
  std::size_t frames = 0;
  std::size_t isos = 0;
  if (fields) {
    columns.count = fields->size();
    for (std::size_t i = 0; i < fields->size(); ++i) {
      const std::string name = to_lower((*fields)[i]);
      if (name == "frame") columns.frame = i, ++frames;
      if (name == "iso") columns.iso = i, ++isos;
    }
  }
  if (frames == 1 && isos == 1) return columns;
  return fail(ErrorCode::input,
              fmt::format("{}: expected a header with one column 'frame' and one 'iso', found '{}'", place,
                          printable(trimmed(header), kShownField)),
              "for example 'frame,iso', and a line '1,0.15' for frame 1");
}

}  // namespace

Result<IsoTable> IsoTable::read(const std::filesystem::path& path, const Context& context) {
  const auto text = TRY(files::read_text_file(path, "a table", kMaxTableBytes, context));
  return parse(text, files::input_label(path));
}

Result<IsoTable> IsoTable::parse(std::string_view text, const std::string& name) {
  IsoTable table;
  table.name_ = printable(name);
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::optional<TableColumns> columns;
  char decimal_mark = '\0';
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = take_line(text);
    const std::string_view content = trimmed(line);
    if (content.empty() || content.front() == '#' || (!columns && is_separator_line(content))) continue;
    const std::string place = fmt::format("{}:{}", table.name_, number);
    if (!columns) {
      columns = TRY(columns_of(line, place));
      continue;
    }
    const auto fields = fields_of(line, columns->separator);
    if (!fields) {
      return fail(ErrorCode::input, fmt::format("{}: expected quotes around whole fields, found '{}'", place,
                                                printable(content, kShownField)));
    }
    if (fields->size() != columns->count) {
      return fail(
          ErrorCode::input,
          fmt::format("{}: expected {} fields as in the header, found {}", place, columns->count, fields->size()),
          "write decimals with a point where commas separate the fields");
    }
    const std::string& frame_field = (*fields)[columns->frame];
    const auto frame = field_number<std::int64_t>(frame_field);
    if (!frame || *frame < -files::kMaxFrameNumber || *frame > files::kMaxFrameNumber) {
      return fail(ErrorCode::input, fmt::format("{}: expected the number of a frame, found '{}'", place,
                                                printable(frame_field, kShownField)));
    }
    const std::string& iso_field = (*fields)[columns->iso];
    // A row with another decimal mark, or with both, may use one as a thousands separator, so it is rejected.
    const char mark = decimal_mark_of(iso_field, columns->separator);
    if (mark != '\0' && decimal_mark != '\0' && mark != decimal_mark) {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected an iso value with the decimal mark '{}' of the rows before, found '{}'",
                              place, decimal_mark, printable(iso_field, kShownField)),
                  "use one decimal mark in all rows");
    }
    if (mark != '\0') decimal_mark = mark;
    const auto iso = iso_of(iso_field, mark);
    if (!iso) {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected a finite number, {}, found '{}'", place, convert::kIsoWords,
                              printable(iso_field, kShownField)),
                  iso_field.find(',') == std::string::npos
                      ? ""
                      : "use a decimal point; a decimal comma works only if tabs or semicolons separate the fields");
    }
    table.rows_.push_back({*frame, number, *iso});
  }
  if (!columns) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected a header with the columns 'frame' and 'iso', found no line", table.name_));
  }
  TRY(table.sort_rows());
  return table;
}

Result<void> IsoTable::sort_rows() {
  const auto value = [](const Row& row) { return std::tuple(row.frame, row.iso, row.line); };
  std::ranges::sort(rows_, {}, value);
  const auto repeats = [](const Row& a, const Row& b) { return a.frame == b.frame && a.iso == b.iso; };
  const auto twice = std::ranges::adjacent_find(rows_, repeats);
  if (twice != rows_.end()) {
    return fail(ErrorCode::input,
                fmt::format("{}:{}: expected iso {} of frame {} once, found the same pair in line {}", name_,
                            std::next(twice)->line, text_of(twice->iso), twice->frame, twice->line));
  }
  std::ranges::sort(rows_, {}, [](const Row& row) { return std::pair(row.frame, row.line); });
  isos_.reserve(rows_.size());
  for (const Row& row : rows_) isos_.push_back(row.iso);
  return {};
}

std::span<const convert::IsoChoice> IsoTable::isos_of(std::int64_t frame) const {
  const auto first = std::ranges::lower_bound(rows_, frame, {}, &Row::frame);
  const auto end = std::ranges::upper_bound(rows_, frame, {}, &Row::frame);
  return {isos_.data() + (first - rows_.begin()), static_cast<std::size_t>(end - first)};
}

Result<void> IsoTable::check_covers(std::span<const std::int64_t> frames) const {
  std::vector<std::int64_t> missing;
  for (const std::int64_t frame : frames) {
    if (isos_of(frame).empty()) missing.push_back(frame);
  }
  if (missing.empty()) return {};
  std::ranges::sort(missing);
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  return fail(ErrorCode::input,
              fmt::format("{}: expected a row for every frame, found none for {}", name_,
                          text_of(runs_of(missing), kShownFrames)),
              "add a row for each of these frames");
}

}  // namespace isoextract::batch
