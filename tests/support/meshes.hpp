// Compares meshes.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "extract/extractor.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"
#include "support/methods.hpp"

namespace isoextract::test {

using Point = std::tuple<double, double, double>;

// Returns the sorted triangles as corner positions, each rotated to start at its least corner. Independent of the order
// of vertices and triangles, but not of winding.
inline std::vector<std::array<Point, 3>> triangle_set(const mesh::Mesh& mesh) {
  std::vector<std::array<Point, 3>> set;
  for (const glm::uvec3& t : mesh.triangles) {
    std::array<Point, 3> corners;
    for (int c = 0; c < 3; ++c) {
      const glm::dvec3 p = mesh.position(t[c]);
      corners[static_cast<std::size_t>(c)] = {p.x, p.y, p.z};
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    set.push_back(corners);
  }
  std::sort(set.begin(), set.end());
  return set;
}

// Compares bit for bit: -0 differs from 0.
template <class T>
bool same_bytes(const Buffer<T>& a, const Buffer<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

inline extract::Extraction extract(const field::ScalarField& field, const extract::ExtractOptions& options) {
  Result<extract::Extraction> result = extract::make_cpu_extractor()->extract(field, options, Context());
  if (!result) {
    ADD_FAILURE() << result.error().message;
    return {};
  }
  return std::move(*result);
}

// Expects the mesh to be closed (if `closed`), oriented and manifold, without unused vertices or zero-area triangles.
inline void expect_sound(const mesh::Mesh& mesh, bool closed) {
  const mesh::Topology t = mesh::measure_topology(mesh);
  if (closed) {
    EXPECT_EQ(t.open_edges, 0U);
  }
  EXPECT_EQ(t.nonmanifold_edges, 0U);
  EXPECT_EQ(t.misoriented_edges, 0U);
  EXPECT_EQ(t.nonmanifold_vertices, 0U);
  EXPECT_EQ(t.repeated_index_triangles, 0U);
  EXPECT_EQ(t.unused_vertices, 0U);
  EXPECT_EQ(mesh::measure_size(mesh).zero_area_triangles, 0U);
}

}  // namespace isoextract::test
