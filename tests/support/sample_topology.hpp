// Counts the topology of a surface without a mesh, where it depends only on which samples are inside.
//
// Connected inside samples form a body. The body is homotopic to the edges, faces and solids between samples whose
// corners are all inside; the closed surface around it has twice their Euler number.
// Each component of the surface separates space in two, so there is one component fewer than bodies and outside regions
// together.
#pragma once

#include <bit>
#include <set>
#include <vector>

#include "extract/cell_tables.hpp"
#include "support/trilinear_topology.hpp"
#include "support/voxel_patterns.hpp"

namespace isoextract::test {

struct SurfaceCount {
  int components = 0;
  int euler = 0;  // sum over all components

  friend bool operator==(const SurfaceCount&, const SurfaceCount&) = default;
};

// How samples are connected. Corners are numbered as in a cell (cell_tables.hpp); steps are relative to a sample.
struct SampleJoins {
  struct Shape {
    unsigned corners;  // one bit per corner
    int dimension;
    unsigned outside = 0;  // corners that must be outside
  };
  std::vector<Shape> shapes;              // edges, faces and solids, each listed at its lowest corner
  std::vector<glm::ivec3> outside_steps;  // to the neighbors with which an outside sample is connected
};

inline glm::ivec3 corner_step(unsigned corner) { return {corner & 1, corner >> 1 & 1, corner >> 2 & 1}; }

// Returns the connectivity of voxels: inside voxels connect across faces, outside voxels across faces and edges.
// Nothing connects across a corner: if two opposite voxels at a corner are outside and the other six form a ring around
// it, the ring is filled.
inline SampleJoins joined_by_faces() {
  SampleJoins joins;
  for (unsigned directions = 1; directions < 8; ++directions) {
    unsigned corners = 0;
    for (unsigned c = 0; c < 8; ++c) corners |= (c & ~directions) == 0 ? 1U << c : 0;
    joins.shapes.push_back({corners, std::popcount(directions)});
  }
  for (unsigned corner = 0; corner < 4; ++corner) {
    const unsigned opposite = 1U << corner | 1U << (7 - corner);
    joins.shapes.push_back({255 & ~opposite, 2, opposite});
  }
  joins.outside_steps = {{1, 0, 0}, {0, 1, 0},  {0, 0, 1}, {1, 1, 0}, {1, -1, 0},
                         {0, 1, 1}, {0, 1, -1}, {1, 0, 1}, {1, 0, -1}};
  return joins;
}

// Returns the connectivity of tetrahedra: inside and outside samples connect along the edges of a cell's tetrahedra.
inline SampleJoins joined_by_tetrahedra() {
  SampleJoins joins;
  std::set<unsigned> seen;
  for (const auto& tetrahedron : extract::cell_tetrahedra()) {
    for (unsigned part = 1; part < 16; ++part) {
      if (std::popcount(part) < 2) continue;
      unsigned lowest = 7;
      for (unsigned v = 0; v < 4; ++v) lowest &= (part >> v & 1) != 0 ? tetrahedron[v] : 7U;
      unsigned corners = 0;
      for (unsigned v = 0; v < 4; ++v) corners |= (part >> v & 1) != 0 ? 1U << (tetrahedron[v] - lowest) : 0;
      if (!seen.insert(corners).second) continue;
      joins.shapes.push_back({corners, std::popcount(part) - 1});
      if (std::popcount(part) == 2) {
        joins.outside_steps.push_back(corner_step(static_cast<unsigned>(std::bit_width(corners)) - 1));
      }
    }
  }
  return joins;
}

// Returns the topology of the surface between inside samples and all others. Samples beyond the pattern are outside.
inline SurfaceCount count_surface(const VoxelPattern& inside, const SampleJoins& joins) {
  const glm::ivec3 size = inside.dims + 2;  // with an outside layer on every side
  DisjointSets sets;
  const auto number = [&](const glm::ivec3& p) {
    return static_cast<std::size_t>(p.x + 1 + size.x * (p.y + 1 + size.y * (p.z + 1)));
  };
  const VoxelPattern places{size, {}};
  places.for_each([&](const glm::ivec3&) { sets.add(); });
  int euler = 0;
  places.for_each([&](const glm::ivec3& place) {
    const glm::ivec3 p = place - 1;
    if (inside.at(p)) {
      ++euler;
    } else {
      for (const glm::ivec3& step : joins.outside_steps) {
        const glm::ivec3 next = place + step;
        const bool there = glm::all(glm::greaterThanEqual(next, glm::ivec3(0))) && glm::all(glm::lessThan(next, size));
        if (there && !inside.at(p + step)) sets.join(number(p), number(p + step));
      }
    }
    unsigned corners = 0;
    for (unsigned c = 0; c < 8; ++c) corners |= inside.at(p + corner_step(c)) ? 1U << c : 0;
    for (const SampleJoins::Shape& shape : joins.shapes) {
      if ((corners & shape.corners) != shape.corners || (corners & shape.outside) != 0) continue;
      euler += shape.dimension % 2 == 0 ? 1 : -1;
      if (shape.dimension == 1) {
        sets.join(number(p), number(p + corner_step(static_cast<unsigned>(std::bit_width(shape.corners)) - 1)));
      }
    }
  });
  int parts = 0;
  places.for_each([&](const glm::ivec3& place) { parts += sets.find(number(place - 1)) == number(place - 1) ? 1 : 0; });
  return {parts - 1, 2 * euler};
}

}  // namespace isoextract::test
