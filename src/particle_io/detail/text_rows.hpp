// Rows of a text file: words and numbers of a line, and from there into a set of particles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "particle_io/detail/particle_columns.hpp"

namespace isoextract::particle_io {

// The whole of `word` as a number, NaN and infinities among them. One too small for double is 0, one too large
// infinite.
[[nodiscard]] std::optional<double> number_in(std::string_view word);
[[nodiscard]] std::optional<std::uint64_t> whole_number_in(std::string_view word);

// Numbers whose decimals have a point or a comma, whichever the first one has: spreadsheets write commas in some
// languages. Nothing for a number with the other mark or with both, which may be a thousands separator.
class DecimalReader {
 public:
  [[nodiscard]] std::optional<double> number(std::string_view word);

  [[nodiscard]] bool found_commas() const { return mark_ == ','; }

 private:
  char mark_ = '\0';  // none so far
};

// Words with spaces and tabs between them; what is beyond kMostColumns of them is one word.
void split_words(std::string_view line, std::vector<std::string_view>& words);

// The words of a line that must have that many of them. Throws DamagedParticles.
void words_of_row(const ContentReader& content, std::string_view line, std::size_t count,
                  std::vector<std::string_view>& words);

// The numbers of a row, for particle `particle`. An empty field is NaN. Decimals have points unless `decimals` reads
// them. Throws DamagedParticles.
void put_row(const ContentReader& content, const ParticleTable& table, std::span<const std::string_view> fields,
             std::size_t particle, std::span<const ColumnSink> sinks, DecimalReader* decimals = nullptr);

// The next `count` lines as rows of words. Throws DamagedParticles where the text ends before.
void read_rows(ContentReader& content, const ParticleTable& table, std::uint64_t count,
               std::span<const ColumnSink> sinks);
// Past the next `count` lines, likewise.
void skip_rows(ContentReader& content, std::uint64_t count);

// Says of columns whose field in this row, the first one, is no number that they are text. `commas`: decimals may have
// commas.
void look_for_text(ParticleTable& table, std::span<const std::string_view> fields, bool commas = false);
// The same for the row of words that is the next line.
void look_for_text_ahead(ContentReader& content, ParticleTable& table);

}  // namespace isoextract::particle_io
