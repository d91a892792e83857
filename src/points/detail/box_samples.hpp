// Samples aligned with a simulation box, and the periodic images of points in it.
//
// Sample (0, 0, 0) lies at the origin of the box, and the sample axes are parallel to its edges. A periodic edge has a
// whole number n of steps, so that sample n repeats sample 0 and each cell belongs to one period. Along other edges the
// step is the spacing, and samples continue beyond the box.
//
// Three coordinate systems: world; index (units are the steps); and Cartesian, which is the world relative to the
// origin of the box in units of the spacing, so that balls are balls.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "field/affine.hpp"
#include "field/samples.hpp"
#include "points/simulation_box.hpp"

namespace isoextract::points {

// Returns the spacing nearest to `spacing` for which every periodic edge has a whole number of steps, up to a millionth
// of a step: cells are cubes then. Tries up to 64 steps more and fewer; returns nothing if none fits. The edges must be
// parallel to the axes.
[[nodiscard]] std::optional<double> common_spacing(const SimulationBox& box, double spacing);

class BoxSamples {
 public:
  // A periodic edge gets the number of steps nearest to its length / spacing, at least 4. Fails with ErrorCode::input
  // if an edge has too many samples for indices, or the box is too far from 0. `label` starts the message.
  [[nodiscard]] static Result<BoxSamples> make(const SimulationBox& box, double spacing, const std::string& label);

  [[nodiscard]] const field::Affine& world_from_index() const { return world_from_index_; }
  [[nodiscard]] const glm::dmat3& cartesian_from_index() const { return cartesian_from_index_; }
  [[nodiscard]] const glm::dmat3& index_from_cartesian() const { return index_from_cartesian_; }

  // Returns the step in units of the spacing, if all three steps are equal and at right angles: then balls are balls in
  // index coordinates, too.
  [[nodiscard]] std::optional<double> cubic_step() const { return cubic_step_; }

  // Returns index coordinates, along periodic edges in [0, n). Not finite for positions too far away.
  [[nodiscard]] glm::dvec3 wrapped_index(const glm::dvec3& world) const;

  // Returns how far a ball reaches along each index axis; `radius` is in Cartesian units.
  [[nodiscard]] glm::dvec3 extent_of_ball(double radius) const { return radius * ball_extent_; }
  // Returns the largest factor by which index_from_cartesian() lengthens a vector.
  [[nodiscard]] double longest_stretch() const { return longest_stretch_; }

  // Returns the samples from 0 to n; along edges that are not periodic, all indices.
  [[nodiscard]] field::IndexBox region() const;

  // Calls f(image) for `index` and each of its periodic images that lies at most `reach` outside the region. Does not
  // call f(index) if `index` lies farther outside.
  template <class F>
  void for_each_image(const glm::dvec3& index, const glm::dvec3& reach, const F& f) const {
    const ImageRange range = range_of(index, reach);
    for (double x = range.first.x; x <= range.last.x; ++x) {
      for (double y = range.first.y; y <= range.last.y; ++y) {
        for (double z = range.first.z; z <= range.last.z; ++z) f(index + glm::dvec3(x, y, z) * cells_);
      }
    }
  }
  // Returns the number of calls of for_each_image(), as a double because it can exceed 64 bits.
  [[nodiscard]] double count_images(const glm::dvec3& index, const glm::dvec3& reach) const {
    const ImageRange range = range_of(index, reach);
    const glm::dvec3 counts = glm::max(range.last - range.first + 1.0, 0.0);
    return counts.x * counts.y * counts.z;
  }

 private:
  struct ImageRange {
    glm::dvec3 first{0.0};
    glm::dvec3 last{0.0};
  };
  [[nodiscard]] ImageRange range_of(const glm::dvec3& index, const glm::dvec3& reach) const {
    ImageRange range;
    for (int k = 0; k < 3; ++k) {
      if (cells_[k] == 0) continue;
      range.first[k] = std::ceil((-reach[k] - index[k]) / cells_[k]);
      range.last[k] = std::floor((cells_[k] + reach[k] - index[k]) / cells_[k]);
    }
    return range;
  }

  field::Affine world_from_index_;
  glm::dmat3 index_from_world_{1.0};  // without the offset
  glm::dmat3 cartesian_from_index_{1.0};
  glm::dmat3 index_from_cartesian_{1.0};
  std::optional<double> cubic_step_;
  glm::dvec3 ball_extent_{1.0};
  double longest_stretch_ = 1;
  glm::dvec3 cells_{0.0};  // whole numbers; 0 along edges that are not periodic
};

}  // namespace isoextract::points
