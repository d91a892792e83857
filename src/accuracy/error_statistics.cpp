#include "accuracy/error_statistics.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace isoextract::accuracy {
namespace {

// A bin is a binary exponent and its next 6 bits: 64 bins an octave, from 2^-60 to 2^20 voxels.
constexpr int kBitsABin = 6;
constexpr std::uint64_t kFirst = std::bit_cast<std::uint64_t>(0x1p-60) >> (52 - kBitsABin);
constexpr std::uint64_t kBins = 80 << kBitsABin;

std::size_t bin_of(double size) {
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(size) >> (52 - kBitsABin);
  return bits < kFirst ? 0 : std::min(bits - kFirst, kBins - 1);
}

double upper_edge(std::size_t bin) { return std::bit_cast<double>((bin + kFirst + 1) << (52 - kBitsABin)); }

void add_to(std::vector<double>& bins, const std::vector<double>& more) {
  if (bins.empty()) bins.resize(more.size());
  for (std::size_t b = 0; b < more.size(); ++b) bins[b] += more[b];
}

}  // namespace

void ErrorAccumulator::add(const Length& length, double weight, const glm::dvec3& position) {
  if (voxel_bins_.empty()) {
    voxel_bins_.resize(kBins);
    world_bins_.resize(kBins);
  }
  if (counts.points++ == 0 || length.world > max_.world) {
    max_.world = length.world;
    worst_ = position;
  }
  max_.voxels = std::max(max_.voxels, length.voxels);
  weight_ += weight;
  squares_.voxels += weight * length.voxels * length.voxels;
  squares_.world += weight * length.world * length.world;
  voxel_bins_[bin_of(length.voxels)] += weight;
  world_bins_[bin_of(length.world / world_voxel_)] += weight;
}

void ErrorStatistics::include_max(const ErrorStatistics& other) {
  if (points == 0 || other.points == 0) return;
  if (other.max.world > max.world) {
    max.world = other.max.world;
    worst = other.worst;
  }
  max.voxels = std::max(max.voxels, other.max.voxels);
}

void ErrorAccumulator::merge(const ErrorAccumulator& other) {
  counts.not_finite += other.counts.not_finite;
  counts.outside += other.counts.outside;
  counts.unreached += other.counts.unreached;
  counts.corrected += other.counts.corrected;
  if (other.counts.points == 0) return;
  if (counts.points == 0 || other.max_.world > max_.world) {
    max_.world = other.max_.world;
    worst_ = other.worst_;
  }
  counts.points += other.counts.points;
  max_.voxels = std::max(max_.voxels, other.max_.voxels);
  weight_ += other.weight_;
  squares_.voxels += other.squares_.voxels;
  squares_.world += other.squares_.world;
  add_to(voxel_bins_, other.voxel_bins_);
  add_to(world_bins_, other.world_bins_);
}

double ErrorAccumulator::percentile(const std::vector<double>& bins, double largest, double fraction) const {
  double below = 0;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    below += bins[b];
    // The last bin has no upper edge.
    if (below >= fraction * weight_) return b + 1 < bins.size() ? std::min(upper_edge(b), largest) : largest;
  }
  return largest;
}

ErrorStatistics ErrorAccumulator::result() const {
  ErrorStatistics result = counts;
  if (counts.points == 0) return result;
  constexpr double kFraction = 0.99;
  result.max = max_;
  result.worst = worst_;
  if (!(weight_ > 0)) {  // points of triangles without area have no mean: the largest stands for all of them
    result.rms = result.percentile99 = max_;
    return result;
  }
  result.rms = {std::sqrt(squares_.voxels / weight_), std::sqrt(squares_.world / weight_)};
  result.percentile99 = {percentile(voxel_bins_, max_.voxels, kFraction),
                         world_voxel_ * percentile(world_bins_, max_.world / world_voxel_, kFraction)};
  return result;
}

}  // namespace isoextract::accuracy
