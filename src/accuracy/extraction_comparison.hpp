// Compares two meshes of the same field and options from two backends, vertex by vertex and triangle by triangle. Both
// need edge keys (ExtractOptions::edge_keys), so all vertices must lie on edges (MethodTraits). The order of vertices
// and triangles does not matter.
//
// Positions are compared in units in the last place (ulps) of the local coordinates: the largest difference of a
// coordinate, divided by the float32 spacing at the vertex's largest absolute coordinate in either mesh. The spacing at
// the coordinate itself would be wrong. A position is an affine image of its edge, whose terms are rounded at the size
// of the whole position; a coordinate near 0 is a small difference of large terms.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "accuracy/triangle_sets.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::accuracy {

// Allowed difference of positions of two backends, in ulps: a bit more than one rounding.
inline constexpr double kStabilityUlps = 2;

// Allowed angle between normals of two backends: well above float32 rounding, far below what shading shows.
inline constexpr double kNormalDegrees = 0.01;

struct ExtractionComparison {
  template <class T>
  using Both = std::array<T, 2>;  // for the first and the second mesh

  Both<std::uint64_t> vertices{};
  TriangleDifference triangles;
  // Vertices on edges that only this mesh has, or has more often.
  Both<std::uint64_t> vertices_only{};
  Both<std::optional<mesh::EdgeKey>> vertex_example{};  // the lowest of their edges
  bool origins_differ = false;
  bool normals_in_one_only = false;
  bool normals_compared = false;
  // Largest differences of the vertices that both meshes have, and their edges; no edge if all differences are 0.
  double ulps = 0;
  std::optional<mesh::EdgeKey> farthest;
  double degrees = 0;  // largest angle between normals
  std::optional<mesh::EdgeKey> largest_angle_edge;
};

// Compares the meshes. Vertices that a hole duplicates share a key; their number is compared, not which triangles use
// which copy. An index without a vertex counts as a difference. Fails with ErrorCode::verification if a mesh has not
// one edge key for each vertex, with ErrorCode::out_of_memory if memory is short.
[[nodiscard]] Result<ExtractionComparison> compare_extractions(const mesh::Mesh& a, const mesh::Mesh& b,
                                                               const Context& context);

// Returns one sentence (without full stop) for each difference beyond the limits, none if the meshes are equal: equal
// triangles, vertices and origins, positions within kStabilityUlps, normals in both or neither and within
// kNormalDegrees. `names` are the names of the meshes.
[[nodiscard]] std::vector<std::string> differences(const ExtractionComparison& comparison, const MeshLabels& names);

// Formats an edge as "(3, 4, 5) along xz", a cap vertex as "(3, 4, 5)".
[[nodiscard]] std::string edge_text(const mesh::EdgeKey& edge);

}  // namespace isoextract::accuracy
