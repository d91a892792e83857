// NanPolicy::hole: the mesh is that of the same field without NaN, minus the cells that touch a NaN sample.
#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

constexpr glm::ivec3 kDims(24, 16, 16);

// Random values, some of them marked as missing.
struct Sampled {
  std::vector<float> values;
  std::vector<bool> missing;

  Sampled(unsigned seed, double share) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<float> value(-1, 1);
    std::bernoulli_distribution lost(share);
    for (int n = 0; n < kDims.x * kDims.y * kDims.z; ++n) {
      values.push_back(value(engine));
      missing.push_back(lost(engine));
    }
  }

  static std::size_t at(const glm::ivec3& p) { return static_cast<std::size_t>(p.x + kDims.x * (p.y + kDims.y * p.z)); }
  [[nodiscard]] bool cell_misses(const glm::ivec3& cell) const {
    for (int c = 0; c < 8; ++c) {
      if (missing[at(cell + glm::ivec3(c & 1, c >> 1 & 1, c >> 2 & 1))]) return true;
    }
    return false;
  }
  // Returns whether a corner is present and inside.
  [[nodiscard]] bool cell_has_inside(const glm::ivec3& cell) const {
    for (int c = 0; c < 8; ++c) {
      const std::size_t corner = at(cell + glm::ivec3(c & 1, c >> 1 & 1, c >> 2 & 1));
      if (!missing[corner] && values[corner] > 0) return true;
    }
    return false;
  }
  [[nodiscard]] field::ScalarField field(bool with_missing) const {
    return test::dense_field<float>(kDims, [&](int i, int j, int k) {
      const std::size_t n = at({i, j, k});
      return with_missing && missing[n] ? std::numeric_limits<float>::quiet_NaN() : values[n];
    });
  }
};

using Triangle = std::array<test::Point, 3>;

// Calls f(cell) for all cells that a triangle may belong to: several if it lies in a face between them.
template <class F>
void for_each_cell_of(const Triangle& triangle, const F& f) {
  glm::dvec3 low(std::numeric_limits<double>::infinity());
  glm::dvec3 high(-std::numeric_limits<double>::infinity());
  for (const auto& [x, y, z] : triangle) {
    low = glm::min(low, glm::dvec3(x, y, z));
    high = glm::max(high, glm::dvec3(x, y, z));
  }
  const glm::ivec3 first = glm::max(glm::ivec3(glm::ceil(high)) - 1, glm::ivec3(0));
  const glm::ivec3 last = glm::min(glm::ivec3(glm::floor(low)), kDims - 2);
  for (int k = first.z; k <= last.z; ++k) {
    for (int j = first.y; j <= last.y; ++j) {
      for (int i = first.x; i <= last.x; ++i) f(glm::ivec3(i, j, k));
    }
  }
}

class NanHole : public testing::TestWithParam<Method> {
 protected:
  [[nodiscard]] ExtractOptions options() const {
    ExtractOptions o;
    o.method = GetParam();
    o.nan = NanPolicy::hole;
    return o;
  }
};

INSTANTIATE_TEST_SUITE_P(Methods, NanHole, testing::ValuesIn(test::methods_without(&MethodTraits::always_closed)),
                         test::method_name);

TEST_P(NanHole, LeavesOutOnlyCellsAtNan) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const Sampled sampled(seed, seed < 3 ? 0.02 : 0.2);
    const Extraction holed = test::extract(sampled.field(true), options());
    test::expect_sound(holed.mesh, false);
    const auto all = test::triangle_set(test::extract(sampled.field(false), options()).mesh);
    const auto kept = test::triangle_set(holed.mesh);
    ASSERT_TRUE(std::includes(all.begin(), all.end(), kept.begin(), kept.end()));
    EXPECT_LT(kept.size(), all.size());
    std::vector<Triangle> lost;
    std::set_difference(all.begin(), all.end(), kept.begin(), kept.end(), std::back_inserter(lost));
    const auto any_cell = [&](const Triangle& triangle, bool misses) {
      bool found = false;
      for_each_cell_of(triangle, [&](const glm::ivec3& cell) { found |= sampled.cell_misses(cell) == misses; });
      return found;
    };
    for (const Triangle& triangle : kept) EXPECT_TRUE(any_cell(triangle, false));
    for (const Triangle& triangle : lost) EXPECT_TRUE(any_cell(triangle, true));

    std::uint64_t cells = 0;
    for (int k = 0; k + 1 < kDims.z; ++k) {
      for (int j = 0; j + 1 < kDims.y; ++j) {
        for (int i = 0; i + 1 < kDims.x; ++i) {
          cells += sampled.cell_misses({i, j, k}) && sampled.cell_has_inside({i, j, k}) ? 1 : 0;
        }
      }
    }
    EXPECT_EQ(holed.stats.hole_cells, cells);
    EXPECT_EQ(holed.stats.nan_samples,
              static_cast<std::uint64_t>(std::count(sampled.missing.begin(), sampled.missing.end(), true)));
  }
}

