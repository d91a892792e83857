#include "check/mesh_check.hpp"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "mesh/join_meshes.hpp"
#include "support/box_mesh.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::check {
namespace {

using test::make_mesh;

MeshCheck check(const mesh::Mesh& mesh) {
  auto found = check_mesh(mesh, Context());
  if (!found) {
    ADD_FAILURE() << found.error().message;
    return {};
  }
  return std::move(*found);
}

// A cube from -half to half around `center`, facing outward or, if turned, inward.
mesh::Mesh centered_cube(float half, bool turned = false, const glm::vec3& center = glm::vec3(0)) {
  mesh::Mesh mesh = test::box_mesh(center - half, center + half);
  if (turned) {
    for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  }
  return mesh;
}

mesh::Mesh together(std::vector<mesh::Mesh> meshes) { return std::move(*mesh::join_meshes(meshes, Context())); }

template <class... Meshes>
mesh::Mesh all_of(Meshes... meshes) {
  std::vector<mesh::Mesh> list;
  (list.push_back(std::move(meshes)), ...);
  return together(std::move(list));
}

std::vector<Shell> shells(const MeshCheck& found) {
  std::vector<Shell> result;
  for (const Component& component : found.components) result.push_back(component.shell);
  return result;
}

void leave_out(mesh::Mesh& mesh, std::size_t triangle) {
  Buffer<glm::uvec3> left(mesh.triangles.size() - 1);
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t != triangle) left[count++] = mesh.triangles[t];
  }
  mesh.triangles = std::move(left);
}

bool meets(Requirement requirement, const MeshCheck& found) { return !unmet_reason(requirement, found); }

TEST(MeshCheckTest, AcceptsCube) {
  const MeshCheck found = check(centered_cube(0.5F));
  for (const Word<Requirement>& one : words_of(Requirement{})) {
    EXPECT_EQ(meets(one.value, found), one.value != Requirement::normals) << one.word;
  }
  ASSERT_EQ(found.components.size(), 1U);
  const Component& component = found.components.front();
  EXPECT_EQ(component.shell, Shell::body);
  EXPECT_EQ(component.genus, 0);
  EXPECT_DOUBLE_EQ(component.volume, 1);
  EXPECT_DOUBLE_EQ(component.area, 6);
  EXPECT_EQ(component.vertices, 8U);
  EXPECT_EQ(component.triangles, 12U);
  EXPECT_EQ(component.bounds.min, glm::dvec3(-0.5));
  EXPECT_TRUE(found.loops.empty());
  EXPECT_FALSE(found.welded);
}

TEST(MeshCheckTest, CountsAndMeasuresHoles) {
  mesh::Mesh mesh = centered_cube(0.5F);
  leave_out(mesh, 0);
  const MeshCheck one = check(mesh);
  ASSERT_EQ(one.loops.size(), 1U);
  EXPECT_EQ(one.loops[0].edges, 3U);
  EXPECT_NEAR(one.loops[0].length, 2 + std::sqrt(2.0), 1e-12);
  EXPECT_EQ(one.components[0].shell, Shell::open);
  EXPECT_EQ(one.components[0].genus, 0);
  EXPECT_EQ(unmet_reason(Requirement::closed, one), "3 open edges in 1 loop");
  // Without the other triangle of the face there is one hole of four edges; one triangle of the far face adds a second.
  leave_out(mesh, 0);
  EXPECT_EQ(check(mesh).loops.size(), 1U);
  leave_out(mesh, 0);
  const MeshCheck two = check(mesh);
  ASSERT_EQ(two.loops.size(), 2U);
  EXPECT_EQ(two.loops[0].edges + two.loops[1].edges, 7U);
  EXPECT_EQ(two.components[0].genus, 0);
}

