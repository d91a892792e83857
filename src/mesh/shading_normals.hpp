// Vertex normals from the adjacent triangles, for vertices where the field's gradient does not fit them: where a cap
// meets the surface at an angle, and where triangles were removed.
//
// Two triangles around a vertex are in one group if they share an edge that has no other triangle and is not a crease.
// Each group gets one normal, and groups with different normals get separate copies of the vertex, so that flat parts
// look flat. A group keeps the vertex's old normal if this normal points against none of its triangles. If the
// triangles have a plane number (ShadingOptions::planes), the old normal must also be the plane's normal. If they have
// none and crease_degrees is set, the old normal must be close to the group's mean. The allowed angle is the largest
// angle between the mean and a triangle of the group, but at least 1 degree.
//
// Else the group gets the mean, weighted by area, so that large flat triangles decide and slivers count little. If even
// the mean points against a triangle, it is turned until it agrees with all of them. If that is impossible, the group
// is split.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

constexpr double kFlatDegrees = 1;

struct ShadingOptions {
  // The number of each triangle's plane, 0 for none; or empty. Edges between different numbers are creases, and
  // triangles with a number get the normal of their plane.
  std::span<const std::uint8_t> planes;
  // If set, an edge of a flat part is a crease, too, if its two triangles turn by more than this angle, and every
  // normal is checked against its triangles. A triangle belongs to a flat part if it and a neighbor are coplanar within
  // kFlatDegrees.
  // Elsewhere, as in rough data, a group is split only if a normal points the wrong way.
  // If empty, vertices whose triangles have no plane number keep their normal.
  std::optional<double> crease_degrees;
  // Allows copies of vertices. Without copies, each vertex gets the mean of all its triangles; it keeps its normal only
  // if crease_degrees is empty and none of its triangles has a plane number.
  bool may_copy = true;
};

// Computes one normal per vertex and returns the number of added copies. A mesh without normals gets means, and
// (0, 0, 1) at vertices without triangles. Copies follow all other vertices, in the order of their originals, with all
// their attributes. The result is the same for any number of threads.
//
// Fails with ErrorCode::out_of_memory, and with ErrorCode::input if there are more vertices than 32-bit indices allow;
// `source` starts the message.
[[nodiscard]] Result<std::uint64_t> compute_shading_normals(Mesh& mesh, const ShadingOptions& options,
                                                            const std::string& source, const Context& context);

// Counts pairs of a triangle and one of its corners.
struct NormalAgreement {
  std::uint64_t pairs = 0;    // of triangles with an area above 0
  std::uint64_t against = 0;  // pairs with a normal that points away from the side that the triangle faces
};

// The mesh must have normals.
[[nodiscard]] NormalAgreement measure_normal_agreement(const Mesh& mesh);

}  // namespace isoextract::mesh
