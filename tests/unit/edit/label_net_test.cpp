// Labels simplified together: they keep common faces, their topology, and the distance.
#include "edit/label_net.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "accuracy/mesh_distance.hpp"
#include "edit/detail/edge_collapse.hpp"
#include "extract/voxels.hpp"
#include "support/edge_collapses.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::edit {
namespace {

// Three strips that meet in a spine along x, the leaves of a book. Each is a sheet.
struct Book {
  explicit Book(std::uint32_t steps, double bend = 0) : length(steps) {
    for (std::uint32_t i = 0; i <= steps; ++i) positions.emplace_back(i, (i % 2 == 0 ? 1 : -1) * bend, 0);
    for (std::uint32_t leaf = 0; leaf < 3; ++leaf) {
      const double angle = 2 * std::numbers::pi / 3 * leaf;
      std::vector<std::uint32_t> row(steps + 1);
      for (std::uint32_t i = 0; i <= steps; ++i) row[i] = i;
      for (int out = 1; out <= 3; ++out) {
        std::vector<std::uint32_t> next;
        for (std::uint32_t i = 0; i <= steps; ++i) {
          next.push_back(static_cast<std::uint32_t>(positions.size()));
          positions.emplace_back(i, out * std::cos(angle), out * std::sin(angle));
        }
        for (std::uint32_t i = 0; i < steps; ++i) {
          triangles.insert(triangles.end(), {{row[i], row[i + 1], next[i]}, {row[i + 1], next[i + 1], next[i]}});
          sheets.insert(sheets.end(), {leaf, leaf});
        }
        row = next;
      }
    }
  }

  // Collapses edges of all triangles as one patch, and returns what is left.
  std::vector<glm::uvec3> collapsed(double distance, const std::vector<VertexRole>& roles = {}) const {
    CollapseState state(positions, positions, triangles, {sheets, 3, roles});
    return test::collapse_and_undo(state, std::vector<char>(positions.size(), 0), distance);
  }

  std::uint32_t length;
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<std::uint32_t> sheets;
};

// Returns the edges with three triangles.
std::set<std::pair<std::uint32_t, std::uint32_t>> spine_of(const std::vector<glm::uvec3>& triangles) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const glm::uvec3& t : triangles) {
    for (int c = 0; c < 3; ++c) ++edges[std::minmax(t[c], t[(c + 1) % 3])];
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> spine;
  for (const auto& [edge, count] : edges) {
    EXPECT_LE(count, 3);
    if (count == 3) spine.insert(edge);
  }
  return spine;
}

TEST(SheetCollapse, ReducesAStraightSpineToOneEdge) {
  const Book book(12);
  const auto left = book.collapsed(1e-4);
  EXPECT_LE(left.size(), 9U);  // of 216
  EXPECT_EQ(spine_of(left), (std::set<std::pair<std::uint32_t, std::uint32_t>>{{0, 12}}));
}

TEST(SheetCollapse, KeepsVerticesOfABentSpine) {
  const Book book(12, 0.1);
  const auto spine = spine_of(book.collapsed(0.01));
  EXPECT_EQ(spine.size(), 12U);
  for (std::uint32_t i = 0; i < 12; ++i) EXPECT_TRUE(spine.contains({i, i + 1}));
}

// Whatever the distance, the spine is a path from one end to the other: no vertex of it moves into a leaf.
TEST(SheetCollapse, KeepsTheSpineAPathBetweenItsEnds) {
  for (const double distance : {0.05, 0.3, 1.0, 10.0}) {
    for (const double bend : {0.0, 0.1, 0.3}) {
      const Book book(17, bend);
      const auto spine = spine_of(book.collapsed(distance));
      std::uint32_t at = 0;
      for (const auto& [from, to] : spine) {
        EXPECT_EQ(from, at);
        at = to;
      }
      EXPECT_EQ(at, book.length);
    }
  }
}

TEST(SheetCollapse, KeepsVerticesMarkedAsKept) {
  const Book book(12);
  std::vector<VertexRole> roles(book.positions.size(), VertexRole::free);
  roles[5] = VertexRole::kept;
  EXPECT_EQ(spine_of(book.collapsed(1e-4, roles)),
            (std::set<std::pair<std::uint32_t, std::uint32_t>>{{0, 5}, {5, 12}}));
}

