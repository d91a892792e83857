// Properties of every mesh for any field: closed where it should be, oriented, manifold, without zero-area triangles,
// and of the known genus.
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "field/demo_field.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

using test::dense_field;
using test::expect_sound;
using test::extract;

class Invariants : public testing::TestWithParam<Method> {
 protected:
  static ExtractOptions options(double iso, bool cap = false) { return test::options_of(GetParam(), iso, cap); }
  static bool always_closed() { return test::traits_of(GetParam()).always_closed; }
  // Returns the size of the closed surface of a box of so many samples, all inside.
  static glm::dvec3 extent(const glm::ivec3& dims) {
    return glm::dvec3(dims - 1) + 2 * test::reach_beyond_samples(GetParam());
  }
  static field::ScalarField demo(const char* spec) { return field::make_demo_field(spec, Context()).value(); }
};

INSTANTIATE_TEST_SUITE_P(Methods, Invariants, testing::ValuesIn(test::all_methods()), test::method_name);

TEST_P(Invariants, SphereHasGenusZero) {
  const mesh::Mesh mesh = extract(demo("demo:sphere?size=33"), options(0)).mesh;
  expect_sound(mesh, true);
  EXPECT_EQ(mesh::measure_topology(mesh).components, 1U);
  EXPECT_EQ(mesh::measure_topology(mesh).genus(), 0);
  EXPECT_GT(mesh::measure_size(mesh).volume, 0) << "wound inside out";
}

TEST_P(Invariants, TorusHasGenusOne) {
  const mesh::Mesh mesh = extract(demo("demo:torus?size=40"), options(0)).mesh;
  expect_sound(mesh, true);
  EXPECT_EQ(mesh::measure_topology(mesh).genus(), 1);
}

TEST_P(Invariants, IsOpenOnlyAtDataBoundary) {
  const field::ScalarField field = demo("demo:gyroid?size=30");
  const mesh::Mesh mesh = extract(field, options(0)).mesh;
  expect_sound(mesh, always_closed());
  EXPECT_EQ(mesh::measure_topology(mesh).open_edges == 0, always_closed());
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) ++uses[std::minmax(t[c], t[(c + 1) % 3])];
  }
  for (const auto& [edge, count] : uses) {
    if (count == 2) continue;
    const glm::dvec3 a = mesh.position(edge.first);
    const glm::dvec3 b = mesh.position(edge.second);
    bool at_data_boundary = false;
    for (int axis = 0; axis < 3; ++axis) {
      at_data_boundary |= a[axis] == b[axis] && (a[axis] == 0 || a[axis] == 29);
    }
    EXPECT_TRUE(at_data_boundary);
  }
}

TEST_P(Invariants, CapClosesTheGyroid) {
  const Extraction open = extract(demo("demo:gyroid?size=30"), options(0));
  const mesh::Mesh mesh = extract(demo("demo:gyroid?size=30"), options(0, true)).mesh;
  expect_sound(mesh, true);
  if (always_closed()) {
    EXPECT_EQ(test::triangle_set(mesh), test::triangle_set(open.mesh));
  } else {
    EXPECT_GT(mesh.triangles.size(), open.mesh.triangles.size());
  }
  // The gyroid divides the box into halves.
  const double box = std::pow(extent(glm::ivec3(30)).x, 3);
  EXPECT_NEAR(mesh::measure_size(mesh).volume, box / 2, 0.01 * box);
}

TEST_P(Invariants, CapsBoxToExactVolume) {
  // Everything is inside, so only the cap has triangles.
  const field::ScalarField field = dense_field<float>({5, 4, 3}, [](int, int, int) { return 1; });
  const mesh::Mesh mesh = extract(field, options(0, true)).mesh;
  expect_sound(mesh, true);
  const glm::dvec3 box = extent({5, 4, 3});
  EXPECT_NEAR(mesh::measure_size(mesh).volume, box.x * box.y * box.z, 1e-12);
  EXPECT_NEAR(mesh::measure_size(mesh).area, 2 * (box.x * box.y + box.y * box.z + box.z * box.x), 1e-12);
}

