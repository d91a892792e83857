// A mesh that was written to a file against the mesh that its field gives: the same triangles, or not.
//
// The file has no edge keys, and its vertices may stand in any order: they are matched by their place. On each side
// vertices at the very same place count as one, for a format without connectivity cannot tell them apart. Every vertex
// of the file is matched with the nearest one of the extraction, if that is near enough along each axis, and no two
// with the same one.
//
// Near enough is the sum of what the way through a file may cost a coordinate:
// - kStabilityUlps of the local coordinates, for another backend may have written the file;
// - where the format has float32 world coordinates only (STL), and the mesh an origin of its own: the coordinates are
//   rounded here as they were when they were written, so that they are the same again, but a coordinate of another
//   backend may have gone to the next float32 number: one spacing of the world coordinates;
// - the reader makes float32 numbers of coordinates in double, relative to an origin that it chooses: half a spacing of
//   those, unless the origin is the extraction's own (then the file had the very numbers);
// - sums in double: a few roundings of the world coordinates;
// - where positions were quantised, to multiples of a power of two (mesh_io/mesh_packing.hpp): the extraction's are
//   rounded here to the same, and those of another backend may have gone to the next one: one step.
// The extractors keep vertices of different edges at least four ulps of the local coordinates apart (OutputFrame), so
// that the nearest one is the right one; only STL far from the origin of the world may hold less than that. Nothing
// keeps vertices apart that are not on edges (MethodTraits): of two that are nearer than that, one may count as
// missing.
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

struct MeshMatch {
  // Of the written and of the extracted mesh.
  std::array<std::uint64_t, 2> vertices{};
  std::uint64_t matched = 0;                     // places that both have a vertex at
  std::array<std::uint64_t, 2> vertices_only{};  // places that only this mesh has a vertex at
  std::array<std::optional<glm::dvec3>, 2> vertex_example{};
  TriangleDifference triangles;
  // Of matched vertices, along each axis, in the unit of the mesh.
  glm::dvec3 allowed{0.0};   // what is near enough
  glm::dvec3 distance{0.0};  // of the pair that uses the largest share of it along one of the axes
  glm::dvec3 farthest{0.0};  // where that is
};

// `float32_world`: the file's format has float32 world coordinates only. `quantised`: its positions were quantised.
// Fails with ErrorCode::input if matching needs more memory than there is.
[[nodiscard]] Result<MeshMatch> match_meshes(const mesh::Mesh& written, const mesh::Mesh& extracted, bool float32_world,
                                             const Context& context, bool quantised = false);

// What differs, a sentence without its full stop each; none if they are the same. `names` are what the meshes are
// called.
[[nodiscard]] std::vector<std::string> differences(const MeshMatch& match, const MeshNames& names);

}  // namespace isoextract::accuracy