// Without two triangles at a pole. If the pole were two vertices, one for each fan, the surface would have one rim.
TEST(MeshCheckTest, TreatsVertexWithTwoFansAsTwo) {
  mesh::Mesh mesh = test::sphere(6, false);
  const std::size_t pole_triangles = 12;
  std::vector<std::size_t> at_pole;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.triangles[t].x == 0) at_pole.push_back(t);
  }
  ASSERT_EQ(at_pole.size(), pole_triangles);
  leave_out(mesh, at_pole[6]);
  leave_out(mesh, at_pole[0]);
  const MeshCheck found = check(mesh);
  EXPECT_EQ(found.topology.nonmanifold_vertices, 1U);  // the pole has two fans
  EXPECT_EQ(found.topology.open_edges, 6U);
  EXPECT_EQ(found.loops.size(), 1U);  // each fan joins an edge of one hole with one of the other
  EXPECT_FALSE(meets(Requirement::manifold, found));
  // Two triangles that share only a corner have a rim each.
  const MeshCheck bow =
      check(make_mesh("bow", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}));
  EXPECT_EQ(bow.components.size(), 1U);
  EXPECT_EQ(bow.loops.size(), 2U);
}

TEST(MeshCheckTest, CountsMisorientedEdges) {
  mesh::Mesh mesh = centered_cube(0.5F);
  std::swap(mesh.triangles[3].x, mesh.triangles[3].y);
  const MeshCheck found = check(mesh);
  EXPECT_EQ(found.components[0].edges.misoriented, 3U);
  EXPECT_EQ(found.components[0].shell, Shell::not_oriented);
  EXPECT_EQ(found.components[0].volume, 0);
  EXPECT_FALSE(found.has_volume());
  EXPECT_FALSE(found.components[0].genus);
  EXPECT_FALSE(meets(Requirement::oriented, found));
  EXPECT_TRUE(meets(Requirement::closed, found));
}

TEST(MeshCheckTest, CountsNonmanifoldEdges) {
  const MeshCheck found = check(
      make_mesh("fins", {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}));
  EXPECT_EQ(found.topology.nonmanifold_edges, 1U);
  EXPECT_EQ(found.components[0].edges.nonmanifold, 1U);
  EXPECT_EQ(found.components[0].edges.open, 6U);
  EXPECT_EQ(found.intersections.pairs, 0U);
}

TEST(MeshCheckTest, SumsDefectsOfComponents) {
  mesh::Mesh open = test::sphere(8, false);
  leave_out(open, 30);
  mesh::Mesh turned = centered_cube(5);
  std::swap(turned.triangles[3].x, turned.triangles[3].y);
  const mesh::Mesh mesh = all_of(std::move(open), std::move(turned), centered_cube(9), test::tetrahedron());
  const MeshCheck found = check(mesh);
  ASSERT_EQ(found.components.size(), 4U);
  EdgeDefects sum;
  double area = 0;
  for (const Component& component : found.components) {
    sum.open += component.edges.open;
    sum.misoriented += component.edges.misoriented;
    area += component.area;
  }
  EXPECT_EQ(sum.open, found.topology.open_edges);
  EXPECT_EQ(sum.misoriented, found.topology.misoriented_edges);
  EXPECT_NEAR(area, found.size.area, 1e-9 * area);
  EXPECT_FALSE(meets(Requirement::one_component, found));
}

