// The attributes of two meshes side by side.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mesh/mesh.hpp"

namespace isoextract::accuracy {

// Of an attribute that both meshes have, by its name, or of their colours.
struct AttributeMatch {
  std::string name;
  std::array<std::size_t, 2> components{};
  // Where vertices correspond and the components are as many: how far values of one vertex differ, the most and on the
  // average of all components. Normalised integers count as the fractions that they stand for. Values that are the same
  // number, the same infinity or both NaN do not differ; others that are not finite are counted and left out.
  struct Difference {
    double largest = 0;
    std::size_t vertex = 0;  // where that is: the first of them
    double mean = 0;
    std::uint64_t not_finite = 0;
  };
  std::optional<Difference> difference;
};

struct AttributeMatches {
  bool same_vertices = false;  // as many at the same places in the same order
  std::vector<AttributeMatch> both;
  std::array<std::vector<std::string>, 2> only;
};

// Returns how far float32 may have put the vertices of a mesh that was read from their places, along each axis.
// Coordinates that are all float32 were rounded as they are, others relative to the origin of the mesh.
[[nodiscard]] double coordinate_rounding(const mesh::Mesh& mesh);

// `colours` says whether numbers of colours mean the same in both; if not their difference is left out. Vertices are at
// the same place where no coordinate differs by more than `tolerance`.
[[nodiscard]] AttributeMatches match_attributes(const mesh::Mesh& a, const mesh::Mesh& b, bool colours,
                                                double tolerance = 0);

}  // namespace isoextract::accuracy