TEST(SheetCollapse, KeepsOneTouchingVertexPerCurve) {
  const Book book(12);
  std::vector<VertexRole> roles(book.positions.size(), VertexRole::free);
  for (std::uint32_t i = 1; i < 12; ++i) roles[i] = VertexRole::touching;
  EXPECT_EQ(spine_of(book.collapsed(1e-4, roles)).size(), 2U);
}

using Meshes = std::vector<mesh::Mesh>;

Meshes meshes_of(const field::ScalarField& field, extract::Method method = extract::Method::surface_nets) {
  extract::ExtractOptions options;
  options.method = method;
  options.voxel_faces = extract::VoxelFaces::plain;
  const auto found = extract::LabelVoxels::find(field, options, {true, {}}, Context());
  EXPECT_TRUE(found) << found.error().message;
  Meshes meshes;
  for (const std::int64_t label : found->labels()) {
    meshes.push_back(std::move(found->extract(field, label, options, Context())->mesh));
  }
  return meshes;
}

field::ScalarField cells(const glm::ivec3& dims, int count, unsigned seed) {
  std::mt19937 engine(seed);
  const auto below = [&](int extent) {
    return static_cast<float>(engine() % 1000) * 1e-3F * static_cast<float>(extent);
  };
  std::vector<glm::vec3> points(static_cast<std::size_t>(count));
  for (glm::vec3& point : points) {
    for (int axis = 0; axis < 3; ++axis) point[axis] = below(dims[axis]);
  }
  return test::dense_field<std::uint8_t>(dims, [&](int x, int y, int z) {
    const auto distance = [&](const glm::vec3& p) { return glm::distance(p, glm::vec3(x, y, z)); };
    return 1 + (std::ranges::min_element(points, {}, distance) - points.begin());
  });
}

std::vector<mesh::Mesh*> pointers(Meshes& meshes) {
  std::vector<mesh::Mesh*> list;
  for (mesh::Mesh& mesh : meshes) list.push_back(&mesh);
  return list;
}

using Corners = std::array<std::array<float, 3>, 3>;

Corners corners_of(const mesh::Mesh& mesh, const glm::uvec3& t) {
  Corners corners;
  for (std::size_t c = 0; c < 3; ++c) {
    const glm::vec3& p = mesh.positions[t[static_cast<int>(c)]];
    corners[c] = {p.x, p.y, p.z};
  }
  std::ranges::rotate(corners, std::ranges::min_element(corners));
  return corners;
}

// The number of triangles that two meshes have in common, with opposite winding, and the triangles of the net.
struct CommonFaces {
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> common;
  std::size_t net = 0;
};

CommonFaces common_faces_of(const Meshes& meshes) {
  std::map<Corners, std::size_t> owners;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    for (const glm::uvec3& t : meshes[m].triangles) {
      EXPECT_TRUE(owners.emplace(corners_of(meshes[m], t), m).second) << "two triangles at one place";
    }
  }
  CommonFaces faces;
  std::size_t twice = 0;
  for (const auto& [corners, owner] : owners) {
    const auto other = owners.find({corners[0], corners[2], corners[1]});
    if (other == owners.end()) {
      ++faces.net;
      continue;
    }
    EXPECT_NE(other->second, owner);
    ++twice;
    if (owner < other->second) ++faces.common[{owner, other->second}];
  }
  faces.net += twice / 2;
  return faces;
}