// Uniform values produce every case; few distinct integers tie with iso everywhere.
TEST_P(Invariants, RandomFieldsGiveManifolds) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const int distinct = seed % 3 == 0 ? 2 : seed % 3 == 1 ? 5 : 1 << 20;
    const glm::ivec3 dims(2 + seed % 7, 2 + seed % 5, 2 + seed % 11);
    const field::ScalarField field = test::random_field<float>(dims, seed, distinct);
    for (const double iso : {0.0, 1.0, 2.0, distinct / 2.0}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", iso " << iso);
      expect_sound(extract(field, options(iso)).mesh, always_closed());
      expect_sound(extract(field, options(iso, true)).mesh, true);
    }
  }
}

// For every method, the cell of a vertex has corners on both sides. Samples beyond the data count as outside.
TEST_P(Invariants, PutsVerticesIntoCrossedCells) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const glm::ivec3 dims(9, 8, 7);
    const field::ScalarField field = test::random_field<float>(dims, seed, 100);
    const auto* values = static_cast<const float*>(std::get<field::DenseSamples>(field.samples).data);
    const auto inside = [&](const glm::ivec3& p) {
      const bool there = glm::all(glm::greaterThanEqual(p, glm::ivec3(0))) && glm::all(glm::lessThan(p, dims));
      return there && values[p.x + dims.x * (p.y + dims.y * p.z)] > 30;
    };
    ExtractOptions moved = options(30);
    moved.relaxations = 50;  // enough to push the points of a surface net out of their cells
    const mesh::Mesh mesh = extract(field, moved).mesh;
    EXPECT_FALSE(mesh.positions.empty());
    std::size_t elsewhere = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const glm::ivec3 cell(glm::floor(mesh.position(v)));
      int corners_inside = 0;
      for (int c = 0; c < 8; ++c) corners_inside += inside(cell + glm::ivec3(c & 1, c >> 1 & 1, c >> 2)) ? 1 : 0;
      elsewhere += corners_inside == 0 || corners_inside == 8 ? 1 : 0;
    }
    EXPECT_EQ(elsewhere, 0U) << "seed " << seed;
  }
}

// Two inside samples across a face are joined if the saddle between them is inside, and apart if it is outside or equal
// to iso. They are joined if another corner equals iso, because the field next to it is inside.
TEST(AsymptoticDecider, DecidesFacesBySaddles) {
  struct Case {
    int other;
    std::size_t components;
  };
  for (const Case c : {Case{1, 2}, Case{2, 2}, Case{3, 1}, Case{5, 1}}) {
    const field::ScalarField field = dense_field<std::uint8_t>({4, 4, 4}, [&](int i, int j, int k) {
      if (k != 1) return 0;
      if ((i == 1 && j == 1) || (i == 2 && j == 2)) return 8;
      if (i == 2 && j == 1) return c.other;
      return i == 1 && j == 2 ? 2 : 0;
    });
    ExtractOptions o;
    o.iso = 5;  // saddle: (8 - 5)^2 against (5 - other) * (5 - 2)
    const mesh::Mesh mesh = extract(field, o).mesh;
    expect_sound(mesh, true);
    EXPECT_EQ(mesh::measure_topology(mesh).components, c.components) << "other corner " << c.other;
  }
}

// Products of depths that exceed the range of double.
TEST(AsymptoticDecider, DecidesExtremeValues) {
  for (const double size : {1e300, 1e-300}) {
    for (const bool joined : {false, true}) {
      const field::ScalarField field = dense_field<double>({4, 4, 4}, [&](int i, int j, int k) {
        if (k != 1) return -size;
        if ((i == 1 && j == 1) || (i == 2 && j == 2)) return joined ? 3 * size : size;
        return (i == 1 || i == 2) && (j == 1 || j == 2) ? -2 * size : -size;
      });
      const mesh::Mesh mesh = extract(field, ExtractOptions{}).mesh;
      expect_sound(mesh, true);
      EXPECT_EQ(mesh::measure_topology(mesh).components, joined ? 1U : 2U) << "values about " << size;
    }
  }
}

