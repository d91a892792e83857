// What `info` found out about particles, and its two ways onto paper.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "cli/layout.hpp"
#include "convert/conversion_job.hpp"
#include "convert/json_type.hpp"
#include "particle_io/particle_reader.hpp"
#include "points/particle_field.hpp"
#include "points/particle_statistics.hpp"

namespace isoextract::cli {

// The values of an attribute that are finite, over all its components.
struct AttributeRange {
  particle_io::ParticleQuantity quantity;
  bool read = false;  // it is made of numbers
  std::uint64_t not_finite = 0;
  std::optional<double> min;  // nothing where no value is finite
  std::optional<double> max;
};

struct ParticleReport {
  particle_io::ParticleInfo info;
  std::string title;                  // of the format
  std::optional<std::int64_t> frame;  // that is described, where one was chosen or there are several
  std::uint64_t particles = 0;
  points::ParticleStatistics statistics;
  std::vector<AttributeRange> attributes;
  points::Method method = points::Method::sph;
  std::optional<points::FieldFigures> figures;  // of the field that would be extracted
  std::optional<Error> no_field;                // why there is none
  double read_seconds = 0;                      // what a conversion does before it extracts, as it took here
  double field_seconds = 0;
  std::vector<std::string> notes;
};

// The particles and the field that they make; the field is empty where there is none.
struct MeasuredParticles {
  ParticleReport report;
  std::optional<field::ScalarField> field;
};

// Particles at places that are no numbers are counted, and left out of the field.
[[nodiscard]] Result<MeasuredParticles> measure_particles(const convert::SourceOptions& source, const Context& context);

void add_particles(NamedLines& lines, const ParticleReport& report);
[[nodiscard]] convert::Json json_of(const ParticleReport& report);

}  // namespace isoextract::cli
