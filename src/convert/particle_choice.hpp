// Chooses particles by the condition and the stride of a job (points/selection.hpp).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "particle_io/particle_reader.hpp"
#include "points/particle_set.hpp"

namespace isoextract::convert {

struct ParticleCount {
  std::uint64_t chosen = 0;
  std::uint64_t of = 0;  // all particles that were read
};

// Returns the attributes that the condition and the radii of elements need.
[[nodiscard]] std::vector<particle_io::AttributeOfCondition> attributes_of_condition(const ParticleOptions& options);

// Removes the particles for which the condition is false. Of the others, keeps every ParticleOptions::stride-th, from
// the first on. Returns the counts, or nullopt if there is no condition and the stride is 1, so that all stay.
// Fails with ErrorCode::usage if the condition has an error, and as points::choose_particles() does.
[[nodiscard]] Result<std::optional<ParticleCount>> keep_chosen(points::ParticleSet& particles,
                                                               const ParticleOptions& options, const Context& context);

// Gives the particles the radii of their elements (ParticleOptions::element_radii), and appends notes about its
// assumptions to file.notes. Does nothing without the option. Fails as points::set_element_radii() does.
[[nodiscard]] Result<void> give_element_radii(particle_io::ParticleFile& file, const SourceOptions& options,
                                              const Context& context);

// Returns the region of the job, in world coordinates: particles that do not contribute to the field there may be left
// out. Returns nullopt if there is no region, or if the field needs all particles. Resampling and voxel coordinates
// need all particles, because both depend on the extents of the whole field.
[[nodiscard]] std::optional<field::Box> region_of_particles(const SourceOptions& options);

// Returns "the condition 'type == 9' chooses none of 1000 particles".
[[nodiscard]] std::string why_none_chosen(const ParticleCount& count, const ParticleOptions& options);

}  // namespace isoextract::convert
