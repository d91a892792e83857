// The triangles of two meshes as sets, whatever the order of triangles and vertices.
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

// A mesh whose vertices have the same names as those of another mesh that are the same.
struct NamedMesh {
  const mesh::Mesh& mesh;
  std::span<const std::uint32_t> names;  // one a vertex: below the number of names, or kNoName
};

using MeshNames = std::array<std::string_view, 2>;  // what the first and the second mesh are called

struct TriangleDifference {
  std::array<std::uint64_t, 2> total{};                               // of the first, of the second mesh
  std::array<std::uint64_t, 2> only{};                                // triangles of this mesh only
  std::array<std::optional<std::array<glm::dvec3, 3>>, 2> example{};  // the corners of one of them
};

// Triangles are the same if they name the same vertices in the same sense of rotation, wherever they start. One that is
// there twice must be there twice. A triangle with a nameless vertex, or with one that is not there at all, is in its
// mesh only.
[[nodiscard]] TriangleDifference compare_triangle_sets(const NamedMesh& a, const NamedMesh& b, std::uint64_t names);

// Adds a sentence for each mesh that has triangles for itself.
void add_sentences(const TriangleDifference& difference, const MeshNames& names, std::vector<std::string>& sentences);

// "(1, 2.5, -3)"
[[nodiscard]] std::string point_text(const glm::dvec3& point);

// What that takes in memory.
[[nodiscard]] std::uint64_t triangle_comparison_bytes(std::uint64_t triangles, std::uint64_t names);

}  // namespace isoextract::accuracy
