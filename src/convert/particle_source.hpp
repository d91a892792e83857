// Inputs that are particles: told from volumes, read, and made a field.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"
#include "particle_io/particle_reader.hpp"
#include "points/particle_field.hpp"

namespace isoextract::convert {

// Whether the input is read as particles: where that is expected, and else where its content or, of formats that only
// their names tell, its name says so. Volumes come first, but for files of points alone in a format that holds both,
// and for sets of points in one that are chosen by name. Fails with ErrorCode::usage where particles are expected and
// the input is a volume, and where it is of particles and options are about volumes; and where it cannot be read.
[[nodiscard]] Result<bool> is_particles(const SourceOptions& options, const Context& context);

// list_input_files() or count_volumes(), of particles the file and its frames. Files that attributes are read from are
// among them.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_source_files(const SourceOptions& options,
                                                                           const Context& context);
[[nodiscard]] Result<std::uint64_t> count_frames(const SourceOptions& options, const Context& context);

// How such an input is read. With `missing_is_fine` its attributes need not be there; optional ones never need.
[[nodiscard]] particle_io::ParticleReadOptions particle_read_options(const SourceOptions& options,
                                                                     bool missing_is_fine = false);
// How it becomes a field. `only_iso` is FieldOptions::leave_out_inside.
[[nodiscard]] points::FieldOptions field_options(const ParticleOptions& options, std::optional<double> only_iso);

// Particles that are kept for the attributes of vertices.
struct ParticleAttributes {
  points::ParticleSet particles;
  std::vector<AttributeChoice> choices;
  std::vector<std::size_t> attributes;  // of the particles, one a choice
  double radius = 0;
  double smoothing_length = 0;
};

// Where the attributes are that were chosen.
struct FoundAttributes {
  std::vector<AttributeChoice> choices;
  std::vector<std::size_t> attributes;  // of the particles, one a choice
  std::vector<MissingAttribute> missing;
};

// Fails with ErrorCode::input where an attribute has more components than a vertex can carry or is not there, unless it
// is optional or `missing_is_fine`, and with ErrorCode::usage where a choice is about volumes.
[[nodiscard]] Result<FoundAttributes> find_attributes(const points::ParticleSet& particles,
                                                      const std::vector<AttributeChoice>& choices,
                                                      bool missing_is_fine);

}  // namespace isoextract::convert
