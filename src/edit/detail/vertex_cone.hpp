// The cone of a vertex: the triangles around it, extended without end.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/adjacency.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

class VertexCone {
 public:
  // `corners` are the corners of the vertex. Directions and normals are those after the linear map `to_metric`.
  // Triangles without area are left out.
  VertexCone(const mesh::Mesh& mesh, std::span<const mesh::Corner> corners, const glm::dmat3& to_metric);

  [[nodiscard]] bool empty() const { return sectors_.empty(); }

  // Returns the signed distance to this cone from the triangle of the other cone that is farthest from it: positive
  // outside, negative inside. A triangle counts by its middle direction, at distance 1 from the common vertex. The
  // cones must not cross. By the pseudo-normal of the closest point: J. A. Baerentzen, H. Aanaes, Signed distance
  // computation using the angle weighted pseudonormal. IEEE TVCG 11(3), 2005.
  [[nodiscard]] double side_of(const VertexCone& other) const;

  // Returns a direction of unit length on the outer side of all triangles if `sign` is 1, on their inner side if -1.
  // Returns null if the sine of its angle to one of their planes is below `least_slope`. With `others`, only triangles
  // count that have an edge in common with another of these cones.
  [[nodiscard]] std::optional<glm::dvec3> way_off(double sign, double least_slope,
                                                  std::span<const VertexCone> others = {}) const;

  // Returns the direction of the mean normal, outward if `sign` is 1, inward if -1; null if the normals cancel.
  [[nodiscard]] std::optional<glm::dvec3> mean_way(double sign) const;

 private:
  struct Sector {
    glm::dvec3 first;  // unit directions of its edges
    glm::dvec3 second;
    glm::dvec3 normal;  // outward unit normal
    double angle = 0;
  };
  [[nodiscard]] double signed_distance(const glm::dvec3& direction) const;
  [[nodiscard]] bool has_edge(const glm::dvec3& direction) const;

  std::vector<Sector> sectors_;
  glm::dvec3 normal_{0.0};  // sum of the normals, weighted by angle
};

}  // namespace isoextract::edit
