// Marching cubes against an oracle that counts voxels (support/trilinear_topology.hpp).
#include <atomic>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include "support/fields.hpp"
#include "support/mesh_components.hpp"
#include "support/meshes.hpp"
#include "support/random_trilinear.hpp"

namespace isoextract::extract {
namespace {

using test::RandomKind;
using test::SurfaceTopology;

ExtractOptions at_zero(Method method) {
  ExtractOptions options;
  options.method = method;
  return options;
}

// Spheres and tori that everybody can count, so that the oracle is not believed blindly.
TEST(TrilinearTopology, CountsWhatIsKnown) {
  const auto topology = [](const std::vector<glm::ivec3>& inside, double iso) {
    std::vector<float> samples(125, -1.0F);
    for (const glm::ivec3& p : inside) samples[test::detail::random_index(p.x, p.y, p.z)] = 1;
    return test::TrilinearTopology(samples, 5, iso)();
  };
  EXPECT_EQ(topology({}, 0), SurfaceTopology{});
  EXPECT_EQ(topology({{2, 2, 2}}, 0), SurfaceTopology{2});
  EXPECT_EQ(topology({{1, 1, 1}, {3, 3, 3}}, 0), (SurfaceTopology{2, 2}));
  // Across a face diagonal the saddle has the value 0; across a body diagonal it is -0.5.
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

class ExactTopology : public testing::TestWithParam<RandomKind> {};

// 3,400 fields of each kind. Closed, oriented and manifold by both methods; the topology of the trilinear interpolant
// by marching cubes.
TEST_P(ExactTopology, IsThatOfTheTrilinearInterpolant) {
  constexpr std::uint32_t kFields = 3400;
  std::atomic<unsigned> undecided = 0;
  std::atomic<unsigned> wrong = 0;
  std::atomic<unsigned> unsound = 0;
  std::atomic<unsigned> first_wrong = kFields;
  tbb::parallel_for(0U, kFields, [&](std::uint32_t seed) {
    const std::vector<float> samples = test::random_trilinear(GetParam(), seed);
    const field::ScalarField field = test::as_field(samples);
    for (const Method method : {Method::mc, Method::mt}) {
      const auto extraction = make_cpu_extractor()->extract(field, at_zero(method), Context());
      if (!extraction || !mesh::measure_topology(extraction->mesh).is_closed_oriented_manifold() ||
          mesh::measure_size(extraction->mesh).zero_area_triangles != 0) {
        ++unsound;
        continue;
      }
      if (method == Method::mt) continue;
      const auto expected = test::true_topology(GetParam(), samples, test::Side::above);
      if (!expected) {
        ++undecided;
      } else if (*expected != test::component_euler_numbers(extraction->mesh)) {
        ++wrong;
        for (unsigned least = first_wrong; seed < least && !first_wrong.compare_exchange_weak(least, seed);) {
        }
      }
    }
  });
  EXPECT_EQ(unsound, 0U);
  EXPECT_EQ(undecided, 0U);
  EXPECT_EQ(wrong, 0U) << "first with seed " << first_wrong;
}

INSTANTIATE_TEST_SUITE_P(Kinds, ExactTopology, testing::ValuesIn(test::kRandomKinds), [](const auto& parameter) {
  std::string name(test::kind_name(parameter.param));
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

}  // namespace
}  // namespace isoextract::extract
