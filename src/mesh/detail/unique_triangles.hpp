// Finds triangles with equal corners.
#pragma once

#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "mesh/coincident_vertices.hpp"

namespace isoextract::mesh {

// The triangles with area, one for each set of three corners, in either winding.
struct UniqueTriangles {
  Buffer<std::uint32_t> triangles;  // the first triangle of each set, ascending
  Buffer<std::uint32_t> copies;     // size of each set
  std::uint64_t zero_area = 0;      // triangles whose corners are exactly on one line
  std::uint64_t duplicates = 0;     // triangles with area and the corners of an earlier one
};

// Uses distinct_triangle_bytes() of memory, which the caller reserves; throws std::bad_alloc.
[[nodiscard]] UniqueTriangles find_unique_triangles(std::span<const glm::vec3> positions,
                                                    std::span<const glm::uvec3> triangles,
                                                    const CoincidentVertices& places);
[[nodiscard]] std::uint64_t distinct_triangle_bytes(std::uint64_t triangles);

}  // namespace isoextract::mesh
