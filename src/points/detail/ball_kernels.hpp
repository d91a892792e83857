// SPH kernels of particles with unlike radii: a ball for each particle. The radius of the ball is proportional to the
// radius of the particle.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "points/cell_grid.hpp"
#include "points/detail/kernel_bricks.hpp"

namespace isoextract::points {

// The particles with radii of at least `smallest`. A kernel that reaches less than one sample could fall
// between the samples.
struct LargeEnough {
  std::shared_ptr<ReservedBuffer<glm::dvec3>> positions;  // not finite for particles left out
  std::uint64_t too_small = 0;
};
[[nodiscard]] Result<LargeEnough> leave_out_small(std::span<const glm::dvec3> positions, std::span<const float> radii,
                                                  double smallest, const Context& context, const std::string& label);

class BallKernels {
 public:
  // Makes the kernels of the particles that `grid` holds apart (Coinciding::apart), in index coordinates. `radii` has
  // the radius of each particle; `support` is the reach of the kernel of a particle of radius 1, and `reach` the
  // largest reach of a kernel. The masses m_j are proportional to the cubes of the radii, and so are the volumes of the
  // kernels; H_j is the reach of kernel j. Density and field are
  //   rho_j = sum_k m_k W(x_j - x_k, H_k),   field(x) = sum_j m_j / rho_j W(x - x_j, H_j)
  // As m_j / H_j^3 is equal for all particles, the weight of kernel j is 1 / sum_k S(|x_j - x_k| / H_k). The
  // density uses the kernels of the field, of reach H_k. Between particles of unlike sizes, this keeps the field
  // nearer to 1 than kernels of reach H_j would. `grid` must outlive the kernels. Fails as Context::reserve()
  // and Context::check() do.
  [[nodiscard]] static Result<BallKernels> make(const CellGrid& grid, std::span<const float> radii, double support,
                                                double reach, const Context& context, const std::string& label);

  [[nodiscard]] KernelSet set() const {
    return {grid_, weights_->values.data(), shapes_->values.data(), nullptr, reach_};
  }

 private:
  const CellGrid* grid_ = nullptr;
  double reach_ = 0;
  std::shared_ptr<ReservedBuffer<float>> weights_;
  std::shared_ptr<ReservedBuffer<Ellipsoid>> shapes_;
};

}  // namespace isoextract::points
