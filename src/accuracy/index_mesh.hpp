// A mesh seen in the index space of its field.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "accuracy/cap_planes.hpp"
#include "extract/extractor.hpp"

namespace isoextract::accuracy {

class IndexMesh {
 public:
  // `mesh` was extracted with options `extracted` from `field`, or from `grid`, which resample() made of `field`. The
  // mesh must outlive this object.
  IndexMesh(const mesh::Mesh& mesh, const field::ScalarField& field, const extract::ExtractOptions& extracted,
            const field::ScalarField* grid = nullptr);

  // Returns the map from indices of `field` to the mesh's coordinates.
  [[nodiscard]] const field::Affine& output_from_index() const { return output_from_index_; }

  // Returns a vertex in index space. Adds the precomputed difference of the mesh's origin and the transform's offset,
  // which keeps precision far from the world origin.
  [[nodiscard]] glm::dvec3 vertex(std::size_t v) const {
    return index_from_local_ * (glm::dvec3(mesh_.positions[v]) + local_offset_);
  }
  [[nodiscard]] std::array<glm::dvec3, 3> corners(std::size_t triangle) const {
    const glm::uvec3 t = mesh_.triangles[triangle];
    return {vertex(t.x), vertex(t.y), vertex(t.z)};
  }

  // Returns the triangle's normal in the mesh's coordinates, with twice its area as length.
  [[nodiscard]] glm::dvec3 area_vector(const std::array<glm::dvec3, 3>& corners) const {
    const glm::dmat3& linear = output_from_index_.linear;
    return glm::cross(linear * (corners[1] - corners[0]), linear * (corners[2] - corners[0]));
  }

  // Also treats triangles in these planes (mesh coordinates) as caps. The planes must outlive this object.
  void add_caps(const CapPlanes& caps) { caps_ = caps; }

  // Returns whether a point is beyond the outermost samples (of the region, if set), where always-closed methods put
  // triangles; false for other methods.
  [[nodiscard]] bool is_outside(const glm::dvec3& index) const {
    return outermost_samples_ && (glm::any(glm::lessThan(index, outermost_samples_->min - tolerance_)) ||
                                  glm::any(glm::greaterThan(index, outermost_samples_->max + tolerance_)));
  }

  // Returns whether all corners (in index space) lie in one face of the capped box, in one capped cut plane, or beyond
  // one face of the outermost samples of an always-closed method.
  [[nodiscard]] bool is_cap(const std::array<glm::dvec3, 3>& corners) const {
    if (is_in_cut(corners)) return true;
    if (outermost_samples_ && is_beyond(corners, *outermost_samples_)) return true;
    if (!cap_) return false;
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 along(0);
      along[axis] = 1;
      for (const double face : {cap_->min[axis], cap_->max[axis]}) {
        const auto in_face = [&](const glm::dvec3& p) { return std::abs(p[axis] - face) < tolerance_ + caps_.moved; };
        if (std::ranges::all_of(corners, in_face) && (caps_.moved == 0 || is_along(corners, along))) return true;
      }
    }
    return false;
  }

  // Returns 1 for each vertex of a triangle that is no cap, else 0; 1 for every vertex if the mesh cannot have caps.
  [[nodiscard]] std::vector<std::uint8_t> surface_vertices() const;

  // Returns whether at least two of the three indices are integers, as on an axis-aligned grid edge.
  [[nodiscard]] bool on_axis_edge(const glm::dvec3& index) const {
    int on_samples = 0;
    for (int axis = 0; axis < 3; ++axis) {
      on_samples += std::abs(index[axis] - std::round(index[axis])) < tolerance_ ? 1 : 0;
    }
    return on_samples >= 2;
  }

  // Returns how far the margin at edge ends and float32 rounding together can move a vertex, in the mesh's coordinates.
  [[nodiscard]] double rounding() const {
    constexpr double kMarginAndRounding = 9.0 / 8;  // relative to the margin, which is eight times the rounding
    const glm::dmat3& linear = output_from_index_.linear;
    const double longest = std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
    return kMarginAndRounding * 2 * tolerance_ * longest;
  }

  // Returns the approximate length of a voxel in the mesh's coordinates: the side of a cube of its volume.
  [[nodiscard]] double voxel() const { return std::cbrt(std::abs(output_from_index_.determinant())); }

 private:
  [[nodiscard]] bool is_beyond(const std::array<glm::dvec3, 3>& corners, const field::Box& box) const {
    const glm::dvec3 low = glm::min(corners[0], glm::min(corners[1], corners[2]));
    const glm::dvec3 high = glm::max(corners[0], glm::max(corners[1], corners[2]));
    return glm::any(glm::lessThan(high, box.min - tolerance_)) || glm::any(glm::greaterThan(low, box.max + tolerance_));
  }
  [[nodiscard]] bool is_in_cut(const std::array<glm::dvec3, 3>& corners) const {
    if (caps_.cuts.empty()) return false;
    std::array<glm::dvec3, 3> placed;
    std::ranges::transform(corners, placed.begin(), [&](const glm::dvec3& p) { return output_from_index_(p); });
    const double allowed = rounding() + caps_.moved * voxel();
    return std::ranges::any_of(caps_.cuts, [&](const mesh::HalfSpace& cut) {
      const auto in_plane = [&](const glm::dvec3& p) { return std::abs(cut.depth(p)) <= allowed; };
      return std::ranges::all_of(placed, in_plane) && (caps_.moved == 0 || is_along(placed, cut.normal));
    });
  }
  // Returns whether the normal is within 25 degrees of the unit vector or its opposite.
  [[nodiscard]] static bool is_along(const std::array<glm::dvec3, 3>& corners, const glm::dvec3& direction) {
    const glm::dvec3 vector = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    return std::abs(glm::dot(vector, direction)) >= 0.9 * glm::length(vector);
  }

  const mesh::Mesh& mesh_;
  field::Affine output_from_index_;
  glm::dmat3 index_from_local_;
  glm::dvec3 local_offset_;
  double tolerance_;  // half the margin at edge ends, in voxels; rounding moves a vertex less
  std::optional<field::Box> cap_;
  std::optional<field::Box> outermost_samples_;  // outermost samples, for always-closed methods
  CapPlanes caps_;
};

}  // namespace isoextract::accuracy
