#include "particle_io/detail/text_rows.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "base/printable.hpp"

namespace isoextract::particle_io {
namespace {

// Returns the number with commas between thousands: "1,000".
std::string with_commas(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, ",");
  return text;
}

std::string part_of_rows(std::uint64_t found, std::uint64_t count) {
  return fmt::format("{} of {} particles", with_commas(found), with_commas(count));
}

}  // namespace

void throw_missing_rows(const ContentReader& content, std::uint64_t found, std::uint64_t count) {
  throw TruncatedFrame(fmt::format("expected {} lines of particles, found {} before the end of the file at line {}",
                                   count, found, content.line_number()),
                       part_of_rows(found, count));
}

void throw_cut_row(const TruncatedFrame& cut, std::uint64_t found, std::uint64_t count) {
  throw TruncatedFrame(cut.what(), part_of_rows(found, count));
}

std::optional<double> number_in(std::string_view word) {
  if (word.starts_with('+')) {
    word.remove_prefix(1);
    if (word.starts_with('-')) return std::nullopt;
  }
  const char* const last = word.data() + word.size();
  double value = 0;
  const auto [end, status] = std::from_chars(word.data(), last, value);
  if (end != last) return std::nullopt;
  if (status == std::errc{}) return value;
  if (status != std::errc::result_out_of_range) return std::nullopt;
  // A wider type shows whether the number is too large or too small for double; beyond its range the exponent does.
  long double wide = 0;
  if (std::from_chars(word.data(), last, wide).ec != std::errc{}) {
    const std::size_t exponent = word.find_first_of("eE");
    if (exponent == std::string_view::npos) return std::nullopt;
    wide = word.substr(exponent).find('-') != std::string_view::npos ? 0 : std::numeric_limits<long double>::infinity();
    if (word.starts_with('-')) wide = -wide;
  }
  const bool is_small = wide > -1 && wide < 1;
  const double size = is_small ? 0 : std::numeric_limits<double>::infinity();
  return std::signbit(wide) ? -size : size;
}

std::optional<double> DecimalReader::number(std::string_view word) {
  const std::size_t comma = word.find(',');
  const bool has_point = word.find('.') != std::string_view::npos;
  const char mark = comma != std::string_view::npos ? ',' : has_point ? '.' : '\0';
  if (mark == '\0') return number_in(word);
  if ((mark_ != '\0' && mark_ != mark) || (mark == ',' && has_point)) return std::nullopt;
  std::string text(word);
  if (mark == ',') text[comma] = '.';
  const auto value = number_in(text);
  if (value) mark_ = mark;
  return value;
}

std::optional<std::uint64_t> parse_whole_number(std::string_view word) {
  std::uint64_t value = 0;
  const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (status != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::optional<std::int64_t> parse_step(std::string_view word) {
  const auto step = parse_whole_number(word);
  if (!step || *step > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) return std::nullopt;
  return static_cast<std::int64_t>(*step);
}

std::optional<double> parse_time(std::string_view word) {
  const auto time = number_in(word);
  return time && std::isfinite(*time) ? time : std::nullopt;
}

void split_words(std::string_view line, std::vector<std::string_view>& words) {
  words.clear();
  const char* at = line.data();
  const char* const end = at + line.size();
  const auto is_space = [](char c) { return c == ' ' || c == '\t'; };
  while (true) {
    while (at != end && is_space(*at)) ++at;
    if (at == end) return;
    const char* const first = at;
    if (words.size() == kMaxParticleColumns) {
      words.emplace_back(first, static_cast<std::size_t>(end - first));
      return;
    }
    while (at != end && !is_space(*at)) ++at;
    words.emplace_back(first, static_cast<std::size_t>(at - first));
  }
}

std::string_view fixed_field(std::string_view line, std::size_t first, std::size_t count) {
  std::string_view field = first < line.size() ? line.substr(first, count) : std::string_view();
  while (!field.empty() && field.front() == ' ') field.remove_prefix(1);
  while (!field.empty() && field.back() == ' ') field.remove_suffix(1);
  return field;
}

void words_of_row(const ContentReader& content, std::string_view line, std::size_t count,
                  std::vector<std::string_view>& words) {
  split_words(line, words);
  if (words.size() != count) {
    content.expected(fmt::format("{} values of a particle (not {})", count, words.size()), line);
  }
}

void deliver_row(const ContentReader& content, const ParticleTable& table, std::span<const std::string_view> fields,
                 std::size_t particle, std::span<const ColumnSink> sinks, DecimalReader* decimals) {
  for (const ColumnSink& sink : sinks) {
    const std::string_view field = fields[sink.column];
    if (sink.words) {
      sink.put_word(particle, field);
      continue;
    }
    const auto value = field.empty()         ? std::numeric_limits<double>::quiet_NaN()
                       : decimals != nullptr ? decimals->number(field)
                                             : number_in(field);
    if (!value) {
      const bool other_mark = decimals != nullptr && DecimalReader().number(field).has_value();
      content.expected(fmt::format("a number as '{}'{}", printable(table.columns[sink.column].name, 80),
                                   other_mark ? ", with the same decimal mark as the numbers before" : ""),
                       field);
    }
    sink.put(particle, *value);
  }
}

void read_rows(ContentReader& content, const ParticleTable& table, std::uint64_t count,
               std::span<const ColumnSink> sinks) {
  std::vector<std::string_view> words;
  for_each_row(content, count, [&](std::uint64_t row, std::string_view line) {
    words_of_row(content, line, table.columns.size(), words);
    deliver_row(content, table, words, static_cast<std::size_t>(row), sinks);
  });
}

void skip_rows(ContentReader& content, std::uint64_t count, std::size_t columns) {
  std::vector<std::string_view> words;
  for_each_row(content, count, [&](std::uint64_t, std::string_view line) {
    if (!content.line_has_end() && columns > 0) words_of_row(content, line, columns, words);
  });
}

void mark_text_columns(ParticleTable& table, std::span<const std::string_view> fields, bool commas) {
  for (std::size_t i = 0; i < fields.size() && i < table.columns.size(); ++i) {
    if (fields[i].empty() || number_in(fields[i]) || (commas && DecimalReader().number(fields[i]))) continue;
    table.columns[i].numeric = false;
    table.columns[i].type = "text";
  }
}

void mark_text_columns_ahead(ContentReader& content, ParticleTable& table) {
  std::vector<std::string_view> words;
  split_words(content.peek_line().value_or(""), words);
  mark_text_columns(table, words);
}

}  // namespace isoextract::particle_io
