// Compares the topology of every method with oracles that use no mesh. Marching cubes: an oracle that samples the
// trilinear interpolant ever finer (support/trilinear_topology.hpp). Methods that use only the sides of samples: an
// oracle that counts how the samples are connected (support/sample_topology.hpp).
#include <atomic>
#include <numeric>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include "support/fields.hpp"
#include "support/mesh_components.hpp"
#include "support/meshes.hpp"
#include "support/random_trilinear.hpp"
#include "support/sample_topology.hpp"

namespace isoextract::extract {
namespace {

using test::RandomKind;
using test::SurfaceTopology;

// Returns nullopt for methods that also use the values of the samples.
std::optional<test::SampleJoins> sample_joins(Method method) {
  switch (method) {
    case Method::mc: break;
    case Method::mt: return test::joined_by_tetrahedra();
    case Method::voxels:
    case Method::surface_nets: return test::joined_by_faces();
  }
  return std::nullopt;
}

// Spheres and tori with known topology, to check the oracle itself.
TEST(TrilinearTopology, CountsKnownFields) {
  const auto topology = [](const std::vector<glm::ivec3>& inside, double iso) {
    std::vector<float> samples(125, -1.0F);
    for (const glm::ivec3& p : inside) samples[test::detail::random_index(p.x, p.y, p.z)] = 1;
    return test::TrilinearTopology(samples, 5, iso)();
  };
  EXPECT_EQ(topology({}, 0), SurfaceTopology{});
  EXPECT_EQ(topology({{2, 2, 2}}, 0), SurfaceTopology{2});
  EXPECT_EQ(topology({{1, 1, 1}, {3, 3, 3}}, 0), (SurfaceTopology{2, 2}));
  // The saddle across a face diagonal has the value 0, across a body diagonal -0.5.
  EXPECT_EQ(topology({{1, 1, 2}, {2, 2, 2}}, 0.01), (SurfaceTopology{2, 2}));
  EXPECT_EQ(topology({{1, 1, 2}, {2, 2, 2}}, -0.01), SurfaceTopology{2});
  EXPECT_EQ(topology({{1, 1, 1}, {2, 2, 2}}, -0.49), (SurfaceTopology{2, 2}));
  EXPECT_EQ(topology({{1, 1, 1}, {2, 2, 2}}, -0.51), SurfaceTopology{2});
  std::vector<glm::ivec3> ring;
  std::vector<glm::ivec3> shell;
  for (int k = 1; k < 4; ++k) {
    for (int j = 1; j < 4; ++j) {
      for (int i = 1; i < 4; ++i) {
        if (k == 2 && (i != 2 || j != 2)) ring.push_back({i, j, k});
        if (i != 2 || j != 2 || k != 2) shell.push_back({i, j, k});
      }
    }
  }
  EXPECT_EQ(topology(ring, 0), SurfaceTopology{0});
  EXPECT_EQ(topology(shell, 0), (SurfaceTopology{2, 2}));
}

// Shapes with known topology.
TEST(SampleTopology, CountsKnownFields) {
  using test::SurfaceCount;
  const test::SampleJoins faces = test::joined_by_faces();
  const test::SampleJoins tetrahedra = test::joined_by_tetrahedra();
  EXPECT_EQ(faces.shapes.size(), 7U + 4);            // 3 edges, 3 squares, a cube; rings
  EXPECT_EQ(tetrahedra.shapes.size(), 7U + 12 + 6);  // edges, triangles, tetrahedra
  const auto counts = [&](const test::VoxelPattern& pattern) {
    return std::pair(test::count_surface(pattern, faces), test::count_surface(pattern, tetrahedra));
  };
  const auto both = [](int components, int euler) {
    return std::pair(SurfaceCount{components, euler}, SurfaceCount{components, euler});
  };
  const auto apart_or_not = std::pair(SurfaceCount{2, 4}, SurfaceCount{1, 2});
  EXPECT_EQ(counts({{1, 1, 1}, {0}}), both(0, 0));
  EXPECT_EQ(counts({{1, 1, 1}, {1}}), both(1, 2));
  EXPECT_EQ(counts({{2, 2, 2}, {1, 1, 1, 1, 1, 1, 1, 1}}), both(1, 2));
  EXPECT_EQ(counts({{2, 2, 1}, {1, 0, 0, 1}}), apart_or_not);              // on the diagonal with a tetrahedron edge
  EXPECT_EQ(counts({{2, 2, 1}, {0, 1, 1, 0}}), both(2, 4));                // on the other diagonal
  EXPECT_EQ(counts({{2, 2, 2}, {1, 0, 0, 0, 0, 0, 0, 1}}), apart_or_not);  // through the cell
  // Opposite corners outside: a hole along the diagonal that is a tetrahedron edge.
  EXPECT_EQ(counts({{2, 2, 2}, {0, 1, 1, 1, 1, 1, 1, 0}}), std::pair(SurfaceCount{1, 2}, SurfaceCount{1, 0}));
  EXPECT_EQ(counts({{2, 2, 2}, {1, 0, 1, 1, 1, 1, 0, 1}}), both(1, 2));
  test::VoxelPattern ring{{3, 3, 1}, std::vector<std::uint8_t>(9, 1)};
  ring.inside[4] = 0;
  EXPECT_EQ(counts(ring), both(1, 0));
  test::VoxelPattern shell{{3, 3, 3}, std::vector<std::uint8_t>(27, 1)};
  shell.inside[13] = 0;
  EXPECT_EQ(counts(shell), both(2, 4));
}

class ExactTopology : public testing::TestWithParam<std::tuple<RandomKind, Method>> {};

// 3,400 fields of each kind: closed, oriented and manifold, with the topology that the method promises.
TEST_P(ExactTopology, EqualsOracle) {
  constexpr std::uint32_t kFields = 3400;
  const RandomKind kind = std::get<0>(GetParam());
  const ExtractOptions options = test::options_of(std::get<1>(GetParam()), 0);
  const std::optional<test::SampleJoins> joins = sample_joins(options.method);
  std::atomic<unsigned> undecided = 0;
  std::atomic<unsigned> wrong = 0;
  std::atomic<unsigned> unsound = 0;
  std::atomic<unsigned> first_wrong = kFields;
  tbb::parallel_for(0U, kFields, [&](std::uint32_t seed) {
    const std::vector<float> samples = test::random_trilinear(kind, seed);
    const auto extraction = make_cpu_extractor()->extract(test::as_field(samples), options, Context());
    if (!extraction || !mesh::measure_topology(extraction->mesh).is_closed_oriented_manifold() ||
        mesh::measure_size(extraction->mesh).zero_area_triangles != 0) {
      ++unsound;
      return;
    }
    const SurfaceTopology found = test::component_euler_numbers(extraction->mesh);
    bool right = false;
    if (joins) {
      test::VoxelPattern inside{glm::ivec3(test::kRandomSize), {}};
      for (const float sample : samples) inside.inside.push_back(sample > 0 ? 1 : 0);
      const test::SurfaceCount counted{static_cast<int>(found.size()), std::accumulate(found.begin(), found.end(), 0)};
      right = counted == test::count_surface(inside, *joins);
    } else {
      const auto expected = test::true_topology(kind, samples, test::Side::above);
      if (!expected) ++undecided;
      right = !expected || *expected == found;
    }
    if (right) return;
    ++wrong;
    for (unsigned least = first_wrong; seed < least && !first_wrong.compare_exchange_weak(least, seed);) {
    }
  });
  EXPECT_EQ(unsound, 0U);
  EXPECT_EQ(undecided, 0U);
  EXPECT_EQ(wrong, 0U) << "first with seed " << first_wrong;
}

INSTANTIATE_TEST_SUITE_P(Kinds, ExactTopology,
                         testing::Combine(testing::ValuesIn(test::kRandomKinds),
                                          testing::ValuesIn(test::all_methods())),
                         [](const auto& parameter) {
                           std::string name(test::kind_name(std::get<0>(parameter.param)));
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name + "_by_" + test::identifier_of(std::get<1>(parameter.param));
                         });

}  // namespace
}  // namespace isoextract::extract
