// Interpolates particle attributes at mesh vertices.
#pragma once

#include <cstdint>
#include <memory>
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
// constant attribute stays constant and no result leaves the range of its attribute. Always uses balls of one radius as
// kernels, even if the field has anisotropic kernels or kernels of unlike radii. In a periodic box (ParticleSet::box),
// kernels reach across its faces. Skips particles at non-finite positions; a non-finite attribute value makes all
// vertices within its kernel non-finite.
class AttributeSampler {
 public:
  // `particles` must outlive the sampler; `attributes` are indices into particles.attributes. `radius` (world units)
  // and `smoothing_length` (in radii) are as in FieldOptions. Holds reservations for its tables. Fails with
  // ErrorCode::usage if a length is not above 0 or too large for double, with ErrorCode::input if there are no
  // particles, or particles too far apart, with ErrorCode::out_of_memory, and with ErrorCode::cancelled.
  [[nodiscard]] static Result<AttributeSampler> make(const ParticleSet& particles,
                                                     std::span<const std::size_t> attributes, double radius,
                                                     double smoothing_length, const Context& context);
  AttributeSampler(AttributeSampler&& other) noexcept;
  AttributeSampler& operator=(AttributeSampler&& other) noexcept;
  ~AttributeSampler();

  // `vertices` are finite, in world units. The result is bit-identical for any number of threads, and the values of a
  // vertex do not depend on the other vertices. Several threads may call it at once. Fails with
  // ErrorCode::out_of_memory and with ErrorCode::cancelled.
  [[nodiscard]] Result<SampledAttributes> sample(std::span<const glm::dvec3> vertices, const Context& context) const;

 private:
  struct State;
  explicit AttributeSampler(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

// Samples attributes once, as AttributeSampler does. Without vertices, there may be no particles.
[[nodiscard]] Result<SampledAttributes> sample_attributes(const ParticleSet& particles,
                                                          std::span<const std::size_t> attributes,
                                                          std::span<const glm::dvec3> vertices, double radius,
                                                          double smoothing_length, const Context& context);

}  // namespace isoextract::points