// Values below iso in a level set correspond to values above iso in a density field.
TEST_P(Invariants, LevelSetsAreMirrorImages) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const field::ScalarField density = test::random_field<std::int16_t>({7, 6, 5}, seed, 9);
    const auto& samples = std::get<field::DenseSamples>(density.samples);
    const auto* values = static_cast<const std::int16_t*>(samples.data);
    field::ScalarField level_set = dense_field<std::int16_t>(
        samples.dims, [&](int i, int j, int k) { return -values[i + samples.dims.x * (j + samples.dims.y * k)]; });
    level_set.kind = field::FieldKind::level_set;
    const mesh::Mesh a = extract(density, options(4, true)).mesh;
    const mesh::Mesh b = extract(level_set, options(-4, true)).mesh;
    EXPECT_EQ(test::triangle_set(a), test::triangle_set(b));
  }
}

TEST_P(Invariants, CheckerboardGivesManifold) {
  const field::ScalarField field =
      dense_field<std::uint8_t>({9, 8, 7}, [](int i, int j, int k) { return (i + j + k) % 2; });
  for (const double iso : {0.0, 0.5, 0.999}) {
    const mesh::Mesh mesh = extract(field, options(iso, true)).mesh;
    EXPECT_FALSE(mesh.triangles.empty());
    expect_sound(mesh, true);
  }
}

TEST_P(Invariants, ValuesEqualToIsoAreOutside) {
  const field::ScalarField field = dense_field<std::int16_t>(
      {6, 6, 6}, [](int i, int j, int k) { return i > 1 && i < 4 && j > 1 && j < 4 && k > 1 && k < 4 ? 7 : 5; });
  EXPECT_TRUE(extract(field, options(7)).mesh.triangles.empty());
  const mesh::Mesh mesh = extract(field, options(5)).mesh;
  expect_sound(mesh, true);
  // A surface that follows the field stays close to the outside samples that tie with iso. Other surfaces pass anywhere
  // between them and the inside samples.
  const double gap = test::traits_of(GetParam()).follows_interpolant ? 0.001 : 1;
  const mesh::Bounds bounds = mesh::measure_bounds(mesh);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GT(bounds.min[axis], 1.0);
    EXPECT_LT(bounds.min[axis], 1 + gap);
    EXPECT_LT(bounds.max[axis], 4.0);
    EXPECT_GT(bounds.max[axis], 4 - gap);
  }
}

TEST_P(Invariants, ExtractsSmallestFields) {
  const field::ScalarField field =
      dense_field<float>({2, 2, 2}, [](int i, int j, int k) { return i + j + k == 0 ? 1 : -1; });
  const mesh::Mesh mesh = extract(field, options(0)).mesh;
  // The corners of a box around the inside sample, or a vertex on each of its edges.
  const bool axis_edges_only = test::traits_of(GetParam()).axis_edges_only;
  EXPECT_EQ(mesh.positions.size(), always_closed() ? 8U : axis_edges_only ? 3U : 7U);
  expect_sound(mesh, always_closed());
}

TEST_P(Invariants, ExtractsRowsLongerThanAWord) {
  // Crossings at, before and after the ends of 64-bit words.
  for (const int nx : {63, 64, 65, 66, 127, 128, 129, 193}) {
    const field::ScalarField field = dense_field<float>({nx, 5, 5}, [&](int i, int j, int k) {
      const bool middle = j > 0 && j < 4 && k > 0 && k < 4;
      return middle && i > 0 && i < nx - 1 && i % 3 != 0 ? 1 : -1;
    });
    SCOPED_TRACE(nx);
    const mesh::Mesh mesh = extract(field, options(0.25)).mesh;
    expect_sound(mesh, true);
    int runs = 0;
    for (int i = 1; i < nx - 1; ++i) runs += i % 3 == 1 ? 1 : 0;
    EXPECT_EQ(mesh::measure_topology(mesh).components, static_cast<std::uint64_t>(runs));
  }
}

