// Compares the vectorized loops with scalar ones, bit for bit, for every instruction set of this machine.
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "extract/asymptotic_decider.hpp"
#include "extract/detail/cell_rows.hpp"
#include "extract/detail/classify_samples.hpp"
#include "extract/detail/vertex_batch.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

// Runs `f` once for each instruction set, and at last with the default one.
template <class F>
void for_each_target(const F& f) {
  for (const std::int64_t target : {HWY_AVX2, HWY_SSE4, HWY_SCALAR}) {
    hwy::SetSupportedTargetsForTest(target | HWY_SCALAR);
    SCOPED_TRACE(hwy::TargetName(target));
    f();
  }
  hwy::SetSupportedTargetsForTest(0);
  f();
}

template <class T>
class ClassifySamples : public testing::Test {};
using Types = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                             field::Half, float, double>;
TYPED_TEST_SUITE(ClassifySamples, Types);

TYPED_TEST(ClassifySamples, EqualsScalarComparison) {
  using T = TypeParam;
  using Key = typename OrderedKey<T>::Key;
  std::mt19937_64 engine(7);
  // Random bits, with NaN and infinities, and many values close to the threshold.
  std::vector<T> samples(1000);
  for (T& sample : samples) {
    const auto bits = static_cast<Key>(engine());
    std::memcpy(static_cast<void*>(&sample), &bits, sizeof sample);
  }
  for (const bool above : {true, false}) {
    for (int t = 0; t < 20; ++t) {
      const T threshold = t < 10 ? OrderedKey<T>::value(static_cast<Key>(OrderedKey<T>::kLowest + t))
                                 : OrderedKey<T>::value(static_cast<Key>(OrderedKey<T>::kHighest / 2 + t));
      const InsideThreshold<T> limit{threshold, above};
      const Key middle = OrderedKey<T>::key(threshold);
      for (std::size_t i = 0; i < samples.size(); i += 3) {
        const auto near = static_cast<Key>(middle + static_cast<Key>(engine() % 3) - 1);
        if (near >= OrderedKey<T>::kLowest && near <= OrderedKey<T>::kHighest) samples[i] = OrderedKey<T>::value(near);
      }
      for (const std::size_t count : {1U, 7U, 63U, 64U, 65U, 128U, 511U, 512U, 999U}) {
        std::vector<std::uint64_t> expected((count + 63) / 64);
        std::uint64_t expected_nan = 0;
        const InsideClassifier<T> plain(limit);
        for (std::size_t w = 0; w < expected.size(); ++w) {
          const int part = static_cast<int>(std::min<std::size_t>(64, count - 64 * w));
          expected[w] = plain(samples.data() + 64 * w, part, expected_nan);
        }
        for_each_target([&] {
          std::vector<std::uint64_t> bits(expected.size(), 0x5555);
          const std::uint64_t nan = classify_samples(samples.data(), count, limit, bits.data());
          EXPECT_EQ(bits, expected) << count;
          EXPECT_EQ(nan, expected_nan) << count;
        });
      }
    }
  }
}

