// Compares the triangles of two meshes as sets, in any order of triangles and vertices.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/mesh.hpp"

namespace isoextract::accuracy {

// The name of a vertex that the other mesh does not have.
inline constexpr std::uint32_t kNoName = std::numeric_limits<std::uint32_t>::max();

// A mesh whose vertices have numbers as names: matching vertices of both meshes have equal names.
struct LabeledVertices {
  const mesh::Mesh& mesh;
  std::span<const std::uint32_t> names;  // one for each vertex: below the number of names, or kNoName
};

using MeshLabels = std::array<std::string_view, 2>;  // names of the first and the second mesh

struct TriangleDifference {
  std::array<std::uint64_t, 2> total{};  // for the first and the second mesh
  std::array<std::uint64_t, 2> only{};   // triangles that only this mesh has
  // Corner positions of the first triangle that only this mesh has; NaN for an index not below the number of vertices.
  std::array<std::optional<std::array<glm::dvec3, 3>>, 2> example{};
};

// Compares the triangles of both meshes. Triangles are equal if they name the same vertices in the same cyclic order;
// duplicates must occur equally often. A triangle with an unnamed or nonexistent vertex belongs to its mesh only. All
// names are below `names`. Throws std::bad_alloc.
[[nodiscard]] TriangleDifference compare_triangle_sets(const LabeledVertices& a, const LabeledVertices& b,
                                                       std::uint64_t names);

// Adds a sentence for each mesh with triangles that the other mesh lacks.
void add_difference_sentences(const TriangleDifference& difference, const MeshLabels& names,
                              std::vector<std::string>& sentences);

// Returns the memory that compare_triangle_sets() uses; `triangles` counts the triangles of both meshes.
[[nodiscard]] std::uint64_t triangle_comparison_bytes(std::uint64_t triangles, std::uint64_t names);

}  // namespace isoextract::accuracy
