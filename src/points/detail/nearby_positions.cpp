#include "points/detail/nearby_positions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/parallel.hpp"

namespace isoextract::points {
namespace {

// Periods in each direction, at most: enough for 48 images of one particle along one edge.
constexpr int kMostPeriods = 24;
constexpr double kRounding = 1e-9;  // relative to the longest edge

}  // namespace

Result<NearbyPositions> NearbyPositions::make(const ParticleSet& particles, const Context& context) {
  if (particles.size() > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::input, fmt::format("{}: expected at most {} particles, found {}", particles.label,
                                              std::numeric_limits<std::uint32_t>::max(), particles.size()));
  }
  context.progress().begin("measuring distances", 0);
  NearbyPositions made;
  made.positions_ = particles.positions.span();
  if (particles.box && particles.box->is_periodic()) {
    const SimulationBox& box = *particles.box;
    made.periodic_ = box.periodic;
    made.edges_ = box.edges;
    const field::Affine map = box.world_from_fractions();
    const field::Affine fractions = map.inverse();
    const glm::dmat3 rows = glm::transpose(fractions.linear);
    for (int k = 0; k < 3; ++k) {
      made.heights_[k] = 1 / glm::length(rows[k]);
      made.rounding_ = std::max(made.rounding_, kRounding * glm::length(box.edges[k]));
    }
    auto wrapped =
        TRY(make_reserved_buffer<glm::dvec3>(particles.size(), context, particles.label + ": positions of particles"));
    for_each_index(
        particles.size(),
        [&](std::size_t i) {
          const glm::dvec3& p = particles.positions[i];
          glm::dvec3 whole = glm::floor(fractions(p));
          for (int k = 0; k < 3; ++k) {
            if (!box.periodic[static_cast<std::size_t>(k)]) whole[k] = 0;
          }
          wrapped->values[i] = p - box.edges * whole;
        },
        4096);
    made.positions_ = std::as_const(wrapped->values).span();
    made.wrapped_ = std::move(wrapped);
  }
  made.tree_ = TRY(NearestTree::make(made.positions_, context, particles.label));
  return made;
}

bool NearbyPositions::has_position(std::size_t particle) const { return is_finite(positions_[particle]); }

void NearbyPositions::add_around(const glm::dvec3& from, std::size_t count, std::vector<glm::dvec3>& offsets) const {
  const bool is_full = offsets.size() == count;
  if (is_full && tree_.squared_distance_to_bounds(from) > glm::dot(offsets.back(), offsets.back())) return;
  std::vector<NearestTree::Found> found;
  tree_.nearest_positions(from, count, found);
  const double same = rounding_ * rounding_;
  for (const NearestTree::Found& near : found) {
    const glm::dvec3 offset = positions_[near.point] - from;
    const double squared = glm::dot(offset, offset);
    if (offsets.size() == count && squared >= glm::dot(offsets.back(), offsets.back())) return;
    const auto coincides = [&](const glm::dvec3& other) {
      const glm::dvec3 between = other - offset;
      return glm::dot(between, between) <= same;
    };
    if (wrapped_ && (squared <= same || std::ranges::any_of(offsets, coincides))) continue;
    const auto at = std::ranges::upper_bound(offsets, squared, {}, [](const glm::dvec3& o) { return glm::dot(o, o); });
    offsets.insert(at, offset);
    if (offsets.size() > count) offsets.pop_back();
  }
}

void NearbyPositions::find(std::size_t particle, std::size_t count, std::vector<glm::dvec3>& offsets) const {
  const glm::dvec3& p = positions_[particle];
  offsets.clear();
  add_around(p, count, offsets);
  if (!wrapped_) return;
  glm::ivec3 reach(0);
  glm::ivec3 needed(0);
  for (int k = 0; k < 3; ++k) needed[k] = periodic_[static_cast<std::size_t>(k)] ? 1 : 0;
  // Adds images in more periods until they cover the distance to the farthest of the neighbors found.
  while (needed != reach) {
    const glm::ivec3 before = reach;
    reach = needed;
    for (int x = -reach.x; x <= reach.x; ++x) {
      for (int y = -reach.y; y <= reach.y; ++y) {
        for (int z = -reach.z; z <= reach.z; ++z) {
          const glm::ivec3 periods(x, y, z);
          if (glm::all(glm::lessThanEqual(glm::abs(periods), before))) continue;
          add_around(p - edges_ * glm::dvec3(periods), count, offsets);
        }
      }
    }
    const bool is_full = offsets.size() == count;
    for (int k = 0; k < 3; ++k) {
      if (reach[k] == 0) continue;
      const double periods = is_full ? glm::length(offsets.back()) / heights_[k] : 2.0 * reach[k];
      needed[k] = std::max(reach[k], static_cast<int>(std::ceil(std::min<double>(periods, kMostPeriods))));
    }
  }
}

}  // namespace isoextract::points