bool same_bits(const glm::vec3& a, const glm::vec3& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// Ends on both sides of iso, from the smallest to the largest numbers, infinities and (sometimes) NaN.
class VertexBatches : public testing::TestWithParam<int> {
 protected:
  VertexBatches() {
    std::mt19937 engine(static_cast<unsigned>(GetParam()));
    std::uniform_real_distribution<double> unit(-1, 1);
    std::uniform_int_distribution<int> exponent(-1070, 1023);
    std::uniform_int_distribution<int> index(-1000, 1000);
    std::uniform_int_distribution<int> direction(1, 7);
    const auto special = [&](double ordinary) {
      const int choice = index(engine);
      if (choice > 990) return std::numeric_limits<double>::infinity();
      if (choice > 980) return -std::numeric_limits<double>::infinity();
      if (choice > 970) return std::numeric_limits<double>::quiet_NaN();
      if (choice > 960) return 0.0;
      return choice < -500 ? std::ldexp(ordinary, exponent(engine)) : ordinary;
    };
    batch_.count = 200 + GetParam();
    for (int i = 0; i < batch_.count; ++i) {
      batch_.direction[i] = direction(engine);
      for (int end = 0; end < 2; ++end) {
        batch_.value[end][i] = special(unit(engine) + (end == 0 ? 2 : -2));
        for (int axis = 0; axis < 3; ++axis) batch_.gradient[end][axis][i] = special(unit(engine));
      }
      for (int axis = 0; axis < 3; ++axis) batch_.low[axis][i] = index(engine);
    }
    for (int a = 0; a < 3; ++a) {
      frame_.linear[a] = glm::dvec3(unit(engine), unit(engine), unit(engine));
      frame_.offset[a] = 100 * unit(engine);
    }
  }

  VertexBatch batch_;
  field::Affine frame_;
};

TEST_P(VertexBatches, EqualSingleVertices) {
  const field::ValueScale scale = GetParam() % 2 == 0 ? field::ValueScale{} : field::ValueScale{-0.37, 11};
  const InsideRule rule{field::FieldKind::density, scale(0.1)};
  const OutputPlacement placement(frame_, {glm::ivec3(-1000), glm::ivec3(1001)}, rule.kind, scale);
  const auto size = static_cast<std::size_t>(batch_.count);
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;
  for (int i = 0; i < batch_.count; ++i) {
    const glm::dvec3 low(batch_.low[0][i], batch_.low[1][i], batch_.low[2][i]);
    const glm::dvec3 step = direction_step(batch_.direction[i]);
    const double f0 = scale(batch_.value[0][i]);
    const double t = edge_crossing(f0, scale(batch_.value[1][i]), rule.iso, placement.margin());
    positions.push_back(placement.position(low + t * step));
    const auto gradient = [&](int end) {
      return glm::dvec3(batch_.gradient[end][0][i], batch_.gradient[end][1][i], batch_.gradient[end][2][i]);
    };
    const glm::dvec3 out = (rule(f0) ? 1.0 : -1.0) * step;
    const bool unknown = std::isnan(batch_.value[0][i]) || std::isnan(batch_.value[1][i]) ||
                         glm::any(glm::isnan(gradient(0))) || glm::any(glm::isnan(gradient(1)));
    normals.push_back(unknown ? placement.placeholder_normal(out)
                              : placement.normal((1 - t) * gradient(0) + t * gradient(1), out));
  }
  for_each_target([&] {
    for (const bool with_normals : {false, true}) {
      // One more vertex on both sides must stay unchanged.
      mesh::Mesh mesh;
      mesh.positions = Buffer<glm::vec3>(size + 2);
      mesh.edges = Buffer<mesh::EdgeKey>(size + 2);
      if (with_normals) mesh.normals = Buffer<glm::vec3>(size + 2);
      const glm::vec3 untouched(1, 2, 3);
      std::fill(mesh.positions.begin(), mesh.positions.end(), untouched);
      std::fill(mesh.normals.begin(), mesh.normals.end(), untouched);
      VertexBatch batch = batch_;
      write_vertices(batch, {placement, rule, scale}, mesh, 1);
      EXPECT_EQ(batch.count, 0);
      for (const std::size_t end : {std::size_t{0}, size + 1}) {
        EXPECT_TRUE(same_bits(mesh.positions[end], untouched));
        EXPECT_TRUE(!with_normals || same_bits(mesh.normals[end], untouched));
      }
      for (std::size_t i = 0; i < size; ++i) {
        EXPECT_TRUE(same_bits(mesh.positions[i + 1], positions[i])) << i;
        EXPECT_TRUE(!with_normals || same_bits(mesh.normals[i + 1], normals[i])) << i;
        EXPECT_EQ(mesh.edges[i + 1].low.y, batch_.low[1][i]);
        EXPECT_EQ(mesh.edges[i + 1].direction, batch_.direction[i]);
      }
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Seeds, VertexBatches, testing::Range(0, 12));

// Scalar extraction, cell by cell, in the order that dense extraction promises.
std::vector<std::array<mesh::EdgeKey, 3>> plain_triangles(const field::ScalarField& field, Method method, double iso) {
  const auto& samples = std::get<field::DenseSamples>(field.samples);
  const CaseTable& table = case_table(method);
  const InsideRule rule{field.kind, iso};
  const auto value = [&](const glm::ivec3& p) {
    return static_cast<double>(static_cast<const float*>(
        samples.data)[p.x + static_cast<std::int64_t>(samples.dims.x) * (p.y + samples.dims.y * p.z)]);
  };
  std::vector<std::array<mesh::EdgeKey, 3>> triangles;
  for (int k = 0; k + 1 < samples.dims.z; ++k) {
    for (int j = 0; j + 1 < samples.dims.y; ++j) {
      for (int i = 0; i + 1 < samples.dims.x; ++i) {
        const glm::ivec3 p(i, j, k);
        const auto corner = [&](int c) { return value(p + direction_step(c)); };
        unsigned cell_case = 0;
        for (int c = 0; c < 8; ++c) cell_case |= rule(corner(c)) ? 1U << c : 0U;
        const unsigned v = cell_variant(table, cell_case, rule, corner);
        for (int t = table.first[v]; t < table.first[v + 1]; ++t) {
          std::array<mesh::EdgeKey, 3> keys;
          for (std::size_t n = 0; n < 3; ++n) {
            const CellEdge& edge = table.edges[table.triangles[static_cast<std::size_t>(t)][n]];
            keys[n] = {p + direction_step(edge.corner), edge.direction};
          }
          triangles.push_back(keys);
        }
      }
    }
  }
  return triangles;
}

TEST(CellRows, EqualScalarLoops) {
  // Rows that end within a word, at its end and just after it. Noise, where many cells are ambiguous, and few crossed
  // words in long rows.
  constexpr double iso = 1.5;
  std::vector<field::ScalarField> fields;
  for (const glm::ivec3 dims : {glm::ivec3(2), glm::ivec3(63, 5, 4), glm::ivec3(64, 4, 9), glm::ivec3(65, 9, 3),
                                glm::ivec3(66, 3, 3), glm::ivec3(129, 10, 10)}) {
    fields.push_back(test::random_field<float>(dims, 3, 5));
  }
  fields.push_back(test::dense_field<float>(
      {300, 12, 17}, [](int i, int j, int k) { return 6 - glm::length(glm::dvec3(i - 150, j - 5, k - 6)); }));
  for (const field::ScalarField& field : fields) {
    for (const Method method : test::cell_methods()) {
      const auto expected = plain_triangles(field, method, iso);
      for_each_target([&] {
        ExtractOptions options;
        options.method = method;
        options.iso = iso;
        options.edge_keys = true;
        const mesh::Mesh mesh = test::extract(field, options).mesh;
        ASSERT_EQ(mesh.triangles.size(), expected.size());
        std::size_t different = 0;
        for (std::size_t t = 0; t < expected.size(); ++t) {
          for (int n = 0; n < 3; ++n) {
            const auto corner = static_cast<std::size_t>(n);
            different += mesh.edges[mesh.triangles[t][n]] == expected[t][corner] ? 0 : 1;
          }
        }
        EXPECT_EQ(different, 0U);
        // Lists every edge once.
        EXPECT_EQ(std::set(mesh.edges.begin(), mesh.edges.end()).size(), mesh.edges.size());
      });
    }
  }
}

}  // namespace
}  // namespace isoextract::extract