// Concentric cubes: the rays leave through edges, diagonals and corners of the outer ones.
TEST(MeshCheckTest, FindsNestedShells) {
  EXPECT_EQ(shells(check(all_of(centered_cube(1), centered_cube(2), centered_cube(3)))),
            (std::vector{Shell::body, Shell::nested, Shell::body}));
  EXPECT_EQ(shells(check(all_of(centered_cube(1, true), centered_cube(2)))), (std::vector{Shell::cavity, Shell::body}));
  EXPECT_EQ(shells(check(all_of(centered_cube(1), centered_cube(2, true)))),
            (std::vector{Shell::nested, Shell::inside_out}));
  EXPECT_EQ(shells(check(centered_cube(1, true))), (std::vector{Shell::inside_out}));
  const glm::vec3 far(10, 0, 0);
  const MeshCheck beside = check(all_of(centered_cube(1), centered_cube(1, false, far), centered_cube(1, true, -far),
                                        centered_cube(0.5F, true, far)));
  EXPECT_EQ(shells(beside), (std::vector{Shell::body, Shell::body, Shell::inside_out, Shell::cavity}));
  EXPECT_EQ(unmet_reason(Requirement::outward, beside), "1 component inside out");
  for (std::uint32_t depth = 0; depth < 12; ++depth) {
    std::vector<mesh::Mesh> nest;
    for (std::uint32_t i = 0; i <= depth; ++i)
      nest.push_back(centered_cube(static_cast<float>(i + 1), (depth - i) % 2 == 1));
    const MeshCheck found = check(together(std::move(nest)));
    for (std::uint32_t i = 0; i <= depth; ++i) {
      EXPECT_EQ(found.components[i].enclosing_shells, depth - i);
      EXPECT_EQ(found.components[i].shell, (depth - i) % 2 == 1 ? Shell::cavity : Shell::body);
    }
  }
}

// A row of bodies along the rays: each ray would cross all bodies behind its own.
TEST(MeshCheckTest, HandlesManyShellsInARow) {
  constexpr int kBodies = 60'000;
  std::vector<mesh::Mesh> row;
  for (int i = 0; i < kBodies; ++i) row.push_back(centered_cube(0.5F, false, {3.0F * static_cast<float>(i), 0, 0}));
  row.push_back(centered_cube(0.25F, true));
  const MeshCheck found = check(together(std::move(row)));
  EXPECT_EQ(found.count(Shell::body), static_cast<std::uint64_t>(kBodies));
  EXPECT_EQ(found.count(Shell::cavity), 1U);
}

// Two halves side by side, and a body that fills a cavity: shared walls with identical points.
TEST(MeshCheckTest, DoesNotNestShellsWithSharedWalls) {
  const glm::vec3 beside(2, 0, 0);
  for (const float sign : {-1.0F, 1.0F}) {
    for (const float size : {1.0F, 0.5F}) {  // the whole wall and part of it
      const glm::vec3 moved = sign * glm::vec3(1 + size, 0, 0);
      EXPECT_EQ(shells(check(all_of(centered_cube(1), centered_cube(size, false, moved)))),
                (std::vector{Shell::body, Shell::body}));
    }
    EXPECT_EQ(shells(check(all_of(centered_cube(1), centered_cube(1, false, sign * beside), centered_cube(3)))),
              (std::vector{Shell::nested, Shell::nested, Shell::body}));
  }
  EXPECT_EQ(shells(check(all_of(centered_cube(1), centered_cube(1, true), centered_cube(2)))),
            (std::vector{Shell::body, Shell::cavity, Shell::body}));
}

