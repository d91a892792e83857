// The numbers of a particle as a file has them side by side, what belongs together, and where those that are wanted go.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "particle_io/detail/content_reader.hpp"
#include "particle_io/detail/number_type.hpp"
#include "particle_io/detail/particle_source.hpp"
#include "points/particle_set.hpp"

namespace isoextract::particle_io {

inline constexpr std::size_t kMostColumns = 4096;

// One number, or word, of each particle.
struct ParticleColumn {
  std::string name;  // "vx"; of a part of a tuple "velocity:0"
  std::string unit;
  std::string type;
  bool numeric = true;
};

// Columns that are one quantity, in the order of its components.
struct ColumnGroup {
  std::string name;
  std::vector<std::size_t> columns;
  std::optional<AttributeKind> kind = {};  // where the file says so
};

struct ParticleTable {
  std::vector<ParticleColumn> columns;
  std::vector<ColumnGroup> groups;  // no two of one name; each column is in one
  // Where the format itself says what the position is, and the options say nothing.
  std::optional<std::array<std::size_t, 3>> position;
};

// Adds a column for each component, and the group of them.
void add_tuple(ParticleTable& table, const std::string& name, const std::string& type, std::size_t components,
               bool numeric = true, std::optional<AttributeKind> kind = {});
// Makes the groups of columns that only have names: those that follow each other and are named NAME:0, NAME:1, ... or
// NAMEx, NAMEy, NAMEz belong together, with one of ": _ . -" or a space between or nothing, or the number or the letter
// in brackets; NAME[r], NAME[g], NAME[b] and perhaps NAME[a] as well. NAME is the group's, "x y z" the one of the
// columns x, y and z.
void group_by_names(ParticleTable& table);
// Makes names of groups that are not the first of their kind NAME[1], NAME[2], ...
void make_group_names_unique(ParticleTable& table);

// "x [mm]" -> "x" and "mm"; also "x (mm)".
struct NameAndUnit {
  std::string name;
  std::string unit;
};
// Splits the headers of a table's columns, in their order. What counts components in brackets, as group_by_names()
// takes it, is no unit and stays in the name: "v[x]". A letter that may be either is a unit where the others do not
// follow: "mass [g]".
[[nodiscard]] std::vector<NameAndUnit> split_units(std::span<const std::string_view> headers);

// Which columns are wanted.
struct ColumnChoice {
  std::array<std::size_t, 3> position{};
  std::vector<ColumnGroup> attributes;
  std::string length_unit;
  std::vector<std::string> notes;
};

// Throws DamagedParticles where one of the columns is not made of numbers: "expected numbers as WHAT, found |S4 as
// 'x'".
void check_numbers(const ParticleTable& table, std::span<const std::size_t> wanted, std::string_view what,
                   const Hint& hint);

// Throws DamagedParticles where there is no position, no such column or attribute, or where an attribute is not made of
// numbers; the hint lists what there is. Columns of a position are not looked at: of a text, the row that is wrong is
// told when it is read.
[[nodiscard]] ColumnChoice choose_columns(const ParticleTable& table, const ParticleReadOptions& options);

// What is told of a table besides its position. Of one whose position cannot be found all columns, and a note of why.
void describe_table(const ParticleTable& table, const ParticleReadOptions& options, ParticleInfo& info);

// Throws DamagedParticles where `count` particles of at least `least_bytes` cannot be in what is left of the content.
void check_count(const ContentReader& content, std::uint64_t count, std::uint64_t least_bytes);

// A set without values; its memory is reserved before it is taken. `label` starts the message where that fails.
[[nodiscard]] points::ParticleSet make_particles(const Context& context, const std::string& label, std::uint64_t count,
                                                 const ColumnChoice& choice);

[[noreturn]] void refuse_particle(std::size_t particle, std::size_t particles);

// Where the values of one column go; either doubles or floats is null.
struct ColumnSink {
  std::size_t column = 0;
  double* doubles = nullptr;
  float* floats = nullptr;
  std::size_t stride = 1;     // from one particle to the next
  std::size_t particles = 0;  // that there is memory for

  // Throws DamagedParticles beyond the last particle, whatever a reader made of the counts in its file.
  void put(std::size_t particle, double value) const {
    if (particle >= particles) refuse_particle(particle, particles);
    if (doubles != nullptr) {
      doubles[particle * stride] = value;
    } else {
      floats[particle * stride] = static_cast<float>(value);
    }
  }
};
// By column. They point into `set`, which is not to be moved from meanwhile.
[[nodiscard]] std::vector<ColumnSink> sinks_of(points::ParticleSet& set, const ColumnChoice& choice);

// Records of one size in a binary file, and where in them the columns are.
struct RecordLayout {
  struct Field {
    std::optional<NumberType> type;  // nothing for bytes that are no number; no sink may ask for them
    std::size_t offset = 0;
    std::endian endian = std::endian::little;
  };
  std::size_t bytes = 0;      // at most ContentReader::kMostPeeked
  std::vector<Field> fields;  // of each column
};

// Puts the values of whole records, the first of them at particle `first`. Throws DamagedParticles where a sink asks
// for a field that is no number or does not lie within its record.
void put_records(const RecordLayout& layout, std::span<const std::byte> records, std::size_t first,
                 std::span<const ColumnSink> sinks);
// Those of the next `count` records of the content.
void read_records(ContentReader& content, const RecordLayout& layout, std::uint64_t count,
                  std::span<const ColumnSink> sinks);

}  // namespace isoextract::particle_io
