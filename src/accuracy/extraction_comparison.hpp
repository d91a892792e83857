// Compares two meshes of the same field and options from two backends, vertex by vertex and triangle by triangle, in
// any order. Vertices correspond if their edge keys are equal. So both meshes need edge keys
// (ExtractOptions::edge_keys), which only methods with MethodTraits::vertices_on_edges have.
//
// Positions are compared in units in the last place (ulps) of the local coordinates: the largest difference of a
// coordinate, divided by the float32 spacing at the vertex's largest absolute coordinate in either mesh. The spacing at
// the coordinate itself would be too small for coordinates near 0: these are sums of terms as large as the other
// coordinates, and the terms are rounded.
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

// Largest allowed difference between positions of two backends, in ulps; one rounding makes a difference of about 1.
inline constexpr double kStabilityUlps = 2;

// Largest allowed angle between normals of two backends: well above float32 rounding, far below what shading shows.
inline constexpr double kNormalDegrees = 0.01;

struct ExtractionComparison {
  template <class T>
  using Both = std::array<T, 2>;  // for the first and the second mesh

  Both<std::uint64_t> vertices{};
  TriangleDifference triangles;
  // Vertices without a counterpart: the other mesh has no vertex with this edge key, or fewer of them.
  Both<std::uint64_t> vertices_only{};
  Both<std::optional<mesh::EdgeKey>> vertex_example{};  // the lowest edge key of these vertices
  bool origins_differ = false;
  bool normals_in_one_only = false;
  bool normals_compared = false;
  // Largest differences between corresponding vertices, and the edges of these vertices; no edge if all are 0.
  double ulps = 0;
  std::optional<mesh::EdgeKey> farthest;
  double degrees = 0;  // largest angle between normals
  std::optional<mesh::EdgeKey> largest_angle_edge;
};

// Compares the meshes. NanPolicy::hole makes copies of a vertex, with equal keys: compares the number of copies, but
// not which triangle uses which copy. An index without a vertex counts as a difference. Fails with
// ErrorCode::verification if a mesh does not have one edge key for each vertex, and with ErrorCode::out_of_memory if
// memory is short.
[[nodiscard]] Result<ExtractionComparison> compare_extractions(const mesh::Mesh& a, const mesh::Mesh& b,
                                                               const Context& context);

// Returns one sentence (without full stop) for each difference beyond the limits, none if the meshes are equal: equal
// triangles, vertices and origins, positions within kStabilityUlps, normals in both or neither and within
// kNormalDegrees. `names` are the names of the meshes.
[[nodiscard]] std::vector<std::string> differences(const ExtractionComparison& comparison, const MeshLabels& names);

// Formats an edge as "(3, 4, 5) along xz", a cap vertex as "(3, 4, 5)".
[[nodiscard]] std::string edge_text(const mesh::EdgeKey& edge);

}  // namespace isoextract::accuracy
