// Values of particles at places of a surface: their attributes as attributes of its vertices.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "points/particle_set.hpp"

namespace isoextract::points {

struct SampledAttribute {
  std::string name;
  std::size_t components = 1;
  Buffer<float> values;  // components * vertices; those of one vertex together
};

struct SampledAttributes {
  std::vector<SampledAttribute> attributes;
  std::uint64_t out_of_reach = 0;  // vertices that no kernel reaches: they have the values of the nearest particle
  Reservation memory;
};

// The SPH interpolant of the values, with the kernels and densities of Method::sph in which `radius` (world units) and
// `smoothing_length` (in radii) are as in FieldOptions, divided by that of 1 (D. Shepard: A two-dimensional
// interpolation function for irregularly-spaced data. ACM National Conference 1968): a constant attribute stays
// constant, and none leaves the range of its values. Anisotropic kernels are not asked.
//
// `attributes` are numbers of particles.attributes. Particles at positions that are not finite are left out; values
// that are not finite make what they reach not finite. Vertices are in world units and finite. The same bits for any
// number of threads.
//
// Fails with ErrorCode::usage where a length is not above 0, with ErrorCode::input where there is no particle but a
// vertex, or where the memory is not there, and with ErrorCode::cancelled.
[[nodiscard]] Result<SampledAttributes> sample_attributes(const ParticleSet& particles,
                                                          std::span<const std::size_t> attributes,
                                                          std::span<const glm::dvec3> vertices, double radius,
                                                          double smoothing_length, const Context& context);

}  // namespace isoextract::points