// Rays that leave through corners or along sides, and lines that cross a shell only behind the start of the ray.
TEST(MeshCheckTest, FindsNestedShellsWithSlantedFaces) {
  const auto octahedron = [](float radius, const glm::vec3& center = glm::vec3(0)) {
    std::vector<glm::vec3> positions{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (glm::vec3& p : positions) p = p * radius + center;
    return make_mesh("octahedron", positions,
                     {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
  };
  const auto within = [](const MeshCheck& found) {
    std::vector<std::uint32_t> depths;
    for (const Component& component : found.components) depths.push_back(component.enclosing_shells);
    return depths;
  };
  using Depths = std::vector<std::uint32_t>;
  EXPECT_EQ(within(check(all_of(octahedron(1), octahedron(2), octahedron(3), octahedron(4)))), (Depths{3, 2, 1, 0}));
  // The ray runs along the side between two faces (y = 0) or crosses it (y = z).
  EXPECT_EQ(within(check(all_of(octahedron(1), octahedron(0.125F, {0.25F, 0, 0.25F})))), (Depths{0, 1}));
  EXPECT_EQ(within(check(all_of(octahedron(1), octahedron(0.125F, {0.25F, 0.25F, 0})))), (Depths{0, 1}));
  EXPECT_EQ(within(check(all_of(octahedron(8), octahedron(1, {-20, 0, 0}), octahedron(1, {0, 8, 4})))),
            (Depths{0, 0, 0}));
  // Outside a face but inside the shell's bounding box; the second time beside another shell.
  EXPECT_EQ(within(check(all_of(octahedron(8), octahedron(0.5F, {5, 2.5F, 2.5F})))), (Depths{0, 0}));
  EXPECT_EQ(within(check(all_of(octahedron(8), octahedron(0.5F, {5, 2.5F, 2.5F}), octahedron(2, {8.5F, 2.5F, 2.5F})))),
            (Depths{0, 0, 0}));
  // Diagonals of the faces in front of the rays.
  mesh::Mesh outer = centered_cube(3);
  for (glm::vec3& p : outer.positions) p.y = -p.y;
  for (glm::uvec3& t : outer.triangles) std::swap(t.y, t.z);
  EXPECT_EQ(within(check(all_of(centered_cube(1), std::move(outer)))), (Depths{1, 0}));
}

TEST(MeshCheckTest, ReportsSeamsOfDuplicatedVertices) {
  // A cube with three vertices of its own for each triangle, and one unused vertex.
  const mesh::Mesh whole = centered_cube(1);
  std::vector<glm::vec3> positions{{7, 7, 7}};
  std::vector<glm::uvec3> triangles;
  for (const glm::uvec3& t : whole.triangles) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (int c = 0; c < 3; ++c) positions.push_back(whole.positions[t[c]]);
    triangles.emplace_back(first, first + 1, first + 2);
  }
  mesh::Mesh mesh = make_mesh("seams", positions, triangles);
  const MeshCheck apart = check(mesh);
  EXPECT_EQ(apart.repeated_vertices, 36U - 8);
  EXPECT_EQ(apart.topology.open_edges, 36U);
  EXPECT_EQ(apart.components.size(), 12U);
  ASSERT_TRUE(apart.welded);
  EXPECT_EQ(apart.welded->open_edges, 0U);
  EXPECT_EQ(apart.welded->components, 1U);
  EXPECT_EQ(apart.intersections.pairs, 0U);
  EXPECT_EQ(apart.topology.unused_vertices, 1U);
  ASSERT_TRUE(weld_coincident_vertices(mesh, Context()));
  const MeshCheck joined = check(mesh);
  EXPECT_TRUE(joined.topology.is_closed_oriented_manifold());
  EXPECT_EQ(joined.vertices, 9U);
  EXPECT_EQ(joined.topology.unused_vertices, 1U);
  EXPECT_DOUBLE_EQ(joined.size.volume, 8);
}

TEST(MeshCheckTest, RejectsEmptyMeshForEveryRequirement) {
  const MeshCheck found = check(make_mesh("empty", {}, {}));
  for (const Word<Requirement>& one : words_of(Requirement{}))
    EXPECT_EQ(unmet_reason(one.value, found), "no triangles");
  const MeshCheck points = check(make_mesh("points", {{1, 2, 3}, {1, 2, 3}}, {}));
  EXPECT_EQ(points.topology.unused_vertices, 2U);
  EXPECT_EQ(points.repeated_vertices, 1U);
}

TEST(MeshCheckTest, CountsDegenerateTriangles) {
  const MeshCheck found =
      check(make_mesh("none", {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {{0, 0, 0}, {0, 1, 1}, {0, 1, 2}}));
  EXPECT_EQ(found.topology.repeated_index_triangles, 2U);
  EXPECT_EQ(found.intersections.zero_area_triangles, 3U);
  EXPECT_EQ(found.components.size(), 1U);
  EXPECT_EQ(found.components[0].triangles, 1U);
}

TEST(MeshCheckTest, HandlesHugeAndSubnormalCoordinates) {
  for (const float half : {1e30F, 3e38F, 1e-40F}) {
    const MeshCheck found = check(all_of(centered_cube(half), centered_cube(half / 2, true)));
    EXPECT_EQ(shells(found), (std::vector{Shell::body, Shell::cavity})) << half;
    EXPECT_EQ(found.intersections.pairs + found.intersections.zero_area_triangles, 0U) << half;
  }
}

TEST(MeshCheckTest, CountsFlippedMissingAndNonUnitNormals) {
  const mesh::Mesh mesh = centered_cube(1);
  std::vector<glm::vec3> outward(mesh.positions.begin(), mesh.positions.end());
  for (glm::vec3& normal : outward) normal = glm::normalize(normal);
  const NormalFigures sound = check_normals(mesh, outward, mesh.triangles.span());
  EXPECT_EQ(sound.corners, 36U);
  EXPECT_EQ(sound.against + sound.missing + sound.not_unit, 0U);
  std::size_t corners = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) corners += t[c] == 3 ? 1 : 0;
  }
  outward[3] *= -2.0F;
  const NormalFigures turned = check_normals(mesh, outward, mesh.triangles.span());
  EXPECT_EQ(turned.against, corners);
  EXPECT_EQ(turned.not_unit, corners);
  outward[3] = glm::vec3(std::nanf(""));
  EXPECT_EQ(check_normals(mesh, outward, mesh.triangles.span()).missing, corners);
  Buffer<glm::uvec3> none(mesh.triangles.size());
  std::fill(none.begin(), none.end(), glm::uvec3(kNoNormal));
  EXPECT_EQ(check_normals(mesh, outward, none.span()).missing, 36U);
}

TEST(MeshCheckTest, IsIndependentOfThreads) {
  std::vector<mesh::Mesh> list;
  for (unsigned i = 0; i < 40; ++i) {
    list.push_back(test::sphere(6 + i % 5, false));
    for (glm::vec3& p : list.back().positions) p = p * (1.0F + static_cast<float>(i % 7)) + glm::vec3(i / 7, 0, 0);
    if (i % 9 == 0) leave_out(list.back(), i);
  }
  const mesh::Mesh mesh = together(std::move(list));
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return check(mesh);
  };
  const MeshCheck one = with_threads(1);
  const MeshCheck four = with_threads(4);
  EXPECT_EQ(shells(one), shells(four));
  EXPECT_GT(one.intersections.pairs, 0U);
  EXPECT_EQ(one.intersections.pairs, four.intersections.pairs);
  EXPECT_EQ(one.intersections.examples, four.intersections.examples);
  EXPECT_EQ(one.size.area, four.size.area);
  ASSERT_EQ(one.loops.size(), four.loops.size());
  for (std::size_t i = 0; i < one.loops.size(); ++i) EXPECT_EQ(one.loops[i].length, four.loops[i].length);
  for (std::size_t i = 0; i < one.components.size(); ++i) {
    EXPECT_EQ(one.components[i].volume, four.components[i].volume);
    EXPECT_EQ(one.components[i].enclosing_shells, four.components[i].enclosing_shells);
  }
}

TEST(MeshCheckTest, ObeysCancellationAndMemoryBudget) {
  const mesh::Mesh mesh = test::sphere(60, false);
  const Context cancelled;
  cancelled.cancel();
  const auto ended = check_mesh(mesh, cancelled);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::cancelled);
  for (const std::uint64_t limit : {std::uint64_t{1000}, std::uint64_t{100000}, std::uint64_t{500000}}) {
    const auto refused = check_mesh(mesh, Context(MemoryBudget(limit)));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  }
  const Context counted;
  { const auto found = check_mesh(mesh, counted); }
  EXPECT_EQ(counted.memory().reserved(), 0U);
}

}  // namespace
}  // namespace isoextract::check
