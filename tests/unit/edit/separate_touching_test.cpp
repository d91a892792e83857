// Touching sheets: after the move, welding by position finds a closed 2-manifold, and no triangles meet that did not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "check/mesh_check.hpp"
#include "edit/separate_touching.hpp"
#include "mesh/self_intersections.hpp"
#include "support/voxel_patterns.hpp"

namespace isoextract::edit {
namespace {

constexpr double kDistance = 0.001;

struct Way {
  std::string name;
  extract::ExtractOptions options;
};

std::vector<Way> ways() {
  std::vector<Way> all{{"merged voxels", test::voxel_options()},
                       {"plain voxels", test::voxel_options(extract::VoxelFaces::plain)}};
  for (const std::uint64_t relaxations : {0, 1, 10, 100}) {
    extract::ExtractOptions options = test::voxel_options();
    options.method = extract::Method::surface_nets;
    options.relaxations = relaxations;
    all.push_back({"nets relaxed " + std::to_string(relaxations), options});
  }
  return all;
}

mesh::Topology welded_topology(mesh::Mesh mesh) {
  EXPECT_TRUE(check::weld_coincident_vertices(mesh, Context()));
  return mesh::measure_topology(mesh);
}

mesh::Mesh copy_of(const mesh::Mesh& mesh) {
  mesh::Mesh copy;
  copy.origin = mesh.origin;
  copy.positions = Buffer<glm::vec3>(mesh.positions.size());
  std::copy(mesh.positions.begin(), mesh.positions.end(), copy.positions.begin());
  copy.triangles = Buffer<glm::uvec3>(mesh.triangles.size());
  std::copy(mesh.triangles.begin(), mesh.triangles.end(), copy.triangles.begin());
  return copy;
}

// Separates the sheets of the mesh and checks the result. Returns the number of vertices that touched.
std::uint64_t expect_separated(mesh::Mesh mesh) {
  const mesh::Mesh before = copy_of(mesh);
  const auto checked_before = check::check_mesh(before, Context());
  const auto figures = separate_touching_vertices(mesh, kDistance, glm::dmat3(1.0), Context());
  EXPECT_TRUE(figures);
  const auto checked = check::check_mesh(mesh, Context());
  EXPECT_TRUE(checked->topology.is_closed_oriented_manifold());
  EXPECT_EQ(checked->repeated_vertices, 0U);
  EXPECT_LE(checked->intersections.pairs, checked_before->intersections.pairs);
  EXPECT_EQ(checked->size.zero_area_triangles, 0U);
  EXPECT_TRUE(welded_topology(copy_of(mesh)).is_closed_oriented_manifold());
  EXPECT_EQ(figures->touching > 0, checked_before->repeated_vertices > 0);
  EXPECT_LE(figures->greatest_move, 1.01 * kDistance);
  // A vertex that moves by the distance sweeps a third of the area around it.
  EXPECT_LE(std::abs(figures->volume_after - figures->volume_before), kDistance * mesh::measure_size(before).area);
  std::uint64_t moved = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) moved += mesh.positions[v] != before.positions[v] ? 1 : 0;
  EXPECT_EQ(moved, figures->moved);
  return figures->touching;
}

test::VoxelPattern padded(unsigned bits, bool solid_around) {
  test::VoxelPattern pattern{{4, 4, 4}, {}};
  pattern.for_each([&](const glm::ivec3& p) {
    const glm::ivec3 q = p - 1;
    const bool is_middle =
        glm::all(glm::greaterThanEqual(q, glm::ivec3(0))) && glm::all(glm::lessThan(q, glm::ivec3(2)));
    const bool inside = is_middle ? (bits >> (q.x | q.y << 1 | q.z << 2) & 1) != 0 : solid_around;
    pattern.inside.push_back(inside ? 1 : 0);
  });
  return pattern;
}

// All contacts of the eight voxels around a corner, alone and as the only cavities of a solid.
TEST(SeparateTouching, SeparatesAllPatternsOfEightVoxels) {
  std::uint64_t touching = 0;
  for (const Way& way : ways()) {
    for (const bool solid_around : {false, true}) {
      for (unsigned bits = solid_around ? 0 : 1; bits < 256; ++bits) {
        SCOPED_TRACE(way.name + ", pattern " + std::to_string(bits) + (solid_around ? " in a solid" : ""));
        touching += expect_separated(test::extract(test::field_of(padded(bits, solid_around)), way.options).mesh);
        if (testing::Test::HasFailure()) return;
      }
    }
  }
  EXPECT_GT(touching, 1000U);
}

TEST(SeparateTouching, SeparatesNoiseOfAnyDensity) {
  for (const int percent : {10, 20, 30, 40, 50, 70, 90}) {
    const auto field = test::field_of(test::random_pattern({11, 12, 13}, static_cast<unsigned>(percent), percent));
    for (const Way& way : ways()) {
      SCOPED_TRACE(way.name + ", density " + std::to_string(percent));
      EXPECT_GT(expect_separated(test::extract(field, way.options).mesh), 50U);
    }
  }
}

// Each of two cubes at an edge shrinks by a wedge along it, each of two at a corner by a tip.
TEST(SeparateTouching, ShrinksTouchingSolidsAndCavities) {
  const auto moved_mesh = [](unsigned bits, bool solid_around) {
    mesh::Mesh mesh = test::extract(test::field_of(padded(bits, solid_around)), test::voxel_options()).mesh;
    const double before = mesh::measure_size(mesh).volume;
    EXPECT_TRUE(separate_touching_vertices(mesh, kDistance, glm::dmat3(1.0), Context()));
    return mesh::measure_size(mesh).volume - before;
  };
  EXPECT_LT(moved_mesh(0b10000001, false), -1e-5);  // two solids at a corner
  EXPECT_LT(moved_mesh(0b00001001, false), -1e-5);  // at an edge
  EXPECT_GT(moved_mesh(0b01111110, true), 1e-5);    // two cavities at a corner
}

TEST(SeparateTouching, KeepsMeshesWithoutContacts) {
  mesh::Mesh mesh = test::extract(test::field_of(padded(0b00001111, false)), test::voxel_options()).mesh;
  const mesh::Mesh before = copy_of(mesh);
  const auto figures = separate_touching_vertices(mesh, kDistance, glm::dmat3(1.0), Context());
  EXPECT_EQ(figures->touching, 0U);
  EXPECT_EQ(figures->moved, 0U);
  EXPECT_EQ(test::triangle_set(mesh), test::triangle_set(before));
}

// Long, skewed and mirrored voxels: the sheets move as in voxel coordinates.
TEST(SeparateTouching, SeparatesStretchedVoxels) {
  const auto field = test::field_of(test::random_pattern({9, 9, 9}, 4, 30));
  const glm::dmat3 voxel(glm::dvec3(0.2, 0, 0), glm::dvec3(0.1, -0.7, 0), glm::dvec3(0, 0.3, 5));
  for (const Way& way : ways()) {
    SCOPED_TRACE(way.name);
    mesh::Mesh mesh = test::extract(field, way.options).mesh;
    for (glm::vec3& p : mesh.positions) p = glm::vec3(voxel * glm::dvec3(p));
    for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
    const std::uint64_t before = mesh::find_self_intersections(mesh, {}, Context())->pairs;
    EXPECT_GT(separate_touching_vertices(mesh, kDistance, voxel, Context())->touching, 100U);
    EXPECT_LE(mesh::find_self_intersections(mesh, {}, Context())->pairs, before);
    EXPECT_TRUE(welded_topology(std::move(mesh)).is_closed_oriented_manifold());
  }
}

// The move exceeds the steps of float32 numbers at the world position; where these are too coarse, nothing moves.
TEST(SeparateTouching, MovesVerticesFarFromTheOriginOnlyIfFloat32Allows) {
  for (const double away : {1e3, 8e3, 1e6}) {
    SCOPED_TRACE(away);
    mesh::Mesh mesh = test::extract(test::field_of(padded(0b00001001, false)), test::voxel_options()).mesh;
    mesh.origin = {away, 0, 0};
    const auto figures = separate_touching_vertices(mesh, kDistance, glm::dmat3(1.0), Context());
    EXPECT_EQ(figures->touching, 4U);
    EXPECT_EQ(figures->moved, away < 1e6 ? 4U : 0U);
    EXPECT_LE(figures->greatest_move, 8.1 * 0x1p-23 * away + kDistance);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) mesh.positions[v] = glm::vec3(mesh.position(v));
    EXPECT_EQ(welded_topology(std::move(mesh)).is_closed_oriented_manifold(), away < 1e6);
  }
}

TEST(SeparateTouching, IgnoresVerticesWithoutTriangles) {
  const mesh::Mesh box = test::extract(test::field_of(padded(0b1, false)), test::voxel_options()).mesh;
  mesh::Mesh mesh;  // first an unused vertex, at the position of the first used one
  mesh.positions = Buffer<glm::vec3>(box.positions.size() + 1);
  mesh.positions[0] = box.positions[0];
  std::copy(box.positions.begin(), box.positions.end(), mesh.positions.begin() + 1);
  mesh.triangles = Buffer<glm::uvec3>(box.triangles.size());
  std::transform(box.triangles.begin(), box.triangles.end(), mesh.triangles.begin(),
                 [](const glm::uvec3& t) { return t + 1U; });
  EXPECT_EQ(separate_touching_vertices(mesh, kDistance, glm::dmat3(1.0), Context())->moved, 0U);
}

}  // namespace
}  // namespace isoextract::edit
