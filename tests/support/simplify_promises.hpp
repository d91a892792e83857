// Simplifies a surface, and expects every promise of edit/bounded_simplify.hpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include <gtest/gtest.h>

#include "accuracy/mesh_distance.hpp"
#include "edit/bounded_simplify.hpp"
#include "edit/detail/simplify_windows.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::test {

// Simplifies the mesh as a whole, or in windows of slabs with this number of triangles if it is not 0.
inline edit::SimplifiedMesh must_simplify(mesh::Mesh mesh, const edit::SimplifyOptions& options,
                                          std::uint64_t slab_triangles = 0) {
  if (slab_triangles > 0) {
    edit::SimplifiedMesh result{std::move(mesh), {}};
    const auto done = edit::simplify_in_windows(result.mesh, options, slab_triangles, result.facts, Context());
    if (!done) throw std::runtime_error(done.error().message);
    return result;
  }
  auto simplified = edit::simplify_mesh(std::move(mesh), options, Context());
  if (!simplified) throw std::runtime_error(simplified.error().message);
  return std::move(*simplified);
}

inline mesh::Mesh placed(const mesh::Mesh& mesh, const glm::dmat3& map) {
  mesh::Mesh image = copy(mesh);
  for (glm::vec3& p : image.positions) p = map * glm::dvec3(p);
  return image;
}

struct SimplifyCase {
  double iso = 0;
  double max_distance = 0.1;  // in voxels
  bool cap = true;
  bool normals = false;
  extract::Method method = extract::Method::mc;
  glm::dmat3 to_metric{1.0};
  double patch_size = 8;  // small, so that small tests have many patch borders
  std::uint64_t slab_triangles = 0;
};

// Extracts, simplifies and checks every promise of the header. Returns the ratio of triangles after to before.
inline double expect_kept_promises(const field::ScalarField& field, const SimplifyCase& c) {
  extract::ExtractOptions options;
  options.iso = c.iso;
  options.cap = c.cap;
  options.method = c.method;
  options.smooth_normals = c.normals;
  options.output_from_index = field.index_to_world;
  const mesh::Mesh before = test::extract(field, options).mesh;
  edit::SimplifyOptions simplify;
  simplify.max_distance = c.max_distance;
  simplify.patch_size = c.patch_size;
  simplify.to_metric = c.to_metric;
  const auto [after, facts] = must_simplify(copy(before), simplify, c.slab_triangles);

  EXPECT_EQ(facts.triangles_before, before.triangles.size());
  EXPECT_EQ(facts.triangles_after, after.triangles.size());
  EXPECT_LE(facts.triangles_after, facts.triangles_before);
  EXPECT_EQ(after.origin, before.origin);
  const mesh::Topology was = mesh::measure_topology(before);
  const mesh::Topology is = mesh::measure_topology(after);
  test::expect_sound(after, was.open_edges == 0);
  EXPECT_EQ(is.components, was.components);
  EXPECT_EQ(is.euler, was.euler);
  EXPECT_LE(is.open_edges, was.open_edges);
  EXPECT_EQ(is.open_edges > 0, was.open_edges > 0);
  if (before.triangles.empty()) return 1;

  EXPECT_LE(facts.distance_lower, facts.distance_upper);
  EXPECT_LE(facts.distance_upper, c.max_distance);
  accuracy::DistanceOptions measure;
  measure.samples = 0;
  const auto distance =
      accuracy::measure_distance(placed(before, c.to_metric), placed(after, c.to_metric), measure, Context());
  EXPECT_LE(distance->hausdorff_lower, facts.distance_upper + distance->resolution);
  EXPECT_LE(facts.distance_lower, distance->hausdorff_upper + distance->resolution);

  // The vertices are a subset of the old ones, in their order and with their normals.
  std::size_t v = 0;
  for (std::size_t w = 0; w < after.positions.size(); ++w, ++v) {
    while (v < before.positions.size() && before.positions[v] != after.positions[w]) ++v;
    if (v >= before.positions.size()) {
      ADD_FAILURE() << "vertex " << w << " is new, or out of order";
      break;
    }
    if (c.normals && before.normals[v] != after.normals[w]) ADD_FAILURE() << "the normal of vertex " << w;
  }
  return static_cast<double>(facts.triangles_after) / static_cast<double>(facts.triangles_before);
}

}  // namespace isoextract::test
