// Whether a mesh is what the extractors promise, checked vertex by vertex against its field in long double.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "extract/extractor.hpp"

namespace isoextract::bench {

// The edge of the grid that a vertex lies on, from sample `low` to `low + step`. A zero step is a vertex of a cap, at a
// sample.
struct GridEdge {
  glm::ivec3 low{0};
  glm::ivec3 step{0};
};

// For each vertex the edge that it lies strictly within, found from its position alone: in index space as many
// coordinates as rounding allows are whole, and the others have one fraction. Nothing where that is no crossed edge of
// `field`, or one across a face or a cell for a method without such edges, or no inside sample of the border of a
// capped one. `options` are those that made the mesh; dense samples.
[[nodiscard]] std::vector<std::optional<GridEdge>> grid_edges(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                              const extract::ExtractOptions& options,
                                                              const extract::MethodTraits& traits);

struct StabilityFindings {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t not_finite = 0;   // vertices with a coordinate that is not, or with a normal of another length than 1
  std::uint64_t off_edge = 0;     // vertices that are not strictly within an edge
  std::uint64_t repeated = 0;     // vertices on an edge that has one already, triangles that are there twice
  std::uint64_t zero_area = 0;    // triangles
  std::uint64_t open_edges = 0;   // counted whether they may be or not
  std::uint64_t unsound = 0;      // edges and vertices that are not oriented, not manifold, or not used
  bool edges_checked = true;      // else `off_edge` says nothing: vertices of the method are not on edges
  bool crossings_checked = true;  // else `ulps` and `voxels` say nothing: likewise, or they are not at the crossing
  double ulps = 0;    // the farthest vertex from the reference, in units of the last place of the local coordinates
  double voxels = 0;  // the farthest from the crossing itself, where the reference keeps a margin to the ends of edges

  // Of the same method.
  void add(const StabilityFindings& other);
};

// Of no mesh yet: what will be checked of a method's.
[[nodiscard]] StabilityFindings no_findings(const extract::MethodTraits& traits);

// The reference crossing is (iso - f0) / (f1 - f0) in long double, at infinities the finite end, and the middle where
// there is none; ulps are counted against that, kept to the margin of edge_geometry.hpp. Vertices that are not finite
// or on no edge have no reference. `traits` are what the method claims: what it does not claim is not checked.
[[nodiscard]] StabilityFindings check_stability(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                const extract::ExtractOptions& options,
                                                const extract::MethodTraits& traits);

// What is wrong, in words: "3 vertices outside their edge"; empty if nothing is. `ulps` and `voxels` are the
// thresholds.
[[nodiscard]] std::vector<std::string> failures(const StabilityFindings& findings, bool must_be_closed, double ulps,
                                                double voxels);

}  // namespace isoextract::bench
