// Statistics of many distances: rms, 99th percentile, and the maximum with its position.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::accuracy {

// One distance, in voxels (index space) and in the mesh's coordinates.
struct Length {
  double voxels = 0;
  double world = 0;
};

struct ErrorStatistics {
  std::uint64_t points = 0;  // points with a distance
  Length rms;
  // Weighted as in ErrorAccumulator::add(). Rounded up to the edge of a bin: at most 1/64 too large, at least about
  // 2^-60 voxels, but never above max.
  Length percentile99;
  Length max;
  glm::dvec3 worst{0.0};  // the point with max.world, in the mesh's coordinates

  // Points without a distance, which no figure above includes.
  std::uint64_t not_finite = 0;  // next to a NaN or infinite sample
  std::uint64_t outside = 0;     // beyond the outermost samples, where always-closed methods put triangles
  std::uint64_t unreached = 0;   // there is no surface, or the iterations did not converge to it

  // Points (of `points`) whose distance differs from the estimate |f - iso| / |grad f| by more than half of the
  // estimate.
  std::uint64_t corrected = 0;

  // Takes max and worst of `other`, measured at other points of the same mesh, where they are larger; changes no other
  // figure. Does nothing if either has no points.
  void include_max(const ErrorStatistics& other);
  [[nodiscard]] std::uint64_t unmeasured() const { return not_finite + outside + unreached; }
};

// Accumulates distances one by one. Merging in a fixed order (base/reduction.hpp) makes the result independent of the
// number of threads. Another order may change rms in its last digits, percentile99 by one bin, and `worst` among points
// at equal distances.
class ErrorAccumulator {
 public:
  // `world_voxel` is the approximate length of a voxel in the mesh's coordinates.
  explicit ErrorAccumulator(double world_voxel) : world_voxel_(world_voxel) {}

  void add(const Length& length, double weight, const glm::dvec3& position);
  void merge(const ErrorAccumulator& other);
  [[nodiscard]] ErrorStatistics result() const;

  // The caller counts the points without a distance and the corrected points in this member; add() counts `points`.
  ErrorStatistics counts;

 private:
  [[nodiscard]] double percentile(const std::vector<double>& bins, double largest, double fraction) const;

  double world_voxel_;
  double weight_ = 0;
  Length squares_;  // weighted
  Length max_;
  glm::dvec3 worst_{0.0};
  std::vector<double> voxel_bins_;  // total weight of the distances in each bin; 64 bins an octave
  std::vector<double> world_bins_;
};

}  // namespace isoextract::accuracy
