// Describes the columns of particle data, groups them into quantities, and delivers the selected ones to a particle
// set.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/note.hpp"
#include "particle_io/detail/content_reader.hpp"
#include "particle_io/detail/number_type.hpp"
#include "particle_io/detail/particle_source.hpp"
#include "points/particle_set.hpp"

namespace isoextract::particle_io {

inline constexpr std::size_t kMaxParticleColumns = 4096;

// One number or word per particle.
struct ParticleColumn {
  std::string name;  // "vx"; "velocity:0" for a component of a tuple
  std::string unit;
  std::string type;
  bool numeric = true;
  bool has_words = true;  // false: not readable as words, even if ParticleTable::has_words is set
};

// Columns that are the components of one quantity, in order.
struct ColumnTuple {
  std::string name;
  std::vector<std::size_t> columns;
  std::optional<AttributeKind> kind = {};  // if the file specifies it
};

struct ParticleTable {
  std::vector<ParticleColumn> columns;
  std::vector<ColumnTuple> groups;  // with unique names; each column belongs to one group
  // The position, if the format specifies it and the options do not.
  std::optional<std::array<std::size_t, 3>> position;
  bool has_words = false;  // columns that are not numeric can be read as words
};

// Adds a column for each component, and their group.
void add_tuple(ParticleTable& table, const std::string& name, const std::string& type, std::size_t components,
               bool numeric = true, std::optional<AttributeKind> kind = {});
// Groups columns by name. Consecutive columns form a group NAME if they are called NAME:0, NAME:1, ... (at most to 9)
// or NAMEx, NAMEy, NAMEz. The separator is one of ": _ . -", a space or nothing, or the suffix is in brackets. NAME[r],
// NAME[g], NAME[b] with or without NAME[a] also form a group, and so do NAME.r, NAME.g, NAME.b with any of the
// separators. The columns x, y and z form the group "x y z". A group does not mix numeric and other columns, unless its
// name is that of a position ("pos").
void group_by_names(ParticleTable& table);
// Renames later groups of the same name to NAME[1], NAME[2], ...
void make_group_names_unique(ParticleTable& table);

// "x [mm]" -> "x" and "mm"; also "x (mm)".
struct NameAndUnit {
  std::string name;
  std::string unit;
};
// Splits the column headers of a table, in order. A bracket that names a component, as in group_by_names(), is not a
// unit and stays in the name: "v[x]". An ambiguous letter is a unit if the other components do not follow: "mass [g]".
[[nodiscard]] std::vector<NameAndUnit> split_units(std::span<const std::string_view> headers);

// A column to read as words.
struct WordColumn {
  std::string name;
  std::size_t column = 0;
  bool wanted = true;  // false: more than kMaxDistinctWords words are no error
};
inline constexpr std::size_t kMaxDistinctWords = 65536;
inline constexpr std::size_t kMaxWordBytes = std::size_t{16} << 20;  // of all distinct words of a column

// The selected columns.
struct ColumnChoice {
  std::array<std::size_t, 3> position{};
  std::vector<ColumnTuple> attributes;
  std::vector<WordColumn> words;
  std::string length_unit;
  Notes notes;
};

// Throws InvalidParticleFile if one of the columns is not numeric: "expected numbers for WHAT, found |S4 in the column
// 'x'".
void check_numbers(const ParticleTable& table, std::span<const std::size_t> wanted, std::string_view what,
                   const Hint& hint);

// Throws InvalidParticleFile if there is no position, if a selected column or attribute does not exist, or if an
// attribute is not numeric; the hint lists the existing ones. Does not check that the columns of a position are
// numeric: in text, reading reports the invalid row.
[[nodiscard]] ColumnChoice choose_columns(const ParticleTable& table, const ParticleReadOptions& options);

// Adds the groups of a table except the position. If the position cannot be found, adds all groups and a note with the
// reason; throws InvalidParticleFile instead if options.columns is set.
void describe_table(const ParticleTable& table, const ParticleReadOptions& options, ParticleInfo& info);

// Makes a set without values; reserves its memory first. `label` starts the message of a failure.
[[nodiscard]] points::ParticleSet make_particles(const Context& context, const std::string& label, std::uint64_t count,
                                                 const ColumnChoice& choice);

// Gives the set of `file` the box of its frame. `in_axis_order`: the position columns are x, y and z of the file, in
// this order. Leaves out the box if they are not, or if it has no volume; adds a note if that box is periodic.
void set_box(const points::SimulationBox& box, bool in_axis_order, ParticleFile& file);

[[noreturn]] void throw_particle_error(std::size_t particle, std::size_t particles);

// Numbers the words of a column in the order of their first particle.
class WordIndexer {
 public:
  WordIndexer(points::ParticleWords& to, bool wanted) : to_(to), wanted_(wanted) {}

  // Calls give_up() beyond kMaxDistinctWords words or kMaxWordBytes bytes.
  void put(std::size_t particle, std::string_view word);
  // Throws InvalidParticleFile if the column is wanted, else sets ParticleWords::too_many; put() then has no effect.
  void give_up();

 private:
  points::ParticleWords& to_;
  bool wanted_;
  std::size_t bytes_ = 0;
  std::string last_;  // most words repeat
  std::uint32_t last_index_ = 0;
  std::unordered_map<std::string, std::uint32_t> indices_;
};

// Destination of one column's values; one of doubles, floats and words is set.
struct ColumnSink {
  std::size_t column = 0;
  double* doubles = nullptr;
  float* floats = nullptr;
  std::size_t stride = 1;     // distance between consecutive particles
  std::size_t particles = 0;  // capacity
  std::shared_ptr<WordIndexer> words = {};

  // Throws InvalidParticleFile beyond the last particle, so that a wrong count in a file cannot cause an overflow.
  void put(std::size_t particle, double value) const {
    if (particle >= particles) throw_particle_error(particle, particles);
    if (doubles != nullptr) {
      doubles[particle * stride] = value;
    } else {
      floats[particle * stride] = static_cast<float>(value);
    }
  }
  void put_word(std::size_t particle, std::string_view word) const {
    if (particle >= particles) throw_particle_error(particle, particles);
    words->put(particle, word);
  }
};
// Returns the destinations by column. They point into `set`, which must stay in place.
[[nodiscard]] std::vector<ColumnSink> sinks_of(points::ParticleSet& set, const ColumnChoice& choice);

// The layout of fixed-size records in a binary file.
struct RecordLayout {
  struct Field {
    std::optional<NumberType> type;  // empty: not a number; no sink may need it
    std::size_t offset = 0;
    std::endian endian = std::endian::little;
  };
  std::size_t bytes = 0;      // at most ContentReader::kMaxPeekedBytes
  std::vector<Field> fields;  // one per column
};

// Delivers the values of whole records, starting with particle `first`. Throws InvalidParticleFile if a sink needs a
// field that is not a number or not within its record.
void deliver_records(const RecordLayout& layout, std::span<const std::byte> records, std::size_t first,
                     std::span<const ColumnSink> sinks);
// Reads the next `count` records of the content and delivers their values.
void read_records(ContentReader& content, const RecordLayout& layout, std::uint64_t count,
                  std::span<const ColumnSink> sinks);

}  // namespace isoextract::particle_io