TEST_P(Invariants, LevelSetEqualsNegatedDensity) {
  field::ScalarField density = test::random_field<float>({12, 9, 10}, 5, 1000);
  field::ScalarField level_set = dense_field<float>({12, 9, 10}, [&](int i, int j, int k) {
    const auto& dense = std::get<field::DenseSamples>(density.samples);
    return -static_cast<const float*>(dense.data)[i + 12 * (j + 9 * k)];
  });
  level_set.kind = field::FieldKind::level_set;
  ExtractOptions negative = options(-500);
  EXPECT_EQ(test::triangle_set(extract(density, options(500)).mesh),
            test::triangle_set(extract(level_set, negative).mesh));
}

// The stored type does not matter: u8, i16, ... hold the same numbers, with and without a scale.
TEST_P(Invariants, StoredTypesAgree) {
  const glm::ivec3 dims(10, 11, 12);
  const auto value = [](int i, int j, int k) { return (i * 7 + j * 13 + k * 29) % 101; };
  const auto reference = test::triangle_set(extract(dense_field<double>(dims, value), options(50)).mesh);
  EXPECT_EQ(reference, test::triangle_set(extract(dense_field<std::uint8_t>(dims, value), options(50)).mesh));
  EXPECT_EQ(reference, test::triangle_set(extract(dense_field<std::int8_t>(dims, value), options(50)).mesh));
  EXPECT_EQ(reference, test::triangle_set(extract(dense_field<std::uint16_t>(dims, value), options(50)).mesh));
  EXPECT_EQ(reference, test::triangle_set(extract(dense_field<std::int16_t>(dims, value), options(50)).mesh));
  EXPECT_EQ(reference, test::triangle_set(extract(dense_field<std::uint32_t>(dims, value), options(50)).mesh));
  EXPECT_EQ(reference, test::triangle_set(extract(dense_field<std::int32_t>(dims, value), options(50)).mesh));
  EXPECT_EQ(reference, test::triangle_set(extract(dense_field<field::Half>(dims, value), options(50)).mesh));
  EXPECT_EQ(reference, test::triangle_set(extract(dense_field<float>(dims, value), options(50)).mesh));
  field::ScalarField scaled = dense_field<std::uint8_t>(dims, value);
  scaled.scale = {4, -8};
  EXPECT_EQ(reference, test::triangle_set(extract(scaled, options(4 * 50 - 8)).mesh));
  scaled.scale = {-4, 8};  // a negative slope reverses density
  scaled.kind = field::FieldKind::level_set;
  EXPECT_EQ(reference, test::triangle_set(extract(scaled, options(-4 * 50 + 8)).mesh));
}

TEST_P(Invariants, KeepsExtremeValuesInsideEdges) {
  const double big = 3e38;
  for (const auto& [low, high, iso] : {std::array{-big, big, 0.0},
                                       {-1e-45, 1e-45, 0.0},
                                       {0.0, 1e30, 1.0},
                                       {-1.7e308, 1.7e308, 1e300},
                                       {1e7 - 1e-3, 1e7 + 1e-3, 1e7}}) {
    const field::ScalarField field = dense_field<double>({4, 4, 4}, [&, lo = low, hi = high](int i, int j, int k) {
      return i > 0 && i < 3 && j > 0 && j < 3 && k > 0 && k < 3 ? hi : lo;
    });
    const mesh::Mesh mesh = extract(field, options(iso)).mesh;
    ASSERT_FALSE(mesh.triangles.empty());
    expect_sound(mesh, true);
    for (const glm::vec3& p : mesh.positions) {
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_GE(p[axis], 0);
        EXPECT_LE(p[axis], 3);
      }
    }
  }
}

}  // namespace
}  // namespace isoextract::extract
