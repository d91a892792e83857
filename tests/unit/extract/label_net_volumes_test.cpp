// Surface nets keep the volumes of voxels, and relaxing changes no side.
#include <gtest/gtest.h>

#include <random>
#include <span>
#include <vector>

#include "mesh/components.hpp"
#include "support/voxel_patterns.hpp"
#include "unit/extract/label_nets.hpp"

namespace isoextract::extract {
namespace {

// Returns the volume of each component, with the sign of a cavity.
std::vector<double> volumes_of(const mesh::Mesh& mesh, std::span<const glm::vec3> positions) {
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  std::vector<double> volumes(components.count());
  for (const glm::uvec3& t : mesh.triangles) {
    volumes[components.of_vertex(t.x)] +=
        glm::dot(glm::dvec3(positions[t.x]), glm::cross(glm::dvec3(positions[t.y]), glm::dvec3(positions[t.z]))) / 6;
  }
  return volumes;
}

// Expects that each component encloses as much as its voxels.
void expect_volumes_of_voxels(const field::ScalarField& field, std::uint64_t rounds, const ExtractOptions& like = {},
                              double tolerance = 0.001) {
  ExtractOptions options = like;
  options.method = Method::surface_nets;
  options.relaxations = rounds;
  const Labels moved = nets_of(field, options);
  options.relaxations = 0;
  const Labels still = nets_of(field, options);
  for (const auto& [label, mesh] : moved) {
    SCOPED_TRACE(label);
    const mesh::Mesh& voxels = still.at(label);
    const std::vector<double> after = volumes_of(mesh, mesh.positions.span());
    const std::vector<double> before = volumes_of(voxels, voxels.positions.span());
    ASSERT_EQ(after.size(), before.size());
    for (std::size_t c = 0; c < after.size(); ++c) EXPECT_NEAR(after[c] / before[c], 1, tolerance) << before[c];
  }
}

TEST(LabelNetVolumes, KeepsVolumesOfThinAndSmallParts) {
  for (const std::uint64_t rounds : {1U, 15U, 100U}) {
    SCOPED_TRACE(rounds);
    const auto check = [&](const char* what, const auto& inside, const ExtractOptions& like = {}) {
      SCOPED_TRACE(what);
      expect_volumes_of_voxels(test::dense_field<std::uint8_t>({24, 24, 24}, inside), rounds, like);
    };
    const auto in_box = [](int x, int y, int z, const glm::ivec3& low, const glm::ivec3& high) {
      return x >= low.x && y >= low.y && z >= low.z && x < high.x && y < high.y && z < high.z;
    };
    const auto box = [&](const glm::ivec3& size) {
      return [=](int x, int y, int z) { return in_box(x, y, z, glm::ivec3(7), 7 + size) ? 1 : 0; };
    };
    check("one voxel", box({1, 1, 1}));
    check("cube of eight voxels", box({2, 2, 2}));
    check("bar", box({1, 1, 15}));
    check("sheet", box({12, 12, 1}));
    const auto oblique = [](int x, int y, int z) {
      return std::abs(0.3 * x + 0.5 * y + 0.81 * z - 19.2) < 0.9 ? 1 : 0;
    };
    check("oblique sheet up to the data boundary", oblique);
    check("cavity", [&](int x, int y, int z) {
      return in_box(x, y, z, glm::ivec3(3), glm::ivec3(20)) && !in_box(x, y, z, glm::ivec3(9), glm::ivec3(11)) ? 1 : 0;
    });
    check("label in a label", [&](int x, int y, int z) {
      return in_box(x, y, z, glm::ivec3(9), glm::ivec3(11))   ? 2
             : in_box(x, y, z, glm::ivec3(3), glm::ivec3(20)) ? 1
                                                              : 0;
    });
    ExtractOptions sheared;
    sheared.output_from_index.linear = {{0.5, 0, 0}, {0.25, 2, 0}, {0, -1, -4}};
    check("sheared cube", box({3, 3, 3}), sheared);
    check("sheared oblique sheet", oblique, sheared);
  }
}

// Labels that fill the data like cells: each has its own volume although all faces are shared.
TEST(LabelNetVolumes, KeepsVolumesOfNeighbors) {
  std::mt19937 engine(5);
  std::vector<glm::dvec3> seeds(40);
  for (glm::dvec3& seed : seeds) seed = {engine() % 40, engine() % 40, engine() % 40};
  const auto nearest = [&](int x, int y, int z) {
    const auto far = [&](const glm::dvec3& seed) { return glm::distance(seed, glm::dvec3(x, y, z)); };
    return 1 + static_cast<int>(std::ranges::min_element(seeds, {}, far) - seeds.begin());
  };
  expect_volumes_of_voxels(test::dense_field<std::uint8_t>({40, 40, 40}, nearest), kDefaultRelaxations, {}, 0.003);
}

// Relaxing changes no side: in noise of any density, the components and the sides that they face stay, and each
// triangle has a voxel of its label behind it and another one before it.
TEST(LabelNetVolumes, KeepsLabelsOnTheirSidesOfTriangles) {
  const glm::ivec3 dims{17, 12, 13};
  for (const int percent : {5, 20, 35, 50, 70, 90, 97}) {
    std::mt19937 engine(static_cast<unsigned>(percent));
    std::vector<int> labels(17 * 12 * 13);
    for (int& label : labels) {
      label = static_cast<int>(engine() % 100) < percent ? 1 + static_cast<int>(engine() % 4 == 0) : 0;
    }
    const auto label_at = [&](const glm::ivec3& p) {
      const bool there = glm::all(glm::greaterThanEqual(p, glm::ivec3(0))) && glm::all(glm::lessThan(p, dims));
      return there ? labels[static_cast<std::size_t>(p.x + dims.x * (p.y + dims.y * p.z))] : 0;
    };
    const field::ScalarField field = test::dense_field<std::uint8_t>(dims, [&](int x, int y, int z) {
      return label_at({x, y, z});
    });
    const Labels still = nets_of(field, net_options(0));
    for (const std::uint64_t rounds : {0U, 1U, 10U, 100U, 200U}) {
      SCOPED_TRACE(testing::Message() << percent << " % in " << rounds << " rounds");
      for (const auto& [label, mesh] : nets_of(field, net_options(rounds))) {
        const std::span<const glm::vec3> corners = still.at(label).positions.span();
        ASSERT_EQ(mesh.positions.size(), corners.size());
        ASSERT_EQ(mesh.triangles.size(), still.at(label).triangles.size());
        test::expect_sound(mesh, true);
        for (const glm::uvec3& t : mesh.triangles) {
          const glm::dvec3 a(corners[t.x]);
          const glm::dvec3 b(corners[t.y]);
          const glm::dvec3 c(corners[t.z]);
          const glm::dvec3 normal = glm::cross(b - a, c - a);
          ASSERT_GT(glm::length(normal), 0);
          const glm::dvec3 half = 0.5 * glm::normalize(normal);
          const glm::dvec3 middle = (a + b + c) / 3.0;
          ASSERT_EQ(label_at(glm::ivec3(glm::round(middle - half))), label);
          ASSERT_NE(label_at(glm::ivec3(glm::round(middle + half))), label);
        }
        const std::vector<double> before = volumes_of(mesh, corners);
        const std::vector<double> after = volumes_of(mesh, mesh.positions.span());
        for (std::size_t s = 0; s < after.size(); ++s) EXPECT_GT(after[s] / before[s], 0.5) << before[s];
      }
    }
  }
}

}  // namespace
}  // namespace isoextract::extract
