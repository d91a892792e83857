// Normals at vertices that agree with the triangles around them, for meshes whose triangles do not follow the field as
// extracted ones do: where a cap meets the surface at an angle, and where triangles were left out.
//
// The triangles around a vertex form groups, within which one triangle is reached from the other across edges that are
// no creases. Each group has a normal of its own, and its own copy of the vertex: then what is flat is shaded flat. A
// group keeps the normal that the vertex had where that is no farther from the group's mean than the group's farthest
// triangle is; else it gets the mean, weighted by area (so that large flat triangles decide; as in N. Max, "Weights for
// computing vertex normals from facet normals", 1999, area weights are the least disturbed by slivers). Where even the
// mean points against a triangle of the group, it is turned until none is left, and where that cannot be, the group is
// parted.
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
  // Of each triangle the number of the plane that it lies in, 0 where it is in none; or nothing where none is. Edges
  // between two numbers are creases, and triangles of a plane have its normal.
  std::span<const std::uint8_t> planes;
  // The edges of flat parts across which the planes turn by more than this angle are creases, too, and every normal is
  // held against its triangles. A triangle is of a flat part where it and a neighbour are in one plane, within
  // kFlatDegrees; between others, as in rough data, only what points the wrong way is parted. Nothing: vertices all of
  // whose triangles are in no plane keep their normal as it is.
  std::optional<double> crease_degrees;
  // False: no vertex is copied, and each has the mean of all its triangles.
  bool may_copy = true;
};

// Gives the mesh such normals, one a vertex; one without normals gets means. Copies stand behind all other vertices, in
// the order of those that they copy, and have all that belongs to them. Returns how many there are. The same for any
// number of threads. Fails with ErrorCode::input where the memory is not there, or for more vertices than a mesh can
// number; `source` starts the message.
[[nodiscard]] Result<std::uint64_t> shade_by_triangles(Mesh& mesh, const ShadingOptions& options,
                                                       const std::string& source, const Context& context);

// Pairs of a triangle and a corner of it.
struct NormalAgreement {
  std::uint64_t pairs = 0;    // of triangles with an area
  std::uint64_t against = 0;  // whose normal points to the other side of the triangle than its winding does
};

// Of a mesh with normals.
[[nodiscard]] NormalAgreement measure_normal_agreement(const Mesh& mesh);

}  // namespace isoextract::mesh
