// Two meshes of the same field and options, each from a backend of its own, vertex by vertex and triangle by triangle.
// Both carry edge keys (ExtractOptions::edge_keys), which only vertices on edges have (MethodTraits); in which order
// their vertices and triangles stand is no matter.
//
// Positions are compared in units in the last place (ulps) of the local coordinates: the greatest difference of a
// coordinate, divided by the spacing of float32 at the largest coordinate, without sign, that the vertex has in either
// mesh. Not at the coordinate itself: a position is the image of its edge by an affine map, whose terms are rounded at
// the size of the whole position. A coordinate near 0 is what is left of them, and its own spacing can be any number of
// times finer than what the map can hold.
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

// What positions of two backends may differ by, in units of the last place: more than rounding once costs.
inline constexpr double kStabilityUlps = 2;

// What the normals of two backends may differ by: many times the rounding of a unit vector in float32, and far below
// what shading shows.
inline constexpr double kNormalDegrees = 0.01;

struct ExtractionComparison {
  template <class T>
  using Both = std::array<T, 2>;  // of the first and of the second mesh

  Both<std::uint64_t> vertices{};
  TriangleDifference triangles;
  Both<std::uint64_t> vertices_only{};                  // on edges, or as often on an edge, as only this mesh has
  Both<std::optional<mesh::EdgeKey>> vertex_example{};  // one of them
  bool origins_differ = false;
  bool normals_in_one_only = false;
  bool normals_compared = false;
  // Of the vertices that both have; the edge is there unless all are 0.
  double ulps = 0;
  std::optional<mesh::EdgeKey> farthest;
  double degrees = 0;  // between normals
  std::optional<mesh::EdgeKey> most_turned;
};

// Where a hole parts a vertex, its copies share a key: how many there are is compared, not which triangles each has.
// Fails with ErrorCode::verification if a mesh lacks edge keys, with ErrorCode::input if the comparison needs more
// memory than there is. Indices of vertices that are not there are a difference like any other.
[[nodiscard]] Result<ExtractionComparison> compare_extractions(const mesh::Mesh& a, const mesh::Mesh& b,
                                                               const Context& context);

// What differs by more than it may, a sentence without its full stop each; none if the meshes are the same: the same
// triangles and vertices, the same origin, positions within kStabilityUlps, normals within kNormalDegrees. `names` are
// what the meshes are called.
[[nodiscard]] std::vector<std::string> differences(const ExtractionComparison& comparison, const MeshNames& names);

// "(3, 4, 5) along xz", or of a vertex of a cap "(3, 4, 5)".
[[nodiscard]] std::string edge_text(const mesh::EdgeKey& edge);

}  // namespace isoextract::accuracy
