// Interpolates particle attributes at mesh vertices.
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
  Buffer<float> values;  // components * vertices; the values of one vertex are consecutive
};

struct SampledAttributes {
  std::vector<SampledAttribute> attributes;
  // Vertices outside every kernel; they get the values of the nearest particle.
  std::uint64_t vertices_beyond_kernels = 0;
  Reservation memory;
};

// Interpolates attributes with the kernels and densities of Method::sph, divided by the interpolated constant 1 (D.
// Shepard: A two-dimensional interpolation function for irregularly-spaced data. ACM National Conference 1968). So a
// constant attribute stays constant and no result leaves the range of its attribute. `radius` (world units) and
// `smoothing_length` (in radii) are as in FieldOptions. Always uses balls of one radius as kernels, even if the field
// has anisotropic kernels or kernels of unlike radii.
//
// In a periodic box (ParticleSet::box), kernels reach across its faces.
//
// `attributes` are indices into particles.attributes; `vertices` are finite, in world units. Skips particles at
// non-finite positions; a non-finite attribute value makes all vertices within its kernel non-finite. The result is
// bit-identical for any number of threads.
//
// Fails with ErrorCode::usage if a length is not above 0 or too large for double, with ErrorCode::input if there are
// vertices but no particles, or particles too far apart, with ErrorCode::out_of_memory, and with ErrorCode::cancelled.
[[nodiscard]] Result<SampledAttributes> sample_attributes(const ParticleSet& particles,
                                                          std::span<const std::size_t> attributes,
                                                          std::span<const glm::dvec3> vertices, double radius,
                                                          double smoothing_length, const Context& context);

}  // namespace isoextract::points
