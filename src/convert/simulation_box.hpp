// The simulation box of particles: options that change it, and the region to which it limits a surface.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "field/samples.hpp"
#include "points/particle_set.hpp"

namespace isoextract::convert {

// The attributes that count how often a particle has crossed the box along each edge (LAMMPS).
inline constexpr std::array<const char*, 3> kImageFlags{"ix", "iy", "iz"};

// Sets the box and its periodic edges from the options. For BoxOptions::unwrap, moves each particle by its image
// flags times the edges; the box is then not periodic, as the surface belongs to no period.
//
// Fails with ErrorCode::input if periodic edges or unwrapped positions are requested without a box, if image
// flags are missing, or if the positions are already unwrapped. Fails with ErrorCode::usage if a side of the box
// is not longer than 0.
[[nodiscard]] Result<void> apply_box_options(const BoxOptions& options, points::ParticleSet& particles);

// Returns how many samples beyond the region the filters and blurs of a field read at most.
[[nodiscard]] int filter_reach(const SourceOptions& options);

// Returns the overlap of `period`, the region of a periodic box, and the requested region; without a requested region,
// returns `period`. Fails with ErrorCode::input if the overlap has no cell.
[[nodiscard]] Result<field::IndexBox> common_region(const field::IndexBox& period,
                                                    const std::optional<field::IndexBox>& requested,
                                                    const std::string& label);

}  // namespace isoextract::convert
