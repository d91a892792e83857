// Text tables: a line per particle, with or without a line of names before them.
// - Fields are separated by commas, semicolons, tabs, bars or spaces. They may be quoted (RFC 4180, but a quoted field
//   may not contain a line end).
// - Lines that start with '#' are comments, and so is "sep=;", which gives spreadsheets the separator.
// - Numbers may have decimal commas if the separator is not a comma.
// - Without a line of names, the last comment before the table may contain them, as NumPy's savetxt writes it.
#include <algorithm>
#include <deque>
#include <optional>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/detail/text_rows.hpp"

namespace isoextract::particle_io {
namespace {

constexpr char kWords = ' ';  // fields are separated by spaces and tabs

bool is_space(char c) { return c == ' ' || c == '\t'; }

std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

bool is_blank(std::string_view line) { return without_blanks(line).empty(); }

bool is_comment(std::string_view line) {
  const std::string_view text = without_blanks(line);
  return text.starts_with('#') || (text.starts_with("sep=") && text.size() <= 5);
}

// Splits lines into fields. Stores unescaped copies of fields with doubled quotes; other fields are views of the line.
class FieldSplitter {
 public:
  explicit FieldSplitter(char delimiter) : delimiter_(delimiter) {}

  [[nodiscard]] char delimiter() const { return delimiter_; }

  // Returns false if a quote does not end, or no delimiter follows it. Does not split beyond kMaxParticleColumns
  // fields.
  bool split(std::string_view line, std::vector<std::string_view>& fields) {
    unescaped_.clear();
    if (delimiter_ == kWords && line.find('"') == std::string_view::npos) {
      split_words(line, fields);
      return true;
    }
    fields.clear();
    while (true) {
      skip_spaces(line);
      if (delimiter_ == kWords && line.empty()) return true;
      if (fields.size() == kMaxParticleColumns) {
        fields.push_back(line);
        return true;
      }
      if (line.starts_with('"')) {
        const auto field = quoted(line);
        if (!field) return false;
        fields.push_back(*field);
        skip_spaces(line);
        if (line.empty()) return true;
        if (delimiter_ == kWords) continue;
        if (line.front() != delimiter_) return false;
        line.remove_prefix(1);
        continue;
      }
      const std::size_t end = delimiter_ == kWords ? line.find_first_of(" \t") : line.find(delimiter_);
      fields.push_back(without_blanks(line.substr(0, end)));
      if (end == std::string_view::npos) return true;
      line.remove_prefix(end + 1);
    }
  }

 private:
  void skip_spaces(std::string_view& line) const {
    while (!line.empty() && (line.front() == ' ' || (line.front() == '\t' && delimiter_ != '\t'))) {
      line.remove_prefix(1);
    }
  }

  std::optional<std::string_view> quoted(std::string_view& line) {
    std::size_t end = line.find('"', 1);
    bool is_doubled = false;
    while (end != std::string_view::npos && end + 1 < line.size() && line[end + 1] == '"') {
      is_doubled = true;
      end = line.find('"', end + 2);
    }
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view inside = line.substr(1, end - 1);
    line.remove_prefix(end + 1);
    if (!is_doubled) return without_blanks(inside);
    std::string& text = unescaped_.emplace_back();
    for (std::size_t i = 0; i < inside.size(); ++i) {
      text += inside[i];
      if (inside[i] == '"') ++i;
    }
    return without_blanks(text);
  }

