// Slabs of one ray, a batch at a time, vectorised: where their samples are, and what these look like (steps 2 and 3 of
// the model, renderer.hpp).
//
// Every number but the exponential is taken by the operations, in the order, of the formulas there, and none is fused
// with another, so all instruction sets give the same bits. The exponential is within 4 units in the last place.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/glm.hpp>

#include "render/transfer_function.hpp"

namespace isoextract::render::detail {

// The way of a ray through the volume's box. Depths are in units of Camera::unit().
struct SlabRay {
  double enter = 0;
  double leave = 0;
  double step = 1;        // of depth
  double slabs = 1;       // how many
  double length = 1;      // world units per depth
  double per_length = 1;  // unit lengths of the transfer function in one of the world
  glm::dvec3 eye{0.0};    // in index space
  glm::dvec3 along{0.0};  // index steps per depth
  glm::dvec3 first{0.0};  // the box's least and greatest cell
  glm::dvec3 greatest{0.0};
};

// How a stored number becomes a table position: VolumeSamples::position().
struct PositionScale {
  bool scaled = false;  // by slope and intercept
  double slope = 1;
  double intercept = 0;
  double min = 0;
  double per_value = 1;
};

struct SlabBatch {
  static constexpr std::size_t kSlabs = 16;

  std::size_t size = 0;
  alignas(64) std::array<double, kSlabs> number{};  // of the slab, from 0 on
  // By place():
  alignas(64) std::array<double, kSlabs> first{};  // depths of its borders
  alignas(64) std::array<double, kSlabs> last{};
  alignas(64) std::array<std::array<std::int32_t, kSlabs>, 3> cell{};  // that has its sample, by axis
  alignas(64) std::array<std::array<float, kSlabs>, 3> share{};        // of the way through that cell
  // By shade():
  alignas(64) std::array<glm::vec4, kSlabs> entry{};  // of the transfer function
  alignas(64) std::array<float, kSlabs> sigma{};      // 0 where a corner is NaN, whatever the entry has
  alignas(64) std::array<double, kSlabs> opacity{};   // of the whole slab
};

// Stored numbers at the corners of the samples' cells: corner n is n & 1, n >> 1 & 1, n >> 2 away.
template <class Raw>
struct CornerSamples {
  alignas(64) std::array<std::array<Raw, SlabBatch::kSlabs>, 8> at{};
};

// Of the batch's first `size` slabs.
void place(const SlabRay& ray, SlabBatch& batch);

void shade(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
           const CornerSamples<std::int32_t>& corners, SlabBatch& batch);
void shade(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
           const CornerSamples<float>& corners, SlabBatch& batch);
void shade(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
           const CornerSamples<double>& corners, SlabBatch& batch);

}  // namespace isoextract::render::detail
