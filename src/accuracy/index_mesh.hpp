// A mesh seen in the index space of the field it came from.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "accuracy/cap_places.hpp"
#include "extract/extractor.hpp"

namespace isoextract::accuracy {

class IndexMesh {
 public:
  // `extracted` is how `mesh` was extracted from `field`, or from `grid` if there is one, which resample() made of
  // `field`. The mesh must outlive this.
  IndexMesh(const mesh::Mesh& mesh, const field::ScalarField& field, const extract::ExtractOptions& extracted,
            const field::ScalarField* grid = nullptr);

  // What places the mesh, from the indices of `field`.
  [[nodiscard]] const field::Affine& output_from_index() const { return output_from_index_; }

  // The two large numbers of a far-away frame are subtracted first.
  [[nodiscard]] glm::dvec3 vertex(std::size_t v) const {
    return index_from_local_ * (glm::dvec3(mesh_.positions[v]) + local_offset_);
  }
  [[nodiscard]] std::array<glm::dvec3, 3> corners(std::size_t triangle) const {
    const glm::uvec3 t = mesh_.triangles[triangle];
    return {vertex(t.x), vertex(t.y), vertex(t.z)};
  }

  // Twice the triangle's area in the mesh's own coordinates, along its normal.
  [[nodiscard]] glm::dvec3 area_vector(const std::array<glm::dvec3, 3>& corners) const {
    const glm::dmat3& linear = output_from_index_.linear;
    return glm::cross(linear * (corners[1] - corners[0]), linear * (corners[2] - corners[0]));
  }

  // Caps lie in the planes of these as well, which are in the mesh's coordinates. They must outlive this.
  void add_caps(const CapPlaces& caps) { caps_ = caps; }

  // Beyond the outermost samples that the mesh is of, where a method that always closes the surface puts some of it.
  [[nodiscard]] bool is_outside(const glm::dvec3& index) const {
    return closed_around_ && (glm::any(glm::lessThan(index, closed_around_->min - tolerance_)) ||
                              glm::any(glm::greaterThan(index, closed_around_->max + tolerance_)));
  }

  // All corners in one face of the box that was capped, in the plane of a capped cut, or beyond one face of the
  // outermost samples.
  [[nodiscard]] bool is_cap(const std::array<glm::dvec3, 3>& corners) const {
    if (is_in_cut(corners)) return true;
    if (closed_around_ && is_beyond(corners, *closed_around_)) return true;
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

  // For each vertex whether a triangle that is no cap uses it. The others stand on samples.
  [[nodiscard]] std::vector<std::uint8_t> surface_vertices() const;

  // At least two of the three indices are those of samples.
  [[nodiscard]] bool on_axis_edge(const glm::dvec3& index) const {
    int on_samples = 0;
    for (int axis = 0; axis < 3; ++axis) {
      on_samples += std::abs(index[axis] - std::round(index[axis])) < tolerance_ ? 1 : 0;
    }
    return on_samples >= 2;
  }

  // How far the margin at the ends of edges and float32 rounding together move a vertex at most, in the mesh's
  // coordinates.
  [[nodiscard]] double rounding() const {
    constexpr double kMarginAndRounding = 9.0 / 8;  // of the margin, which is eight times the rounding
    const glm::dmat3& linear = output_from_index_.linear;
    const double longest = std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
    return kMarginAndRounding * 2 * tolerance_ * longest;
  }

  // About how long a voxel is in the mesh's coordinates: the side of a cube of its volume.
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
  // Whether the triangle faces along the unit vector, or against it, but for 25 degrees.
  [[nodiscard]] static bool is_along(const std::array<glm::dvec3, 3>& corners, const glm::dvec3& direction) {
    const glm::dvec3 vector = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    return std::abs(glm::dot(vector, direction)) >= 0.9 * glm::length(vector);
  }

  const mesh::Mesh& mesh_;
  field::Affine output_from_index_;
  glm::dmat3 index_from_local_;
  glm::dvec3 local_offset_;
  double tolerance_;  // how far from its place rounding may bring a vertex, in voxels
  std::optional<field::Box> cap_;
  std::optional<field::Box> closed_around_;  // of methods that always close the surface: the outermost samples
  CapPlaces caps_;
};

}  // namespace isoextract::accuracy
