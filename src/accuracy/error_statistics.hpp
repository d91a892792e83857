// What many distances come to: rms, 99 %, maximum and where.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::accuracy {

// The same step, measured in index space and in the mesh's own coordinates.
struct Length {
  double voxels = 0;
  double world = 0;
};

struct ErrorStatistics {
  std::uint64_t points = 0;  // that a distance was found for
  Length rms;
  Length percentile99;  // of the weight; rounded up by at most 1/64
  Length max;
  glm::dvec3 worst{0.0};  // where max.world is, in the mesh's coordinates

  // What is in none of the figures above, because there is no distance to tell.
  std::uint64_t not_finite = 0;  // beside samples that are NaN or infinite
  std::uint64_t outside = 0;     // beyond the outermost samples, where always closed methods put triangles
  std::uint64_t unreached = 0;   // no surface at all, or none that an iteration came to

  // Of `points`: where |f - iso| / |grad f| alone is off by more than half.
  std::uint64_t corrected = 0;

  // Takes over the maximum of other points of the same mesh where it is greater; no other figure changes.
  void raise_max(const ErrorStatistics& other);
  [[nodiscard]] std::uint64_t unmeasured() const { return not_finite + outside + unreached; }
};

// Takes distances one by one. The answer depends on the order of merging only in the last digits of rms; merged in a
// fixed order (base/parallel.hpp) it is the same for any number of threads.
class ErrorAccumulator {
 public:
  // `world_voxel` is about how long a voxel is in the world.
  explicit ErrorAccumulator(double world_voxel) : world_voxel_(world_voxel) {}

  void add(const Length& length, double weight, const glm::dvec3& position);
  void merge(const ErrorAccumulator& other);
  [[nodiscard]] ErrorStatistics result() const;

  ErrorStatistics counts;  // whoever adds counts here what is not a distance

 private:
  [[nodiscard]] double percentile(const std::vector<double>& bins, double largest, double fraction) const;

  double world_voxel_;
  double weight_ = 0;
  Length squares_;  // weighted
  Length max_;
  glm::dvec3 worst_{0.0};
  std::vector<double> voxel_bins_;  // weight by size, on a scale that is logarithmic between powers of two
  std::vector<double> world_bins_;
};

}  // namespace isoextract::accuracy
