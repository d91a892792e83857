#include "volume_io/formats/nrrd_header.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <teem/nrrd.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "volume_io/formats/nrrd_segments.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::size_t kMaxHeader = std::size_t{16} << 20;
// teem 1.12 writes each message into AIR_STRLEN_HUGE bytes without a bounds check: its own text, less than 200 bytes,
// and at most one line of the header.
constexpr std::size_t kMaxLine = 768;
static_assert(kMaxLine + 200 < AIR_STRLEN_HUGE);

// Reads lines from the start of a file on demand.
class HeaderLines {
 public:
  explicit HeaderLines(const files::InputFile& file) : file_(file) {}

  // Returns the next line without its end; nothing at the end of the file.
  Result<std::optional<std::string>> next() {
    std::size_t end = 0;
    while ((end = text_.find('\n', begin_)) == std::string::npos) {
      if (text_.size() == file_.size()) break;
      if (text_.size() >= kMaxHeader) {
        return fail(ErrorCode::input,
                    fmt::format("{}: the header has no end within {} bytes", file_.name(), kMaxHeader));
      }
      TRY(grow());
    }
    if (begin_ == text_.size()) return std::optional<std::string>();
    const std::size_t stop = std::min(end, text_.size());
    std::string line = text_.substr(begin_, stop - begin_);
    begin_ = std::min(stop + 1, text_.size());
    ++number_;
    if (line.ends_with('\r')) line.pop_back();
    if (line.find('\0') != std::string::npos) {
      return fail(ErrorCode::input, file_.name() + ": expected a header of text, found binary data");
    }
    return std::optional(std::move(line));
  }

  [[nodiscard]] std::uint64_t position() const { return begin_; }
  [[nodiscard]] std::uint64_t number() const { return number_; }  // of the last line, from 1

 private:
  Result<void> grow() {
    constexpr std::size_t kStep = std::size_t{64} << 10;
    const std::size_t old = text_.size();
    text_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(file_.size(), old + kStep)));
    return file_.read_at(old, std::as_writable_bytes(std::span(text_).subspan(old)));
  }

  const files::InputFile& file_;
  std::string text_;
  std::size_t begin_ = 0;
  std::uint64_t number_ = 0;
};

// Returns the field that teem sees in a line; its name ends at ": ". Returns nrrdField_unknown for lines without one.
int field_of(const std::string& line) {
  const std::size_t colon = line.find(": ");
  if (colon == std::string::npos) return nrrdField_unknown;
  return ::airEnumVal(nrrdField, line.substr(0, colon).c_str());
}

// Returns whether the line is free text that does not describe the samples: a comment, a key/value pair or "content".
bool is_free_text(const std::string& line) {
  if (line.starts_with('#')) return true;
  const int field = field_of(line);
  return field == nrrdField_content || (field == nrrdField_unknown && line.find(":=") != std::string::npos);
}

// teem looks for one value more than there are axes, in an array with room for exactly the largest number of axes.
bool has_value_per_axis(int field) {
  return field == nrrdField_sizes || field == nrrdField_spacings || field == nrrdField_thicknesses ||
         field == nrrdField_axis_mins || field == nrrdField_axis_maxs;
}

std::size_t count_words(std::string_view text) {
  std::size_t count = 0;
  for (text = trimmed(text); !text.empty(); ++count) {
    text.remove_prefix(std::min(text.find_first_of(" \t"), text.size()));
    text = trimmed(text);
  }
  return count;
}

// Fails for lines that would overflow a buffer in teem.
Result<void> check_line(const files::InputFile& file, std::uint64_t number, const std::string& line) {
  if (line.size() > kMaxLine) {
    return fail(ErrorCode::input, fmt::format("{}: line {} of the header has {} bytes, the limit is {}: '{}'",
                                              file.name(), number, line.size(), kMaxLine, printable(line, 40)));
  }
  if (!has_value_per_axis(field_of(line))) return {};
  const std::size_t values = count_words(std::string_view(line).substr(line.find(": ") + 1));
  if (values <= NRRD_DIM_MAX) return {};
  return fail(ErrorCode::input, fmt::format("{}: line {} of the header has {} values, a NRRD has at most {} axes: '{}'",
                                            file.name(), number, values, NRRD_DIM_MAX, printable(line, 40)));
}