  char delimiter_;
  std::deque<std::string> unescaped_;  // a deque keeps views of its elements valid
};

struct CsvFile {
  char delimiter = ',';
  ParticleTable table;
  std::uint64_t rows = 0;
  std::uint64_t header_line = 0;  // number of the line with names, unless it is a comment; 0: none
  Notes notes;
};

// Returns whether the fields are names: a line with a number has values, and would otherwise be lost as a particle.
bool are_names(std::span<const std::string_view> fields, char delimiter) {
  const auto is_number = [&](std::string_view field) {
    return delimiter == ',' ? number_in(field).has_value() : DecimalReader().number(field).has_value();
  };
  return std::ranges::none_of(fields, is_number) &&
         std::ranges::any_of(fields, [](std::string_view field) { return !field.empty(); });
}

std::string_view without_byte_order_mark(std::string_view line) {
  return line.starts_with("\xEF\xBB\xBF") ? line.substr(3) : line;
}

// Returns whether a line has three or more numbers between spaces, with decimal commas: "1,5 2,5 3". No number begins
// with a comma, so "1 ,2 ,3" has no decimal commas.
bool has_decimal_commas(std::string_view line) {
  std::vector<std::string_view> words;
  split_words(line, words);
  DecimalReader decimals;
  return words.size() >= 3 &&
         std::ranges::all_of(words,
                             [&](std::string_view word) {
                               return word.front() != ',' && is_digit(word.back()) && decimals.number(word).has_value();
                             }) &&
         decimals.found_commas();
}

// Returns the first delimiter that splits the first line into at least three fields, and the second line into as many,
// or one more or less.
std::optional<char> find_delimiter(std::string_view first, const std::optional<std::string>& second) {
  std::vector<std::string_view> fields;
  for (const char delimiter : {'\t', ';', ',', '|', kWords}) {
    if (delimiter == ',' && has_decimal_commas(first)) continue;
    FieldSplitter splitter(delimiter);
    if (!splitter.split(first, fields) || fields.size() < 3) continue;
    const std::size_t count = fields.size();
    if (second && (!splitter.split(*second, fields) || fields.size() + 1 < count || fields.size() > count + 1))
      continue;
    return delimiter;
  }
  return std::nullopt;
}

void name_columns(CsvFile& csv, std::span<const std::string_view> names) {
  for (NameAndUnit& name : split_units(names)) {
    if (name.name.empty()) name.name = fmt::format("column {}", csv.table.columns.size() + 1);
    csv.table.columns.push_back({std::move(name.name), std::move(name.unit), "number", true});
  }
}

// Names the columns of a table without names: from the comment before it, or by number.
void name_columns_of_values(CsvFile& csv, const std::string& comment, std::size_t count) {
  std::vector<std::string_view> names;
  FieldSplitter splitter(csv.delimiter);
  const std::string_view text = without_blanks(comment);
  if (!text.empty() && splitter.split(text.substr(1), names) && names.size() == count &&
      are_names(names, csv.delimiter)) {
    return name_columns(csv, names);
  }
  for (std::size_t i = 0; i < count; ++i) {
    csv.table.columns.push_back({fmt::format("column {}", i + 1), {}, "number", true});
  }
  if (count == 3) {
    csv.table.position = {0, 1, 2};
    csv.notes.push_back({NoteId::assumed_columns,
                         "the table has no column names, so the reader takes its three columns as x, y and z"});
  }
}

// Reads the whole file to find its columns and the number of rows.
CsvFile survey_csv(const files::InputFile& file) {
  ContentReader content(file);
  CsvFile csv;
  std::string comment;
  std::string first;
  std::optional<std::string> second;
  std::uint64_t first_line = 0;
  std::uint64_t lines = 0;
  while (const auto raw = content.next_line()) {
    const std::string_view line = content.line_number() == 1 ? without_byte_order_mark(*raw) : *raw;
    if (is_blank(line)) continue;
    if (is_comment(line)) {
      if (lines == 0) comment = line;
      continue;
    }
    if (++lines == 1) {
      first = line;
      first_line = content.line_number();
    } else if (lines == 2) {
      second = line;
    }
  }
  if (lines == 0) throw InvalidParticleFile("expected a table, found no rows");
  const auto delimiter = find_delimiter(first, second);
  if (!delimiter) {
    throw InvalidParticleFile(
        fmt::format("line {}: expected three or more columns, separated by commas, semicolons, tabs, bars or "
                    "spaces, and the same number of columns in the next line, found '{}'",
                    first_line, printable(first, 40)));
  }
  csv.delimiter = *delimiter;
  FieldSplitter splitter(csv.delimiter);
  std::vector<std::string_view> fields;
  splitter.split(first, fields);
  if (fields.size() > kMaxParticleColumns) {
    throw InvalidParticleFile(
        fmt::format("line {}: expected at most {} columns, found more", first_line, kMaxParticleColumns));
  }
  const bool commas = csv.delimiter != ',';
  if (are_names(fields, csv.delimiter)) {
    csv.rows = lines - 1;
    csv.header_line = first_line;
    name_columns(csv, fields);
    if (second && splitter.split(*second, fields)) mark_text_columns(csv.table, fields, commas);
  } else {
    csv.rows = lines;
    name_columns_of_values(csv, comment, fields.size());
    mark_text_columns(csv.table, fields, commas);
  }
  group_by_names(csv.table);
  csv.table.has_words = true;
  return csv;
}

// Reads the rows into the sinks. Returns whether numbers have decimal commas.
bool read_csv_rows(ContentReader& content, const CsvFile& csv, std::span<const ColumnSink> sinks) {
  DecimalReader decimals;
  DecimalReader* const commas = csv.delimiter == ',' ? nullptr : &decimals;
  FieldSplitter splitter(csv.delimiter);
  std::vector<std::string_view> fields;
  const std::size_t columns = csv.table.columns.size();
  const auto changed = [&] {
    throw InvalidParticleFile("the file changed while the program read it",
                              "run again when no other program writes to the file");
  };
  std::uint64_t row = 0;
  while (const auto raw = content.next_line()) {
    const std::string_view line = content.line_number() == 1 ? without_byte_order_mark(*raw) : *raw;
    if (content.line_number() == csv.header_line || is_blank(line) || is_comment(line)) continue;
    if (row == csv.rows) changed();
    if (!splitter.split(line, fields)) content.expected("fields with closing quotes in the same line", line);
    // A delimiter at the end of a line adds an empty field.
    const bool ends_with_one = fields.size() == columns + 1 && fields.back().empty();
    if (fields.size() != columns && !ends_with_one) {
      content.expected(fmt::format("{} fields (not {})", columns, fields.size()), line);
    }
    deliver_row(content, csv.table, fields, static_cast<std::size_t>(row), sinks, commas);
    ++row;
  }
  if (row < csv.rows) changed();
  return decimals.found_commas();
}

class CsvParticles final : public ParticleFormat {
 public:
  CsvParticles()
      : ParticleFormat({.id = "csv",
                        .title = "table as text, with or without names of columns",
                        .extensions = {".csv", ".tsv"},
                        .has_columns = true,
                        .needs_extension = true}) {}

  [[nodiscard]] ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const override {
    const CsvFile csv = survey_csv(file);
    ParticleInfo info;
    info.particles = csv.rows;
    info.notes = csv.notes;
    describe_table(csv.table, options, info);
    return info;
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    const CsvFile csv = survey_csv(file);
    const ColumnChoice choice = choose_columns(csv.table, options);
    ParticleFile result;
    result.particles = make_particles(file.context(), file.name(), csv.rows, choice);
    ContentReader content(file);
    const bool commas = read_csv_rows(content, csv, sinks_of(result.particles, choice));
    result.length_unit = choice.length_unit;
    if (!options.columns) result.notes = csv.notes;
    result.notes.insert(result.notes.end(), choice.notes.begin(), choice.notes.end());
    if (commas)
      result.notes.push_back({NoteId::decimal_commas, "the numbers of the table have decimal commas, not points"});
    return result;
  }
};

}  // namespace

const ParticleFormat& csv_particles() {
  static const CsvParticles format;
  return format;
}

}  // namespace isoextract::particle_io
