// Checks a mesh vertex by vertex against its field in long double: does it keep the extractors' promises?
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "extract/extractor.hpp"

namespace isoextract::bench {

// The grid edge of a vertex, from sample `low` to `low + step`. A zero step is a cap vertex at a sample.
struct GridEdge {
  glm::ivec3 low{0};
  glm::ivec3 step{0};
};

// Returns for each vertex the grid edge that contains it, found from the vertex's position alone. In index space,
// coordinates within rounding of an integer count as integers; all others must have equal fractions, up to rounding.
//
// Returns nullopt for a vertex that is not finite, and for all vertices if the float32 steps at the mesh's largest
// coordinates exceed 0.1 voxels. Returns nullopt if both ends of the edge are on the same side of the surface, or if
// the edge is a diagonal of a face or cell and the method has no diagonal edges. A cap vertex must be an inside sample
// on the data boundary. `options` are the options of the extraction; `field` must be dense.
[[nodiscard]] std::vector<std::optional<GridEdge>> grid_edges(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                              const extract::ExtractOptions& options,
                                                              const extract::MethodTraits& traits);

struct StabilityFindings {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t not_finite = 0;   // vertices with a non-finite coordinate or a normal not of unit length
  std::uint64_t off_edge = 0;     // finite vertices for which grid_edges() finds no edge
  std::uint64_t repeated = 0;     // second vertices on an edge (except with NanPolicy::hole), duplicate triangles
  std::uint64_t zero_area = 0;    // triangles
  std::uint64_t open_edges = 0;   // counted even if they are allowed
  std::uint64_t unsound = 0;      // misoriented or non-manifold edges, non-manifold or unused vertices, triangles with
                                  // a repeated vertex
  bool edges_checked = true;      // false: the method puts vertices off the edges, `off_edge` stays 0
  bool crossings_checked = true;  // false: the method puts vertices off the crossings, `ulps` and `voxels` stay 0
  // Largest difference of a coordinate from the crossing moved inside the margin (check_stability()), in float32 steps
  // at the mesh's largest local coordinate.
  double ulps = 0;
  // Largest distance of a vertex from its exact crossing (not moved inside the margin), in index space.
  double voxels = 0;

  // Adds the findings of another mesh of the same method.
  void add(const StabilityFindings& other);
};

// Returns findings of no mesh, with edges_checked and crossings_checked set for a method.
[[nodiscard]] StabilityFindings empty_findings(const extract::MethodTraits& traits);

// Checks a mesh. The exact crossing is (iso - f0) / (f1 - f0) in long double. With one infinite sample it is the finite
// end; with two, or with a NaN, it is the middle of the edge. `ulps` is the difference from the crossing after the
// crossing is moved at least the margin of extract/edge_geometry.hpp away from both ends. Vertices that are not finite
// or on no edge have no crossing. Edges and crossings are checked only if `traits` promise vertices there.
[[nodiscard]] StabilityFindings check_stability(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                const extract::ExtractOptions& options,
                                                const extract::MethodTraits& traits);

// Returns the failures in words ("3 vertices outside their edge"), none if all is well. `ulps` and `voxels` are the
// limits. Boundary edges are failures only if `must_be_closed`.
[[nodiscard]] std::vector<std::string> failures(const StabilityFindings& findings, bool must_be_closed, double ulps,
                                                double voxels);

}  // namespace isoextract::bench
