// Where on its edge a vertex is, where that is in the output, and which way its normal points. Shared by the dense and
// the sparse extractor.
#pragma once

#include <cmath>
#include <limits>

#include <glm/glm.hpp>

#include "extract/extractor.hpp"

namespace isoextract::extract {

// The parameter of the crossing on an edge from value f0 to f1, of which exactly one is inside: (iso - f0) / (f1 - f0)
// (Suravikin and Korobitsyn), in double, kept at least `margin` away from both ends.
//
// The margin is what makes values that tie with iso harmless: a vertex is always strictly inside its edge, also after
// rounding to float32. Three points strictly inside three different edges of a cube or a tetrahedron are never
// collinear, so no triangle has zero area and no two vertices coincide.
//
// An infinite value pulls the crossing to the finite end; NaN, or two infinities, leave it in the middle.
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

// The derivative at a sample along one axis, from the samples `low` and `high` beside it: half their difference. Of a
// sample that is NaN the difference to `here` takes the place; NaN where both are NaN, or `here` and one of them.
[[nodiscard]] inline double sample_derivative(double low, double here, double high) {
  const double change = high - low;
  if (!std::isnan(change)) return change / 2;
  if (!std::isnan(low) && !std::isnan(high)) return std::numeric_limits<double>::infinity();  // of two infinities
  return std::isnan(low) ? high - here : here - low;
}

// The same at the border, towards the inside of the data: from the next two samples, or the next alone where `far` is
// NaN, or not there. NaN where `here` or `near` is.
[[nodiscard]] inline double border_derivative(double here, double near, double far) {
  const double change = std::isnan(far) ? near - here : (4 * near - 3 * here - far) / 2;
  const bool of_infinities = std::isnan(change) && !std::isnan(here) && !std::isnan(near);
  return of_infinities ? std::numeric_limits<double>::infinity() : change;
}

// From index space to the float32 positions of a mesh.
class OutputFrame {
 public:
  // `box` holds every sample that vertices may lie at.
  OutputFrame(const field::Affine& output_from_index, const field::IndexBox& box, field::FieldKind kind,
              const field::ValueScale& scale);

  [[nodiscard]] const glm::dvec3& origin() const { return origin_; }
  [[nodiscard]] double margin() const { return margin_; }
  // False if float32 cannot hold the positions apart: coordinates or steps leave its range, or the samples reach too
  // far.
  [[nodiscard]] bool fits_float32() const { return in_range_ && !reaches_too_far_; }
  // True if samples lie so far (more than about 2^19 steps) from the origin that rounding eats the margin.
  [[nodiscard]] bool reaches_too_far() const { return reaches_too_far_; }
  // True if triangles must be turned over, because the transform mirrors.
  [[nodiscard]] bool mirrored() const { return mirrored_; }

  [[nodiscard]] const field::Affine& local_from_index() const { return local_from_index_; }
  // Maps gradients of the stored samples in index space to outward normals, which are yet to be made unit length.
  [[nodiscard]] glm::dmat3 outward_covectors() const { return outward_ * covector_map_; }
  // Its parts, for those who round as normal() does: +1 or -1, and the map of covectors.
  [[nodiscard]] double outward() const { return outward_; }
  [[nodiscard]] const glm::dmat3& covector_map() const { return covector_map_; }

  [[nodiscard]] glm::vec3 position(const glm::dvec3& index) const { return local_from_index_(index); }

  // The outward unit normal for a gradient of the stored samples in index space. `out` is an index-space step that
  // leads outside; it decides where the gradient is zero or not finite.
  [[nodiscard]] glm::vec3 normal(const glm::dvec3& gradient, const glm::dvec3& out) const;

  // Stands for the normal of a vertex at which NaN leaves no gradient, until fill_normals() (mesh_assembly.hpp) finds
  // one: `out` in the output, of length 2, which no normal has.
  [[nodiscard]] glm::vec3 unknown_normal(const glm::dvec3& out) const {
    return 2.0 * glm::normalize(local_from_index_.linear * out);
  }
  [[nodiscard]] static bool is_unknown(const glm::vec3& normal) { return glm::dot(normal, normal) > 2; }

  // The unit normal of a plane whose index-space normal is `covector`.
  [[nodiscard]] glm::vec3 plane_normal(const glm::dvec3& covector) const {
    return glm::normalize(covector_map_ * covector);
  }

 private:
  field::Affine local_from_index_;
  glm::dvec3 origin_{0.0};
  glm::dmat3 covector_map_;  // inverse transpose of the linear part: gradients are covectors
  double outward_;           // +1 if values grow outward in stored samples
  double margin_;
  bool mirrored_;
  bool in_range_;
  bool reaches_too_far_;
};

// The frame for the samples of `field` in `region`, of all those in `stored`. It is that of all samples, so that a
// region changes no position, unless they reach so far (more than about 512 steps) that their margin can be seen, or
// the cap of a region stands outside of them: then it is that of the part that is drawn. Two regions then agree where
// they meet up to the margin of the larger, not bit for bit, unless options.shared_frame is set.
[[nodiscard]] OutputFrame output_frame(const field::ScalarField& field, const ExtractOptions& options,
                                       const field::IndexBox& stored, const field::IndexBox& region);

// The step of a direction's axis bits, see cell_tables.hpp.
[[nodiscard]] inline glm::ivec3 direction_step(int direction) {
  return {direction & 1, direction >> 1 & 1, direction >> 2 & 1};
}

// And back.
[[nodiscard]] inline int step_direction(const glm::ivec3& step) { return step.x | step.y << 1 | step.z << 2; }

}  // namespace isoextract::extract