SimplifyFigures expect_simplified(Meshes& meshes, const SimplifyOptions& options) {
  Meshes before;
  for (const mesh::Mesh& mesh : meshes) before.push_back(copy(mesh));
  const CommonFaces were = common_faces_of(before);
  const auto list = pointers(meshes);
  const auto net = LabelNet::join(list, Context());
  EXPECT_TRUE(net) << net.error().message;
  EXPECT_EQ(net->triangles(), were.net);
  const auto figures = net->simplify(list, options, Context());
  EXPECT_TRUE(figures) << figures.error().message;
  const CommonFaces are = common_faces_of(meshes);
  EXPECT_EQ(figures->triangles_before, were.net);
  EXPECT_EQ(figures->triangles_after, are.net);
  EXPECT_LE(figures->distance_upper, options.max_distance);
  std::vector<std::pair<std::size_t, std::size_t>> pairs[2];
  for (const auto& [pair, count] : were.common) pairs[0].push_back(pair);
  for (const auto& [pair, count] : are.common) pairs[1].push_back(pair);
  EXPECT_EQ(pairs[0], pairs[1]);
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    test::expect_sound(meshes[m], true);
    const mesh::Topology was = mesh::measure_topology(before[m]);
    const mesh::Topology is = mesh::measure_topology(meshes[m]);
    EXPECT_EQ(is.components, was.components);
    EXPECT_EQ(is.euler, was.euler);
    accuracy::DistanceOptions measure;
    measure.samples = 0;
    const auto distance = accuracy::measure_distance(before[m], meshes[m], measure, Context());
    EXPECT_LE(distance->hausdorff_lower, figures->distance_upper + distance->resolution);
  }
  return *figures;
}

TEST(LabelNet, KeepsCommonFacesOfCellsAtEveryDistance) {
  for (const double distance : {0.05, 0.3, 1.0}) {
    Meshes meshes = meshes_of(cells({24, 20, 22}, 9, 1));
    const auto figures = expect_simplified(meshes, {.max_distance = distance, .patch_size = 8});
    EXPECT_LT(figures.triangles_after, figures.triangles_before);
  }
}

// A collapse of a curve removes a triangle of each of its sheets.
TEST(LabelNet, CountsCommonTrianglesOnceTowardATarget) {
  Meshes meshes = meshes_of(cells({24, 20, 22}, 5, 2));
  const std::uint64_t target = common_faces_of(meshes).net / 10;
  const auto figures = expect_simplified(
      meshes, {.max_distance = std::numeric_limits<double>::infinity(), .triangles = target, .patch_size = 8});
  EXPECT_LE(figures.triangles_after, target);
  EXPECT_GE(figures.triangles_after + 8, target);
}

// In noise labels touch themselves and others along edges and in corners.
TEST(LabelNet, KeepsTopologyOfNoise) {
  for (const extract::Method method : {extract::Method::surface_nets, extract::Method::voxels}) {
    for (unsigned seed = 0; seed < 4; ++seed) {
      Meshes meshes = meshes_of(test::random_field<std::uint8_t>({8, 9, 7}, seed, 3), method);
      expect_simplified(meshes, {.max_distance = seed % 2 == 0 ? 0.3 : 2.0, .patch_size = 4});
    }
  }
}

TEST(LabelNet, KeepsTheDistanceInStretchedVoxels) {
  Meshes meshes = meshes_of(cells({16, 16, 16}, 5, 3));
  SimplifyOptions options{.max_distance = 0.2, .patch_size = 8};
  options.to_metric[2][2] = 3;
  const auto list = pointers(meshes);
  const auto figures = LabelNet::join(list, Context())->simplify(list, options, Context());
  ASSERT_TRUE(figures);
  EXPECT_LE(figures->distance_upper, 0.2);
  EXPECT_GT(common_faces_of(meshes).common.size(), 3U);
}

TEST(LabelNet, SimplifiesOneMeshLikeSimplifyMesh) {
  Meshes meshes = meshes_of(test::dense_field<std::uint8_t>(
      {16, 16, 16}, [](int x, int y, int z) { return glm::length(glm::vec3(x, y, z) - 8.F) < 6 ? 1 : 0; }));
  ASSERT_EQ(meshes.size(), 1U);
  const SimplifyOptions options{.max_distance = 0.2, .patch_size = 8};
  const auto alone = simplify_mesh(copy(meshes[0]), options, Context());
  const auto list = pointers(meshes);
  const auto figures = LabelNet::join(list, Context())->simplify(list, options, Context());
  ASSERT_TRUE(alone && figures);
  EXPECT_EQ(test::triangle_set(meshes[0]), test::triangle_set(alone->mesh));
}

TEST(LabelNet, FailsIfMemoryIsShort) {
  Meshes meshes = meshes_of(cells({12, 12, 12}, 4, 4));
  const auto list = pointers(meshes);
  const auto refused = LabelNet::join(list, Context(MemoryBudget(1000)));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(LabelNet::join({}, Context())->triangles(), 0U);
}

}  // namespace
}  // namespace isoextract::edit