// Splits "slice%03d.raw" at its only %d; returns nothing for a name without one.
std::optional<NrrdFilePattern> parse_pattern_name(std::string_view name) {
  const std::size_t percent = name.find('%');
  if (percent == std::string_view::npos || name.find('%', percent + 1) != std::string_view::npos) return std::nullopt;
  std::size_t at = percent + 1;
  NrrdFilePattern pattern;
  pattern.zero_padded = name.substr(at).starts_with('0');
  constexpr int kMaxWidth = 20;
  while (at < name.size() && name[at] >= '0' && name[at] <= '9' && pattern.width <= kMaxWidth) {
    pattern.width = 10 * pattern.width + (name[at++] - '0');
  }
  if (pattern.width > kMaxWidth || !name.substr(at).starts_with('d')) return std::nullopt;
  pattern.prefix = name.substr(0, percent);
  pattern.suffix = name.substr(at + 1);
  return pattern;
}

// Parses "slice%03d.raw 0 99 1 [2]"; returns nothing for a single name.
std::optional<NrrdDataFiles> parse_pattern(std::string_view value) {
  const std::size_t space = value.find_first_of(" \t");
  if (space == std::string_view::npos) return std::nullopt;
  auto pattern = parse_pattern_name(value.substr(0, space));
  if (!pattern) return std::nullopt;
  std::string_view rest = value.substr(space);
  const auto first = take_number<int>(rest);
  const auto last = take_number<int>(rest);
  const auto step = take_number<int>(rest);
  if (!first || !last || !step || *step == 0) return std::nullopt;
  pattern->first = *first;
  pattern->last = *last;
  pattern->step = *step;
  if ((pattern->last - pattern->first) * pattern->step < 0) return std::nullopt;
  NrrdDataFiles files;
  files.pattern = std::move(*pattern);
  files.several = true;
  files.file_dimension = take_number<unsigned>(rest);
  return files;
}

Result<NrrdDataFiles> read_list(HeaderLines& lines, std::string_view rest) {
  NrrdDataFiles files;
  files.several = true;
  files.file_dimension = take_number<unsigned>(rest);
  while (true) {
    auto line = TRY(lines.next());
    if (!line) return files;
    if (!trimmed(*line).empty()) files.names.emplace_back(trimmed(*line));
  }
}

// Returns true for the "data file" field, ignoring case; sets `value` to its value.
bool is_data_file_field(std::string_view line, std::string_view& value) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || line.substr(colon).starts_with(":=")) return false;
  const std::string field = to_lower(trimmed(line.substr(0, colon)));
  value = trimmed(line.substr(colon + 1));
  return field == "data file" || field == "datafile";
}

Result<NrrdDataFiles> parse_data_files(const files::InputFile& file, HeaderLines& lines, std::string_view value) {
  const auto is_word = [&](std::string_view word) {
    return value == word || value.starts_with(std::string(word) + ' ');
  };
  if (is_word("LIST")) return read_list(lines, value.substr(4));
  if (is_word("SKIPLIST")) {
    return fail(ErrorCode::input, file.name() + ": a SKIPLIST of data files is not supported",
                "write the samples into one file");
  }
  if (auto pattern = parse_pattern(value)) return *pattern;
  if (value.empty()) return fail(ErrorCode::input, file.name() + ": the field 'data file' is empty");
  NrrdDataFiles single;
  single.names.emplace_back(value);
  return single;
}

}  // namespace

std::uint64_t NrrdFilePattern::count() const { return static_cast<std::uint64_t>((last - first) / step) + 1; }

std::string NrrdFilePattern::name(std::uint64_t i) const {
  const std::int64_t number = first + static_cast<std::int64_t>(i) * step;
  const std::string digits = zero_padded ? fmt::format("{:0{}}", number, width) : fmt::format("{:{}}", number, width);
  return prefix + digits + suffix;
}

Result<NrrdHeaderText> read_nrrd_header(const files::InputFile& file) {
  NrrdHeaderText header;
  HeaderLines lines(file);
  while (true) {
    auto next = TRY(lines.next());
    if (!next) {
      if (header.detached) return header;
      return fail(ErrorCode::input,
                  file.name() + ": the header has neither an empty line with samples after it nor a field 'data file'");
    }
    const std::string& line = *next;
    if (line.empty()) {
      header.data_offset = lines.position();
      return header;
    }
    std::string_view value;
    if (!is_data_file_field(line, value)) {
      if (is_free_text(line)) {  // not for teem, which is slow: it compares each key with all others
        if (line.starts_with(kSegmentKey)) header.segments.push_back(line);
        continue;
      }
      TRY(check_line(file, lines.number(), line));
      header.fields += line + '\n';
      continue;
    }
    if (header.detached) {
      return fail(ErrorCode::input, file.name() + ": the header has more than one field 'data file'; expected one");
    }
    header.detached = TRY(parse_data_files(file, lines, value));
    if (header.detached->several && !header.detached->pattern) return header;  // a LIST ends the header
  }
}

}  // namespace isoextract::volume_io
