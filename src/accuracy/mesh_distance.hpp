// Distances between two meshes: maximum (Hausdorff), root mean square, mean and 99th percentile.
//
// The maximum from A to B is the distance of the point of A that is farthest from B, anywhere on A's triangles. Branch
// and bound (mesh/distance_bound.hpp) gives an interval that contains it, up to rounding in double. The other figures
// come from samples spread over the area of A. A triangle of A that B also has, with exactly the same corners, is at
// distance 0. So meshes with the same triangles, in any order, are exactly 0 apart.
//
// All computations use the stored positions in double; the meshes may have different origins. Results do not depend on
// the number of threads.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::accuracy {

struct DistanceOptions {
  // Largest width of the interval [max_lower, max_upper], as a fraction of max_lower; MeshDistance::resolution comes on
  // top. Above 0. The interval is wider if a triangle needs too many steps.
  double tolerance = 0.01;
  // The search also ends once max_upper is at most this distance, however wide the interval is.
  double enough = 0;
  std::uint64_t samples = 1 << 18;  // in each direction; 0 leaves rms, mean and percentile at 0
};

struct DirectedDistance {
  double max_lower = 0;     // lower bound of the largest distance
  double max_upper = 0;     // upper bound
  glm::dvec3 place{0.0};    // a point of A at distance max_lower from B, in world coordinates
  glm::dvec3 nearest{0.0};  // the point of B nearest to `place`
  double rms = 0;
  double mean = 0;
  double percentile99 = 0;
};

struct MeshDistance {
  DirectedDistance a_to_b;
  DirectedDistance b_to_a;
  // Both directions: the larger Hausdorff bounds, and the figures over all samples.
  double hausdorff_lower = 0;
  double hausdorff_upper = 0;
  double rms = 0;
  double mean = 0;
  double percentile99 = 0;
  // The larger float32 resolution of the two meshes (mesh/metrics.hpp): smaller distances are rounding errors.
  double resolution = 0;
};

// Measures both directions; positions must be finite. Fails with ErrorCode::input if a mesh has no triangles or if the
// origins are more than 1e150 apart (squared distances would overflow), with ErrorCode::out_of_memory if memory is
// short, or with ErrorCode::cancelled.
[[nodiscard]] Result<MeshDistance> measure_distance(const mesh::Mesh& a, const mesh::Mesh& b,
                                                    const DistanceOptions& options, const Context& context);

}  // namespace isoextract::accuracy