TEST_P(NanHole, LeavesBoundaryEdgesAroundHoleCells) {
  const field::ScalarField field = test::dense_field<double>({10, 10, 10}, [](int i, int j, int k) {
    return i == 5 && j == 5 && k == 4 ? std::numeric_limits<double>::quiet_NaN() : k;
  });
  ExtractOptions o = options();
  o.iso = 4.5;
  const Extraction result = test::extract(field, o);
  test::expect_sound(result.mesh, false);
  // 2x2 cells have eight boundary sides. A side is one edge, or two if tetrahedra divide the cell faces.
  const bool polygons = test::traits_of(GetParam()).axis_edges_only;
  const std::uint64_t edges_a_side = polygons ? 1 : 2;
  EXPECT_EQ(mesh::measure_topology(result.mesh).open_edges, edges_a_side * (4 * 9 + 8));
  EXPECT_EQ(result.stats.hole_cells, 4U) << "the four cells below are outside altogether";
  EXPECT_EQ(result.mesh.triangles.size(), (polygons ? 2U : 8U) * (9 * 9 - 4));
}

TEST_P(NanHole, SparseEqualsDense) {
  const Sampled sampled(7, 0.05);
  const field::ScalarField field = sampled.field(true);
  const Extraction dense = test::extract(field, options());
  const Extraction sparse = test::extract(test::sparse_copy<float>(field, -1), options());
  test::expect_sound(sparse.mesh, false);
  EXPECT_EQ(sparse.stats.nan_samples, dense.stats.nan_samples);
  // The sparse field continues beyond the samples, where it is outside.
  const auto all = test::triangle_set(sparse.mesh);
  const auto kept = test::triangle_set(dense.mesh);
  EXPECT_TRUE(std::includes(all.begin(), all.end(), kept.begin(), kept.end()));
  ExtractOptions within = options();
  within.region = field::IndexBox{glm::ivec3(0), kDims - 1};
  const Extraction same = test::extract(test::sparse_copy<float>(field, -1), within);
  EXPECT_EQ(test::triangle_set(same.mesh), kept);
  EXPECT_EQ(same.stats.hole_cells, dense.stats.hole_cells);
}

TEST_P(NanHole, DoesNotDependOnThreads) {
  const field::ScalarField field = Sampled(3, 0.1).field(true);
  ExtractOptions o = options();
  o.cap = true;
  o.smooth_normals = true;
  std::optional<Extraction> first;
  for (const std::size_t threads : {1U, 4U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    Extraction result = test::extract(field, o);
    if (first) {
      EXPECT_TRUE(std::ranges::equal(first->mesh.positions, result.mesh.positions));
      EXPECT_TRUE(std::ranges::equal(first->mesh.normals, result.mesh.normals));
      EXPECT_TRUE(std::ranges::equal(first->mesh.triangles, result.mesh.triangles));
    }
    first = std::move(result);
  }
}

TEST_P(NanHole, CapsLeaveOutSquaresAtNan) {
  for (const glm::ivec3 nan : {glm::ivec3(0, 4, 4), glm::ivec3(0, 0, 0), glm::ivec3(4, 4, 4)}) {
    const field::ScalarField field = test::dense_field<float>({9, 9, 9}, [&](int i, int j, int k) {
      return glm::ivec3(i, j, k) == nan ? std::numeric_limits<float>::quiet_NaN() : 1.0F;
    });
    ExtractOptions o = options();
    o.cap = true;
    const Extraction result = test::extract(field, o);
    test::expect_sound(result.mesh, false);
    const int boundary_faces =
        static_cast<int>(nan.x == 0) + static_cast<int>(nan.y == 0) + static_cast<int>(nan.z == 0);
    // Four squares are left out around a sample in a face, three at a corner, none for a sample in the interior.
    const std::uint64_t squares = boundary_faces == 1 ? 4 : static_cast<std::uint64_t>(boundary_faces);
    EXPECT_EQ(result.mesh.triangles.size(), 2 * (6 * 8 * 8 - squares));
    EXPECT_EQ(mesh::measure_topology(result.mesh).open_edges, boundary_faces == 1 ? 8U : boundary_faces == 3 ? 6U : 0U);
  }
}

TEST_P(NanHole, ChangesNothingWithoutNan) {
  const field::ScalarField field = Sampled(1, 0).field(false);
  ExtractOptions o = options();
  const Extraction hole = test::extract(field, o);
  o.nan = NanPolicy::outside;
  const Extraction outside = test::extract(field, o);
  EXPECT_TRUE(std::ranges::equal(hole.mesh.positions, outside.mesh.positions));
  EXPECT_TRUE(std::ranges::equal(hole.mesh.triangles, outside.mesh.triangles));
  EXPECT_EQ(hole.stats.hole_cells, 0U);
}

TEST_P(NanHole, AllNanGivesEmptyMesh) {
  const field::ScalarField field =
      test::dense_field<float>({8, 8, 8}, [](int, int, int) { return std::numeric_limits<double>::quiet_NaN(); });
  ExtractOptions o = options();
  o.cap = true;
  EXPECT_TRUE(test::extract(field, o).mesh.positions.empty());
  EXPECT_TRUE(test::extract(test::sparse_copy<float>(field, 0), o).mesh.positions.empty());
}

}  // namespace
}  // namespace isoextract::extract
