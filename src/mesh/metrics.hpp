// Bounds, area and volume of a mesh, summed in double.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "mesh/mesh.hpp"

namespace isoextract::mesh {

struct Bounds {
  glm::dvec3 min{0.0};
  glm::dvec3 max{0.0};
};

// Returns the bounds of the positions plus the origin; zero for a mesh without vertices.
[[nodiscard]] Bounds measure_bounds(const Mesh& mesh);

// Bounds of the stored float32 positions, without the origin; zero for a mesh without vertices.
struct LocalBounds {
  glm::vec3 min{0.0F};
  glm::vec3 max{0.0F};
};
[[nodiscard]] LocalBounds measure_local_bounds(const Mesh& mesh);

// Bounds of positions that come in parts. Keeps the coordinate that was added first if two are equal (0 and -0).
class GrowingBounds {
 public:
  void add(std::span<const glm::vec3> positions) {
    for (const glm::vec3& position : positions) {
      bounds_.min = glm::min(bounds_.min, position);
      bounds_.max = glm::max(bounds_.max, position);
    }
  }
  void add(const GrowingBounds& other) {
    bounds_ = {glm::min(bounds_.min, other.bounds_.min), glm::max(bounds_.max, other.bounds_.max)};
  }
  // Returns infinite bounds, minimum above maximum, if nothing was added.
  [[nodiscard]] const LocalBounds& get() const { return bounds_; }

 private:
  LocalBounds bounds_{glm::vec3(std::numeric_limits<float>::infinity()),
                      glm::vec3(-std::numeric_limits<float>::infinity())};
};

// Returns the greatest absolute coordinate, which determines the resolution of float32; 0 without positions.
[[nodiscard]] float farthest_coordinate(std::span<const glm::vec3> positions);

// Returns one to two units in the last place of farthest_coordinate(): smaller distances are rounding errors.
[[nodiscard]] inline double float32_resolution(std::span<const glm::vec3> positions) {
  return static_cast<double>(farthest_coordinate(positions)) * 0x1p-23;
}

struct MeshSize {
  double area = 0;
  double volume = 0;  // enclosed; positive if triangles wind counter-clockwise seen from outside. Closed meshes only
  std::uint64_t zero_area_triangles = 0;  // exactly zero, computed in double from the stored positions
};
[[nodiscard]] MeshSize measure_size(const Mesh& mesh);

// Returns the side of a square that consists of two triangles of mean area; 1 for a mesh without area.
[[nodiscard]] double typical_edge(const Mesh& mesh);

}  // namespace isoextract::mesh
