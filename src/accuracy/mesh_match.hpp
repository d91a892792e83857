// Compares a mesh read from a file with the mesh extracted from its field: are the triangles the same?
//
// The file has no edge keys and its vertices may be in any order, so vertices are matched by place. In each mesh,
// vertices at exactly the same place count as one, because formats without connectivity cannot tell them apart. Each
// file vertex is matched with the nearest extracted vertex within a limit along each axis; the match is one to one.
//
// The limit is the sum of the errors that writing and reading can add to a coordinate:
// - kStabilityUlps of the local coordinates, as another backend may have written the file.
// - One float32 spacing of the world coordinates, if the format stores only float32 world coordinates (STL) and the
//   mesh has its own origin. The comparison rounds the extracted coordinates, too, but another backend may have
//   written the neighboring number.
// - Half a float32 spacing of the reader's local coordinates: the reader converts doubles to float32 relative to its
//   own origin. Left out if the origins are equal, since the file then has the exact numbers.
// - Four roundings of the world coordinates, for sums in double. Left out if the origins are equal.
// - One step, if positions were quantized to multiples of a power of two (mesh_io/mesh_packing.hpp). The
//   comparison quantizes the extracted positions, too, but another backend may have written the next step.
//
// Extractors keep vertices of different edges at least four ulps of the local coordinates apart (OutputPlacement), so
// the nearest vertex is the right one; only STL far from the world origin may resolve less. Vertices that are not on
// edges (MethodTraits) can be closer: one of two such vertices may then count as missing.
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
  // For the written and for the extracted mesh.
  std::array<std::uint64_t, 2> vertices{};
  std::uint64_t matched = 0;                     // places where both meshes have a vertex
  std::array<std::uint64_t, 2> vertices_only{};  // places where only this mesh has a vertex
  std::array<std::optional<glm::dvec3>, 2> vertex_example{};
  TriangleDifference triangles;
  // For matched vertices, along each axis, in the mesh's unit.
  glm::dvec3 allowed{0.0};   // the limit
  glm::dvec3 distance{0.0};  // between the pair that uses most of the limit along an axis
  glm::dvec3 farthest{0.0};  // place of that pair
};

// Matches the meshes. `float32_world`: the file's format has float32 world coordinates only. `quantized`: its positions
// were quantized. Fails with ErrorCode::out_of_memory if memory is short.
[[nodiscard]] Result<MeshMatch> match_written_mesh(const mesh::Mesh& written, const mesh::Mesh& extracted,
                                                   bool float32_world, const Context& context, bool quantized = false);

// Returns one sentence (without full stop) for each difference, none if the meshes are equal. `names` are the names of
// the meshes.
[[nodiscard]] std::vector<std::string> differences(const MeshMatch& match, const MeshLabels& names);

}  // namespace isoextract::accuracy
