// Positions of vertices on grid edges, their transform to the output, and normals. Both the dense and the sparse
// extractor use them.
#pragma once

#include <cmath>
#include <limits>

#include <glm/glm.hpp>

#include "extract/extractor.hpp"

namespace isoextract::extract {

// Returns the parameter (0 to 1) of the crossing on an edge from value f0 to f1, exactly one of which is inside: (iso -
// f0) / (f1 - f0) (Suravikin and Korobitsyn), in double. The result is at least `margin` away from both ends.
//
// The margin makes values equal to iso harmless: a vertex is always strictly inside its edge, also after rounding to
// float32 if OutputPlacement::keeps_vertices_apart(). Three points strictly inside three different edges of a cube or a
// tetrahedron are never collinear. So no triangle has zero area and no two vertices coincide.
//
// If one value is infinite, the crossing is at the margin from the finite end. If one is NaN or both are infinite, it
// is in the middle.
[[nodiscard]] inline double edge_crossing(double f0, double f1, double iso, double margin) {
  double t = (iso - f0) / (f1 - f0);
  if (!std::isfinite(f1 - f0)) {
    const bool finite0 = std::isfinite(f0);
    const bool finite1 = std::isfinite(f1);
    if (finite0 && finite1) {
      t = (iso / 2 - f0 / 2) / (f1 / 2 - f0 / 2);
    } else if (finite0 == finite1 || std::isnan(f0) || std::isnan(f1)) {
      t = 0.5;
    } else {
      t = finite0 ? 0 : 1;
    }
  }
  return std::min(std::max(t, margin), 1 - margin);
}

// Returns the derivative at a sample along one axis: half the difference of its neighbors `low` and `high`. If one
// neighbor is NaN, returns the difference between the other one and `here`. Returns NaN if both neighbors are NaN, or
// `here` and one of them. Returns infinity if both neighbors are the same infinity.
[[nodiscard]] inline double sample_derivative(double low, double here, double high) {
  const double change = high - low;
  if (!std::isnan(change)) return change / 2;
  if (!std::isnan(low) && !std::isnan(high)) return std::numeric_limits<double>::infinity();  // two equal infinities
  return std::isnan(low) ? high - here : here - low;
}

// Returns the derivative at sample `here` of the data boundary, toward the inside of the data, from the next two
// samples `near` and `far`. Ignores `far` if it is NaN; callers pass NaN if the data has no such sample. Returns NaN if
// `here` or `near` is NaN, and infinity if infinite samples leave the derivative undefined.
[[nodiscard]] inline double boundary_derivative(double here, double near, double far) {
  const double change = std::isnan(far) ? near - here : (4 * near - 3 * here - far) / 2;
  const bool of_infinities = std::isnan(change) && !std::isnan(here) && !std::isnan(near);
  return of_infinities ? std::numeric_limits<double>::infinity() : change;
}

// Maps index space to the float32 positions of a mesh.
class OutputPlacement {
 public:
  // Vertices must lie inside `box` or at most one index step outside.
  OutputPlacement(const field::Affine& output_from_index, const field::IndexBox& box, field::FieldKind kind,
                  const field::ValueScale& scale);

  // Returns the origin that position() is relative to, in output coordinates.
  [[nodiscard]] const glm::dvec3& origin() const { return origin_; }
  // Returns the margin for edge_crossing(), as a fraction of an edge.
  [[nodiscard]] double margin() const { return margin_; }
  // Returns false if coordinates or steps leave the range of float32, or if exceeds_float32_precision(). If true,
  // vertices may still coincide: see keeps_vertices_apart().
  [[nodiscard]] bool fits_float32() const { return in_range_ && !reaches_too_far_; }
  // Returns true if samples lie so far from the origin (more than about 2^19 steps) that rounding can exceed twice the
  // margin.
  [[nodiscard]] bool exceeds_float32_precision() const { return reaches_too_far_; }
  // Returns true if vertices on different edges have different positions, also after rounding to float32.
  [[nodiscard]] bool keeps_vertices_apart() const { return keeps_apart_; }
  // Returns true if the transform mirrors, so that the winding of triangles must be reversed.
  [[nodiscard]] bool mirrored() const { return mirrored_; }

  [[nodiscard]] const field::Affine& local_from_index() const { return local_from_index_; }
  // Returns the matrix that maps gradients of stored samples in index space to outward normals (not of unit length).
  [[nodiscard]] glm::dmat3 outward_covectors() const { return outward_ * covector_map_; }
  // Returns +1 if stored samples grow outward, else -1; outward_covectors() contains this factor. Code that must round
  // exactly like normal() applies this factor first, then covector_map().
  [[nodiscard]] double outward() const { return outward_; }
  // Returns the inverse transpose of local_from_index().linear, which maps gradients as covectors.
  [[nodiscard]] const glm::dmat3& covector_map() const { return covector_map_; }

  [[nodiscard]] glm::vec3 position(const glm::dvec3& index) const { return local_from_index_(index); }

  // Returns the outward unit normal for a gradient of the stored samples in index space. If the gradient is zero or not
  // finite, returns the direction of `out`, an index-space step that leads outside.
  [[nodiscard]] glm::vec3 normal(const glm::dvec3& gradient, const glm::dvec3& out) const;

  // Returns a placeholder for a normal that NaN samples leave unknown: the direction of `out` with length 2, which no
  // normal has. fill_normals() (mesh_assembly.hpp) replaces it.
  [[nodiscard]] glm::vec3 placeholder_normal(const glm::dvec3& out) const {
    return 2.0 * glm::normalize(local_from_index_.linear * out);
  }
  [[nodiscard]] static bool is_placeholder_normal(const glm::vec3& normal) { return glm::dot(normal, normal) > 2; }

  // Returns the unit normal, in output space, of a plane whose normal in index space is `covector`.
  [[nodiscard]] glm::vec3 plane_normal(const glm::dvec3& covector) const {
    return glm::normalize(covector_map_ * covector);
  }

 private:
  field::Affine local_from_index_;
  glm::dvec3 origin_{0.0};
  glm::dmat3 covector_map_;  // inverse transpose of the linear part, because gradients are covectors
  double outward_;           // +1 if stored samples grow outward, else -1
  double margin_;
  bool mirrored_;
  bool in_range_;
  bool keeps_apart_;
  bool reaches_too_far_;
};

// Returns the placement for `region`; `stored` is the box of all samples of `field`. Normally takes origin and margin
// from `stored`, so that a region changes no position. Takes them from the part of the region that can have triangles
// in two cases:
// - the region leaves out samples of `stored` and options.shared_origin is not set, and samples lie so far from the
//   origin (more than about 512 steps) that the margin for `stored` is visible;
// - with options.cap, the region reaches more than one step beyond `stored`.
// In these cases, positions on a face shared by two regions differ by up to the larger margin.
[[nodiscard]] OutputPlacement output_placement(const field::ScalarField& field, const ExtractOptions& options,
                                               const field::IndexBox& stored, const field::IndexBox& region);

// Returns the index step of axis bits (cell_tables.hpp).
[[nodiscard]] inline glm::ivec3 direction_step(int direction) {
  return {direction & 1, direction >> 1 & 1, direction >> 2 & 1};
}

// Returns the axis bits of an index step whose components are 0 or 1.
[[nodiscard]] inline int step_direction(const glm::ivec3& step) { return step.x | step.y << 1 | step.z << 2; }

}  // namespace isoextract::extract
