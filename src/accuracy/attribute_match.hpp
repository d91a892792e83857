// Compares the attributes of two meshes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mesh/mesh.hpp"

namespace isoextract::accuracy {

// An attribute of the same name in both meshes, or the colors of both.
struct AttributeMatch {
  std::string name;  // in the first mesh; colors may have another name in the second
  std::array<std::size_t, 2> components{};
  // How far the values of the same vertex differ: largest and mean over all components. Normalized integers and integer
  // colors count as fractions. Equal numbers, equal infinities and two NaN do not differ; other pairs with a non-finite
  // value are counted and left out. Absent if vertices do not correspond, if the numbers of components differ, or for
  // colors that are not compared.
  struct Difference {
    double largest = 0;
    std::size_t vertex = 0;  // the first vertex with the largest difference
    double mean = 0;
    std::uint64_t not_finite = 0;
  };
  std::optional<Difference> difference;
};

struct AttributeMatches {
  bool same_vertices = false;  // equal count, and positions of equal index within the tolerance
  std::vector<AttributeMatch> both;
  std::array<std::vector<std::string>, 2> only;  // attributes of one mesh only
};

// Returns an upper bound of the error, along each axis, that float32 has caused in the vertices of a mesh read from a
// file. The bound is 2^-23 times the largest absolute coordinate: of the world coordinates if all of them are float32
// numbers, else of the local ones.
[[nodiscard]] double coordinate_rounding(const mesh::Mesh& mesh);

// Compares all attributes. `colors` says whether color values mean the same in both meshes; if not, they are not
// compared. Vertices correspond by index if both meshes have equally many and no coordinate of any vertex differs by
// more than `tolerance`.
[[nodiscard]] AttributeMatches match_attributes(const mesh::Mesh& a, const mesh::Mesh& b, bool colors,
                                                double tolerance = 0);

}  // namespace isoextract::accuracy
