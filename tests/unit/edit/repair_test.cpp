// Repair: each damage is counted and undone, and the result bounds the volume that the whole mesh bounds.
#include "edit/repair.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "check/mesh_check.hpp"
#include "mesh/metrics.hpp"
#include "support/box_mesh.hpp"

namespace isoextract::edit {
namespace {

mesh::Mesh mesh_of(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles) {
  mesh::Mesh mesh;
  mesh.positions = Buffer<glm::vec3>(positions.size());
  std::copy(positions.begin(), positions.end(), mesh.positions.begin());
  mesh.triangles = Buffer<glm::uvec3>(triangles.size());
  std::copy(triangles.begin(), triangles.end(), mesh.triangles.begin());
  return mesh;
}

std::vector<glm::vec3> corners(const glm::vec3& low, const glm::vec3& high) {
  const mesh::Mesh box = test::box_mesh(low, high);
  return {box.positions.begin(), box.positions.end()};
}

std::vector<glm::uvec3> outward() {
  const mesh::Mesh box = test::box_mesh({0, 0, 0}, {1, 1, 1});
  return {box.triangles.begin(), box.triangles.end()};
}

RepairFigures expect_box(mesh::Mesh mesh, const RepairOptions& options = {}) {
  const auto figures = repair(mesh, options, Context());
  EXPECT_TRUE(figures);
  const auto found = check::check_mesh(mesh, Context());
  EXPECT_TRUE(found->topology.is_closed_oriented_manifold());
  EXPECT_EQ(found->size.zero_area_triangles, 0U);
  EXPECT_EQ(found->intersections.pairs, 0U);
  EXPECT_NEAR(mesh::measure_size(mesh).volume, 6, 1e-6);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  return *figures;
}

TEST(Repair, KeepsASoundMeshUnchanged) {
  const RepairFigures done = expect_box(mesh_of(corners({0, 0, 0}, {1, 2, 3}), outward()));
  EXPECT_EQ(
      done.welded + done.without_area + done.duplicates + done.turned + done.holes_filled + done.components_turned, 0U);
  EXPECT_EQ(done.vertices_split + done.unused_removed, 0U);
}

TEST(Repair, CountsDroppedAttributesOfWeldedVertices) {
  const std::vector<glm::vec3> box = corners({0, 0, 0}, {1, 2, 3});
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (const glm::uvec3& t : outward()) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    triangles.emplace_back(first, first + 1, first + 2);
    for (int corner = 0; corner < 3; ++corner) positions.push_back(box[t[corner]]);
  }
  for (const bool differ : {false, true}) {
    mesh::Mesh soup = mesh_of(positions, triangles);
    mesh::Attribute heat{"heat", mesh::AttributeRole::other, mesh::ComponentType::u8, 1, false, {}};
    heat.values = Buffer<std::byte>(positions.size());
    std::ranges::fill(heat.values, std::byte{1});
    if (differ) heat.values[positions.size() - 1] = std::byte{2};
    soup.attributes.push_back(std::move(heat));
    const RepairFigures done = expect_box(std::move(soup));
    EXPECT_EQ(done.welded, 28U);
    EXPECT_EQ(done.values_lost, differ ? 1U : 0U);
  }
}

TEST(Repair, CountsCopiesOfVerticesAndUnusedOnes) {
  // Two boxes with a common corner, and a vertex without a triangle between their vertices.
  std::vector<glm::vec3> positions = corners({0, 0, 0}, {1, 1, 1});
  std::vector<glm::uvec3> triangles = outward();
  positions.emplace_back(9, 9, 9);
  const std::vector<glm::vec3> second = corners({1, 1, 1}, {2, 2, 2});
  for (const glm::uvec3& t : outward()) {
    triangles.push_back({t.x == 0 ? 7 : t.x + 8, t.y == 0 ? 7 : t.y + 8, t.z == 0 ? 7 : t.z + 8});
  }
  positions.insert(positions.end(), second.begin() + 1, second.end());
  mesh::Mesh mesh = mesh_of(positions, triangles);
  const auto figures = repair(mesh, {}, Context());
  ASSERT_TRUE(figures);
  EXPECT_EQ(figures->vertices_split, 1U);
  EXPECT_EQ(figures->unused_removed, 1U);
  EXPECT_EQ(mesh.positions.size(), 16U);
  EXPECT_TRUE(check::check_mesh(mesh, Context())->topology.is_closed_oriented_manifold());
}

TEST(Repair, WeldsTriangleSoup) {
  const std::vector<glm::vec3> box = corners({0, 0, 0}, {1, 2, 3});
  std::vector<glm::vec3> soup;
  std::vector<glm::uvec3> triangles;
  for (const glm::uvec3& t : outward()) {
    const auto first = static_cast<std::uint32_t>(soup.size());
    for (int c = 0; c < 3; ++c) soup.push_back(box[t[c]]);
    triangles.emplace_back(first, first + 1, first + 2);
  }
  EXPECT_EQ(expect_box(mesh_of(soup, triangles)).welded, 28U);
}

TEST(Repair, KeepsClosedSheetsThatTouchApart) {
  // Two boxes that share an edge, each closed by its indices.
  std::vector<glm::vec3> positions = corners({0, 0, 0}, {1, 1, 1});
  std::vector<glm::uvec3> triangles = outward();
  for (const glm::vec3& p : corners({1, 1, 0}, {2, 2, 1})) positions.push_back(p);
  for (const glm::uvec3& t : outward()) triangles.push_back(t + 8U);
  mesh::Mesh mesh = mesh_of(positions, triangles);
  const auto figures = repair(mesh, {}, Context());
  ASSERT_TRUE(figures);
  EXPECT_EQ(figures->welded, 0U);
  EXPECT_TRUE(check::check_mesh(mesh, Context())->topology.is_closed_oriented_manifold());
}

TEST(Repair, FlipsTheMinorityOfTriangles) {
  std::vector<glm::uvec3> triangles = outward();
  for (const std::size_t t : {1, 4, 7, 8, 9}) std::swap(triangles[t].y, triangles[t].z);
  const RepairFigures done = expect_box(mesh_of(corners({0, 0, 0}, {1, 2, 3}), triangles));
  EXPECT_EQ(done.turned, 5U);
  EXPECT_EQ(done.contradictions, 0U);
  EXPECT_EQ(done.components_turned, 0U);
}

TEST(Repair, FillsEachHoleUpToTheLimit) {
  std::vector<glm::uvec3> triangles = outward();
  triangles.erase(triangles.begin() + 2, triangles.begin() + 4);
  triangles.erase(triangles.begin());
  const std::vector<glm::vec3> box = corners({0, 0, 0}, {1, 2, 3});
  const RepairFigures done = expect_box(mesh_of(box, triangles));
  EXPECT_EQ(done.holes_filled, 2U);
  EXPECT_EQ(done.fill_triangles, 3U);
  mesh::Mesh open = mesh_of(box, triangles);
  const auto three = repair(open, {.most_hole_edges = 3}, Context());
  ASSERT_TRUE(three);
  EXPECT_EQ(three->holes_filled, 1U);
  EXPECT_EQ(three->holes_left, 1U);
}

TEST(Repair, FillsHolesThatMeetInAVertex) {
  std::vector<glm::uvec3> triangles = outward();
  // Both have corner 3, and no other corner in common.
  std::erase(triangles, glm::uvec3(1, 2, 3));
  std::erase(triangles, glm::uvec3(3, 6, 7));
  const RepairFigures done = expect_box(mesh_of(corners({0, 0, 0}, {1, 2, 3}), triangles));
  EXPECT_EQ(done.holes_filled, 2U);
}

TEST(Repair, RemovesTrianglesWithoutAreaAndDuplicates) {
  std::vector<glm::vec3> positions = corners({0, 0, 0}, {1, 2, 3});
  std::vector<glm::uvec3> triangles = outward();
  triangles.push_back(triangles[3]);
  triangles.emplace_back(triangles[5].y, triangles[5].x, triangles[5].z);
  triangles.emplace_back(1, 1, 2);
  const RepairFigures done = expect_box(mesh_of(positions, triangles));
  EXPECT_EQ(done.duplicates, 2U);
  EXPECT_EQ(done.without_area, 1U);
}

TEST(Repair, GivesTheCornerOfAFlatTriangleToItsNeighbor) {
  std::vector<glm::vec3> positions = corners({0, 0, 0}, {1, 2, 3});
  std::vector<glm::uvec3> triangles = outward();
  positions.emplace_back(0, 1, 0);  // the middle of the edge from 0 to 2
  ASSERT_EQ(triangles[0], glm::uvec3(0, 2, 1));
  triangles[0] = {0, 8, 1};
  triangles.emplace_back(8, 2, 1);
  triangles.emplace_back(0, 2, 8);
  mesh::Mesh mesh = mesh_of(positions, triangles);
  const auto done = repair(mesh, {}, Context());
  ASSERT_TRUE(done);
  EXPECT_EQ(done->without_area, 1U);
  EXPECT_EQ(done->holes_filled, 0U);
  const auto found = check::check_mesh(mesh, Context());
  EXPECT_TRUE(found->topology.is_closed_oriented_manifold());
  EXPECT_EQ(found->size.zero_area_triangles, 0U);
  EXPECT_NEAR(mesh::measure_size(mesh).volume, 6, 1e-6);
}

}  // namespace
}  // namespace isoextract::edit
