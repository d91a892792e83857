// The results of `info` for particles, as text and as JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "cli/layout.hpp"
#include "convert/conversion_job.hpp"
#include "convert/json_type.hpp"
#include "particle_io/particle_reader.hpp"
#include "points/particle_field.hpp"
#include "points/particle_statistics.hpp"

namespace isoextract::cli {

// The range of an attribute's values over all components, after conversion to float32. Values beyond the range of
// float32 count as not finite.
struct AttributeRange {
  particle_io::ParticleQuantity quantity;
  bool read = false;  // the attribute is numeric, and the report has its range
  std::uint64_t not_finite = 0;
  std::optional<double> min;  // unset if no value is finite
  std::optional<double> max;
};

// The words of an attribute, most frequent first.
struct WordCounts {
  std::string name;
  std::uint64_t words = 0;                                    // number of distinct words; 0: more than a reader keeps
  std::vector<std::pair<std::string, std::uint64_t>> counts;  // words and their particle counts, at most kShownWords
};
inline constexpr std::size_t kShownWords = 20;

struct ParticleReport {
  particle_io::ParticleInfo info;
  std::string title;                  // of the format
  std::optional<std::int64_t> frame;  // the described frame, from 0; set if the user chose one or the file has several
  std::uint64_t particles = 0;
  std::optional<std::uint64_t> chosen;  // number chosen by condition and stride; the members below describe these
  std::optional<points::SimulationBox> box;
  points::ParticleStatistics statistics;
  std::vector<AttributeRange> attributes;
  std::vector<WordCounts> words;
  points::Method method = points::Method::sph;
  std::optional<points::ParticleFieldStatistics> figures;  // of the field, made without points::FieldOptions::tile_iso
  std::optional<Error> no_field;                           // why the field could not be made
  double read_seconds = 0;   // time of reading the frame with all attributes; a conversion reads only those it needs
  double field_seconds = 0;  // time of making the field
  Notes notes;
};

// Results for particles and for the field made of them; `field` is unset if it could not be made or if no particle
// contributes to it.
struct MeasuredParticles {
  ParticleReport report;
  std::optional<field::ScalarField> field;
};

// Reads one frame with all attributes and makes the field of its particles. Counts particles at NaN or infinite
// positions, and leaves these particles out of the field. Fails as particle_io::describe_particles(),
// convert::keep_chosen(), give_element_radii(), apply_box_options() and points::measure_statistics() do, and with
// ErrorCode::cancelled. A field that cannot be made for another reason becomes ParticleReport::no_field.
[[nodiscard]] Result<MeasuredParticles> measure_particles(const convert::SourceOptions& source, const Context& context);

// Adds the report as the lines of `info`.
void add_particles(NamedLines& lines, const ParticleReport& report);
[[nodiscard]] convert::Json json_of(const ParticleReport& report);

}  // namespace isoextract::cli
