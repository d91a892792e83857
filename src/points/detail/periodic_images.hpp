// Particles and kernels repeated by a periodic box.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "points/cell_grid.hpp"
#include "points/detail/box_samples.hpp"
#include "points/detail/kernel_bricks.hpp"

namespace isoextract::points {

// The field continues periodically in this many samples on each side of the region. Extraction reads two of them.
inline constexpr int kPeriodicMargin = 3;

// Returns the box of the samples that the field needs: the region with the margin and `more` samples around it.
[[nodiscard]] field::IndexBox needed_samples(const BoxSamples& box, int more);

// Returns the largest distance from the region, along each index axis, at which an image can contribute to a brick with
// needed samples. `extent` is the reach of an image along each axis.
[[nodiscard]] glm::dvec3 reach_of_images(const glm::dvec3& extent, int more);

enum class Coordinates { cartesian, index };

// Particles in the box, in their order, followed by images.
struct ParticleImages {
  std::shared_ptr<ReservedBuffer<glm::dvec3>> places;
  std::shared_ptr<ReservedBuffer<std::uint32_t>> sources;  // for each position: the index of its particle

  [[nodiscard]] std::span<const glm::dvec3> positions() const { return std::as_const(places->values).span(); }
};

// Returns the particles, moved into the box, and their images that lie at most `reach` outside the region, in index
// units along each axis. A position that is not finite stays.
//
// Fails with ErrorCode::input if particles and images together are 2^32 - 1 or more, or if a particle is too far away
// for index coordinates. Fails as Context::reserve() does; `label` starts the messages.
[[nodiscard]] Result<ParticleImages> with_images(std::span<const glm::dvec3> positions, const BoxSamples& box,
                                                 const glm::dvec3& reach, Coordinates coordinates,
                                                 const Context& context, const std::string& label);

// Owns the arrays of a KernelSet in index coordinates.
struct RepeatedKernels {
  CellGrid grid;
  std::shared_ptr<ReservedBuffer<float>> weights;
  std::shared_ptr<ReservedBuffer<Ellipsoid>> shapes;  // null if the kernels are balls in index coordinates
  std::shared_ptr<ReservedBuffer<std::uint32_t>> counts;
  double reach = 0;

  [[nodiscard]] KernelSet set() const {
    return {&grid, weights->values.data(), shapes ? shapes->values.data() : nullptr, counts->values.data(), reach};
  }
};

// Returns the kernels for which is_original(spot) holds, and their images that reach a brick with needed samples (see
// needed_samples()). `kernels` are in Cartesian coordinates. Images count no particles. Fails as with_images() does.
[[nodiscard]] Result<RepeatedKernels> repeat_kernels(const KernelSet& kernels,
                                                     const std::function<bool(std::size_t)>& is_original,
                                                     const BoxSamples& box, int more, const Context& context,
                                                     const std::string& label);

}  // namespace isoextract::points
