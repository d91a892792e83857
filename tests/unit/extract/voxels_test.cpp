// Exact properties of the surfaces of any set of voxels.
#include <gtest/gtest.h>

#include "extract/voxels.hpp"
#include "support/voxel_patterns.hpp"

namespace isoextract::extract {
namespace {

using test::VoxelPattern;

mesh::Mesh mesh_of(const VoxelPattern& pattern, VoxelFaces faces = VoxelFaces::merged) {
  return test::extract(test::field_of(pattern), test::voxel_options(faces)).mesh;
}

void expect_right(const VoxelPattern& pattern) {
  for (const VoxelFaces faces : {VoxelFaces::merged, VoxelFaces::plain}) {
    SCOPED_TRACE(word_of(faces));
    test::expect_surface_of(pattern, mesh_of(pattern, faces));
  }
}

TEST(Voxels, MeshesAllPatternsOfEightVoxels) {
  for (unsigned bits = 1; bits < 256; ++bits) {
    SCOPED_TRACE(bits);
    VoxelPattern pattern{{2, 2, 2}, {}};
    for (unsigned n = 0; n < 8; ++n) pattern.inside.push_back(bits >> n & 1);
    expect_right(pattern);
  }
}

TEST(Voxels, MeshesRandomPatterns) {
  for (unsigned seed = 0; seed < 2000; ++seed) {
    SCOPED_TRACE(seed);
    const int side = 3 + static_cast<int>(seed % 6);
    const VoxelPattern pattern = test::random_pattern({side, 3 + static_cast<int>(seed / 6 % 5), side}, seed,
                                                      10 + static_cast<int>(seed * 7 % 85));
    if (pattern.count() > 0) expect_right(pattern);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(Voxels, MeshesAcrossChunks) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE(seed);
    expect_right(test::random_pattern({70, 17, 19}, seed, 20 + 20 * static_cast<int>(seed)));
  }
}

TEST(Voxels, MakesABoxOfOneSample) {
  const VoxelPattern pattern{{1, 1, 1}, {1}};
  const mesh::Mesh mesh = mesh_of(pattern);
  EXPECT_EQ(mesh.positions.size(), 8U);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  test::expect_surface_of(pattern, mesh);
  const mesh::Bounds bounds = mesh::measure_bounds(mesh);
  EXPECT_EQ(bounds.min, glm::dvec3(-0.5));
  EXPECT_EQ(bounds.max, glm::dvec3(0.5));
}

TEST(Voxels, MergesBlockToTwelveTriangles) {
  const VoxelPattern pattern = test::random_pattern({130, 20, 30}, 0, 100);
  EXPECT_EQ(mesh_of(pattern).triangles.size(), 12U);
  EXPECT_EQ(mesh_of(pattern).positions.size(), 8U);
  EXPECT_EQ(mesh_of(pattern, VoxelFaces::plain).triangles.size(), 2U * 2 * (130 * 20 + 20 * 30 + 30 * 130));
}

// Two pillars between two plates touch along an edge, and the plates connect them at both ends. The edge has a vertex
// in its middle for each pillar.
TEST(Voxels, SplitsEdgeBetweenTouchingVoxels) {
  VoxelPattern pattern{{2, 2, 3}, {1, 1, 1, 1, 1, 0, 0, 1, 1, 1, 1, 1}};
  for (const VoxelFaces faces : {VoxelFaces::merged, VoxelFaces::plain}) {
    const mesh::Mesh mesh = mesh_of(pattern, faces);
    test::expect_surface_of(pattern, mesh);
    const auto in_the_middle = [](const glm::vec3& p) { return p == glm::vec3(0.5F, 0.5F, 1); };
    EXPECT_EQ(std::count_if(mesh.positions.begin(), mesh.positions.end(), in_the_middle), 2);
  }
}

TEST(Voxels, DoublesVerticesAtContacts) {
  const auto vertices = [](const VoxelPattern& pattern) { return mesh_of(pattern).positions.size(); };
  EXPECT_EQ(vertices({{2, 1, 1}, {1, 1}}), 8U);                     // share a face: one box
  EXPECT_EQ(vertices({{2, 2, 1}, {1, 0, 0, 1}}), 16U);              // along an edge
  EXPECT_EQ(vertices({{2, 2, 2}, {1, 0, 0, 0, 0, 0, 0, 1}}), 16U);  // at a corner
}

// Unsplit rectangles have the same surface and fewer triangles.
TEST(Voxels, RectanglesUseFewerTriangles) {
  const VoxelPattern pattern = test::random_pattern({20, 20, 20}, 3, 70);
  const mesh::Mesh fewest = mesh_of(pattern, VoxelFaces::rectangles);
  const mesh::Mesh merged = mesh_of(pattern);
  const mesh::Mesh plain = mesh_of(pattern, VoxelFaces::plain);
  EXPECT_LT(fewest.triangles.size(), merged.triangles.size());
  EXPECT_LT(merged.triangles.size(), plain.triangles.size());
  EXPECT_EQ(test::areas_by_direction(fewest), test::areas_by_direction(plain));
  EXPECT_EQ(test::exact_volume(fewest), static_cast<double>(pattern.count()));
  EXPECT_EQ(mesh::measure_topology(fewest).unused_vertices, 0U);
  EXPECT_EQ(mesh::measure_size(fewest).zero_area_triangles, 0U);
}

TEST(Voxels, ClosesRegion) {
  const VoxelPattern pattern = test::random_pattern({70, 12, 12}, 6, 60);
  ExtractOptions options = test::voxel_options();
  options.region = field::IndexBox{{3, 2, 5}, {66, 9, 9}};
  VoxelPattern part = pattern;
  part.for_each([&](const glm::ivec3& p) {
    const bool kept =
        glm::all(glm::greaterThanEqual(p, options.region->min)) && glm::all(glm::lessThanEqual(p, options.region->max));
    if (!kept) part.inside[static_cast<std::size_t>(p.x + 70 * (p.y + 12 * p.z))] = 0;
  });
  test::expect_surface_of(part, test::extract(test::field_of(pattern), options).mesh);
}

}  // namespace
}  // namespace isoextract::extract
