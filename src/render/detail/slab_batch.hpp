// Computes positions, colors and opacities of a ray's slabs in vectorized batches (steps 2 and 3 of the model,
// renderer.hpp).
//
// All results except the exponential use the operations of the formulas in renderer.hpp, in their order and
// without fused multiply-add, so all instruction sets give the same bits. The exponential is accurate to 4 units
// in the last place.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/glm.hpp>

#include "render/transfer_function.hpp"

namespace isoextract::render::detail {

// The segment of a ray in the volume's box. Depths are in units of Camera::unit().
struct SlabRay {
  double enter = 0;
  double leave = 0;
  double step = 1;        // in depth
  double slabs = 1;       // number of slabs
  double length = 1;      // world units per depth
  double per_length = 1;  // transfer function lengths per world unit
  glm::dvec3 eye{0.0};    // in index space
  glm::dvec3 along{0.0};  // index steps per depth
  glm::dvec3 first{0.0};  // the first and the last cell of the box
  glm::dvec3 greatest{0.0};
};

// The parameters of VolumeSamples::position(), which maps stored values to table positions.
struct PositionScale {
  bool scaled = false;  // slope and intercept apply
  double slope = 1;
  double intercept = 0;
  double min = 0;
  double positions_per_value = 1;
};

struct SlabBatch {
  static constexpr std::size_t kSlabs = 16;

  std::size_t size = 0;
  alignas(64) std::array<double, kSlabs> number{};  // the slab's number, from 0
  // Set by place():
  alignas(64) std::array<double, kSlabs> first{};  // depths where the slab begins and ends
  alignas(64) std::array<double, kSlabs> last{};
  alignas(64) std::array<std::array<std::int32_t, kSlabs>, 3> cell{};  // the cell of its sample, by axis
  alignas(64) std::array<std::array<float, kSlabs>, 3> share{};        // position of the sample in that cell, 0 to 1
  // Set by shade():
  alignas(64) std::array<glm::vec4, kSlabs> entry{};  // from the transfer function
  alignas(64) std::array<float, kSlabs> sigma{};      // 0 if a corner is NaN, whatever the entry is
  alignas(64) std::array<double, kSlabs> opacity{};   // of the whole slab
};

// Stored values at the corners of the samples' cells. Corner n is offset by (n & 1, n >> 1 & 1, n >> 2).
template <class Raw>
struct CornerSamples {
  alignas(64) std::array<std::array<Raw, SlabBatch::kSlabs>, 8> at{};
};

// Computes the fields that SlabBatch marks as set by this function, for the first batch.size slabs.
void place(const SlabRay& ray, SlabBatch& batch);

void shade(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
           const CornerSamples<std::int32_t>& corners, SlabBatch& batch);
void shade(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
           const CornerSamples<float>& corners, SlabBatch& batch);
void shade(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
           const CornerSamples<double>& corners, SlabBatch& batch);

}  // namespace isoextract::render::detail
