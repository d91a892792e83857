// One vertex, and the triangles of one cell, into a mesh: the same for dense and sparse samples.
#pragma once

#include "extract/cell_tables.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/inside_test.hpp"

namespace isoextract {

// The vertex on the crossed edge from sample `p` to `p + step`. `value(q)` is the field at a sample. `gradient(q)`, of
// the stored numbers there, is asked only if the mesh has normals: they come from the gradient at the vertex (seed S1).
template <class Value, class Gradient>
void write_vertex(Mesh& mesh, std::size_t number, const Placement& placement, const InsideRule& rule,
                  const glm::ivec3& p, const glm::ivec3& step, const Value& value, const Gradient& gradient) {
  const double f0 = value(p);
  const double t = edge_crossing(f0, value(p + step), rule.iso, placement.margin());
  mesh.positions[number] = placement.position(glm::dvec3(p) + t * glm::dvec3(step));
  if (!mesh.edges.empty()) mesh.edges[number] = {p, step_direction(step)};
  if (mesh.normals.empty()) return;
  mesh.normals[number] =
      placement.normal((1 - t) * gradient(p) + t * gradient(p + step), (rule(f0) ? 1.0 : -1.0) * glm::dvec3(step));
}

// Writes what a cell draws from `out` on and returns where the next cell's triangles go. `vertex(e)` is the number of
// the vertex on the cell's edge table.edges[e]. Mirrored frames turn triangles over.
template <class Vertex>
glm::uvec3* write_cell(const CaseTable& table, unsigned variant, bool mirrored, const Vertex& vertex, glm::uvec3* out) {
  for (int t = table.first[variant]; t < table.first[variant + 1]; ++t) {
    const CellTriangle& triangle = table.triangles[t];
    const std::uint32_t b = vertex(triangle[1]);
    const std::uint32_t c = vertex(triangle[2]);
    *out++ = mirrored ? glm::uvec3(vertex(triangle[0]), c, b) : glm::uvec3(vertex(triangle[0]), b, c);
  }
  return out;
}

}  // namespace isoextract
