// Parses rows of text files: splits lines into words and numbers and delivers them to a particle set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/detail/particle_source.hpp"

namespace isoextract::particle_io {

// Parses all of `word` as a number, also NaN and infinity. Returns 0 for numbers too small for double, infinity for
// numbers too large.
[[nodiscard]] std::optional<double> number_in(std::string_view word);
[[nodiscard]] std::optional<std::uint64_t> parse_whole_number(std::string_view word);
// Returns the step of a frame; nothing if the word is not a whole number that fits.
[[nodiscard]] std::optional<std::int64_t> parse_step(std::string_view word);
// Returns the time of a frame; nothing if the word is not a finite number.
[[nodiscard]] std::optional<double> parse_time(std::string_view word);

// Parses numbers with a decimal point or comma, whichever the first one uses: some languages write commas. Returns
// nothing for a number with the other mark, or with both marks: one of them may separate thousands.
class DecimalReader {
 public:
  [[nodiscard]] std::optional<double> number(std::string_view word);

  [[nodiscard]] bool found_commas() const { return mark_ == ','; }

 private:
  char mark_ = '\0';  // 0 until the first one is found
};

// Splits at spaces and tabs; everything after kMaxParticleColumns words is one word.
void split_words(std::string_view line, std::vector<std::string_view>& words);

// Splits a line that must have `count` words. Throws InvalidParticleFile.
void words_of_row(const ContentReader& content, std::string_view line, std::size_t count,
                  std::vector<std::string_view>& words);

// Returns the characters [first, first + count) of a line with fixed columns, without blanks around them; fewer or none
// if the line is too short.
[[nodiscard]] std::string_view fixed_field(std::string_view line, std::size_t first, std::size_t count);

// Delivers the numbers of a row to particle `particle`. An empty field is NaN. Without `decimals`, only decimal points
// are accepted. Throws InvalidParticleFile.
void deliver_row(const ContentReader& content, const ParticleTable& table, std::span<const std::string_view> fields,
                 std::size_t particle, std::span<const ColumnSink> sinks, DecimalReader* decimals = nullptr);

// Throws TruncatedFrame: the text ends after `found` of `count` particles.
[[noreturn]] void throw_missing_rows(const ContentReader& content, std::uint64_t found, std::uint64_t count);
// Does the same with the message of `cut`, for a text that ends within the next line.
[[noreturn]] void throw_cut_row(const TruncatedFrame& cut, std::uint64_t found, std::uint64_t count);

// Calls use(row, line) for the next `count` lines. Throws TruncatedFrame if the text has fewer lines, or if
// use() throws it.
template <class Use>
void for_each_row(ContentReader& content, std::uint64_t count, Use&& use) {
  for (std::uint64_t row = 0; row < count; ++row) {
    const auto line = content.next_line();
    if (!line) throw_missing_rows(content, row, count);
    try {
      use(row, *line);
    } catch (const TruncatedFrame& cut) {
      throw_cut_row(cut, row, count);
    }
  }
}

// Reads the next `count` lines as rows of words. Throws as for_each_row() does, and InvalidParticleFile.
void read_rows(ContentReader& content, const ParticleTable& table, std::uint64_t count,
               std::span<const ColumnSink> sinks);
// Skips the next `count` lines. Throws TruncatedFrame if the text has fewer lines, or if a line without a line end does
// not have `columns` words. With 0 columns, accepts any number of words.
void skip_rows(ContentReader& content, std::uint64_t count, std::size_t columns = 0);

// Marks as text the columns whose field in `fields`, the first row, is not a number. `commas`: accepts decimal commas.
void mark_text_columns(ParticleTable& table, std::span<const std::string_view> fields, bool commas = false);
// Does the same for the words of the next line, without consuming it.
void mark_text_columns_ahead(ContentReader& content, ParticleTable& table);

}  // namespace isoextract::particle_io
