// Which bricks of cells have anything to be seen.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "render/detail/volume_samples.hpp"

namespace isoextract::render::detail {

// Brick b has the cells from 8 b on, 8 a side; the samples at its far side are its neighbours' too. A brick is not
// seen where no lookup between its least and its greatest sample has a sigma. NaN has none itself.
//
// Sparse fields have bricks of their own around stored blocks; elsewhere a brick has as many
// values as the places at its corners, and those are looked up when it is asked for.
class VolumeBricks {
 public:
  static constexpr int kCells = 8;

  // Reads every sample once. Memory is reserved for as long as this lives; `samples` outlives it.
  [[nodiscard]] static Result<VolumeBricks> measure(const VolumeSamples& samples, const Context& context);

  [[nodiscard]] bool seen(const glm::ivec3& brick) const;
  [[nodiscard]] std::uint64_t count() const { return seen_.size(); }
  [[nodiscard]] std::uint64_t count_unseen() const;

 private:
  explicit VolumeBricks(const VolumeSamples& samples) : samples_(&samples) {}

  const VolumeSamples* samples_;
  glm::i64vec3 dims_{0};             // in bricks, of dense fields
  field::OriginIndex index_;         // of sparse ones, by origin
  std::vector<glm::ivec3> origins_;  // likewise
  std::vector<std::uint8_t> seen_;
  Reservation memory_;
};

}  // namespace isoextract::render::detail
