// Distances between two meshes: greatest (Hausdorff), root mean square, mean and 99th percentile.
//
// The greatest distance of A to B is that of the point of A that is farthest from B, anywhere on A's triangles. It is
// given as an interval that holds it, found by branch and bound (distance_bound.hpp), with no more than the rounding of
// double arithmetic left out. The other figures are of samples, spread over the area of A. A triangle that B has as
// well, with the very same corners, is at distance 0: meshes of the same triangles are exactly 0 apart, whatever their
// order.
//
// Everything is computed from the stored positions in double; the meshes may have different origins. The results are
// the same for any number of threads.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::accuracy {

struct DistanceOptions {
  double tolerance = 0.01;  // width of the interval of the greatest distance, as a fraction of it; above 0
  // Triangle by triangle, distances up to this need no closer look: then the interval may reach up to it.
  double enough = 0;
  std::uint64_t samples = 1 << 18;  // in each direction; with 0 the figures of samples stay 0
};

struct DirectedDistance {
  double max_lower = 0;     // the greatest distance is at least this,
  double max_upper = 0;     // and at most this
  glm::dvec3 place{0.0};    // a point of A as far as max_lower from B, in world coordinates
  glm::dvec3 nearest{0.0};  // and the point of B that is nearest to it
  double rms = 0;
  double mean = 0;
  double percentile99 = 0;
};

struct MeshDistance {
  DirectedDistance a_to_b;
  DirectedDistance b_to_a;
  // Of both directions: the greater of the two; the figures of samples over the samples of both.
  double hausdorff_lower = 0;
  double hausdorff_upper = 0;
  double rms = 0;
  double mean = 0;
  double percentile99 = 0;
  // Distances up to this are not told apart: what float32 resolves of the larger of the two meshes.
  double resolution = 0;
};

// Fails with ErrorCode::input if a mesh has no triangles: nothing has a distance to nothing; if the origins
// are more than 1e150 apart, where squared distances leave the range of double; or if there is not the memory for it.
// Positions must be finite.
[[nodiscard]] Result<MeshDistance> measure_distance(const mesh::Mesh& a, const mesh::Mesh& b,
                                                    const DistanceOptions& options, const Context& context);

}  // namespace isoextract::accuracy
