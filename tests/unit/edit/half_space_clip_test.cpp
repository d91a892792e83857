#include "edit/half_space_clip.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "field/demo_field.hpp"
#include "support/meshes.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::edit {
namespace {

mesh::Mesh surface_of(const char* demo, const glm::dvec3& origin = glm::dvec3(0)) {
  const field::ScalarField field = field::make_demo_field(demo, Context()).value();
  extract::ExtractOptions options;
  options.iso = 0;
  options.smooth_normals = true;
  options.output_from_index = field.index_to_world;
  options.output_from_index.offset += origin;
  return test::extract(field, options).mesh;
}

ClipFigures must_clip(mesh::Mesh& mesh, const std::vector<mesh::HalfSpace>& kept, const Context& context = Context()) {
  auto facts = clip_to_half_spaces(mesh, kept, {CutClosing::open}, context);
  if (!facts) throw std::runtime_error(facts.error().message);
  return *facts;
}

double area_of(const mesh::Mesh& mesh) { return mesh::measure_size(mesh).area; }

// Both sides of general planes together have the whole area. No triangle has zero area, normals have unit length, and
// all boundary edges lie on the plane.
TEST(HalfSpaceClip, SplitsAreaBetweenBothSides) {
  for (const glm::dvec3& origin : {glm::dvec3(0), glm::dvec3(1e6, -2e6, 3e6)}) {
    const mesh::Mesh whole = surface_of("demo:torus?size=40", origin);
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.3, -0.7, 0.5));
    const mesh::HalfSpace one{normal, glm::dot(normal, origin) + 0.05};
    const mesh::HalfSpace other{-normal, -one.offset};
    mesh::Mesh a = copy(whole);
    mesh::Mesh b = copy(whole);
    const ClipFigures facts = must_clip(a, {one});
    must_clip(b, {other});
    EXPECT_GT(facts.triangles_cut, 20U);
    EXPECT_EQ(facts.triangles_before, whole.triangles.size());
    EXPECT_EQ(facts.triangles_after, a.triangles.size());
    EXPECT_NEAR((area_of(a) + area_of(b)) / area_of(whole), 1, 1e-6);
    EXPECT_GT(area_of(a), 0.2 * area_of(whole));
    EXPECT_GT(area_of(b), 0.2 * area_of(whole));
    for (const mesh::Mesh* part : {&a, &b}) {
      const mesh::HalfSpace& kept = part == &a ? one : other;
      std::size_t on_plane = 0;
      for (std::size_t v = 0; v < part->positions.size(); ++v) {
        EXPECT_GT(kept.depth(part->position(v)), -2e-6);
        EXPECT_NEAR(glm::length(part->normals[v]), 1, 1e-5);
        on_plane += std::abs(kept.depth(part->position(v))) < 2e-6 ? 1 : 0;
      }
      const mesh::Topology topology = mesh::measure_topology(*part);
      // A closed surface is cut open: each boundary edge lies in the plane, and the edges form loops.
      EXPECT_EQ(topology.open_edges, on_plane);
      EXPECT_EQ(topology.nonmanifold_edges, 0U);
      EXPECT_EQ(topology.misoriented_edges, 0U);
      for (const glm::uvec3& t : part->triangles) {
        const glm::vec3 across =
            glm::cross(part->positions[t.y] - part->positions[t.x], part->positions[t.z] - part->positions[t.x]);
        EXPECT_GT(glm::length(across), 0);
      }
    }
  }
}

// A plane through vertices keeps them and makes no zero-area triangles.
TEST(HalfSpaceClip, KeepsVerticesOnPlane) {
  const std::vector<glm::vec3> corners{{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 2, 1}};
  const mesh::Mesh whole = test::make_mesh("m", corners, {{0, 1, 2}, {0, 3, 1}, {2, 1, 4}, {3, 0, 2}});
  mesh::Mesh right = copy(whole);
  const ClipFigures facts = must_clip(right, {{{1, 0, 0}, 0}});
  EXPECT_EQ(facts.triangles_cut, 2U);
  EXPECT_EQ(right.triangles.size(), 3U);
  EXPECT_EQ(right.positions.size(), 5U);  // vertices 1, 2, 3, 4 and one on the edge from 0 to 1
  EXPECT_EQ(right.positions[4], glm::vec3(0));
  EXPECT_FLOAT_EQ(static_cast<float>(area_of(right)),
                  1 + static_cast<float>(area_of(test::make_mesh("m", corners, {{2, 1, 4}}))));
}

TEST(HalfSpaceClip, ClipsToBox) {
  const mesh::Mesh whole = surface_of("demo:gyroid?size=30");
  mesh::Mesh same = copy(whole);
  must_clip(same, {{{1, 0, 0}, -100}, {{0, 0, -1}, -100}});
  ASSERT_EQ(same.positions.size(), whole.positions.size());
  EXPECT_EQ(std::memcmp(same.triangles.data(), whole.triangles.data(), whole.triangles.size_bytes()), 0);
  mesh::Mesh none = copy(whole);
  must_clip(none, {{{0, 1, 0}, 100}});
  EXPECT_TRUE(none.triangles.empty());
  EXPECT_TRUE(none.positions.empty());
  mesh::Mesh box = copy(whole);
  must_clip(box, {{{1, 0, 0}, -0.5}, {{-1, 0, 0}, -0.25}, {{0, 1, 0}, -0.125}, {{0, -1, 0}, -0.75}});
  const mesh::Bounds size = mesh::measure_bounds(box);
  EXPECT_NEAR(size.min.x, -0.5, 1e-6);
  EXPECT_NEAR(size.max.x, 0.25, 1e-6);
  EXPECT_NEAR(size.min.y, -0.125, 1e-6);
  EXPECT_NEAR(size.max.y, 0.75, 1e-6);
}

// Returns an attribute of one value at each vertex.
template <class T>
mesh::Attribute values_of(mesh::ComponentType type, const std::vector<T>& values) {
  mesh::Attribute attribute{"a", mesh::AttributeRole::other, type, 1, false, {}};
  attribute.values = Buffer<std::byte>(values.size() * sizeof(T));
  std::memcpy(attribute.values.data(), values.data(), attribute.values.size());
  return attribute;
}

template <class T>
std::vector<T> values_in(const mesh::Attribute& attribute) {
  std::vector<T> values(attribute.values.size() / sizeof(T));
  std::memcpy(values.data(), attribute.values.data(), attribute.values.size());
  return values;
}

TEST(HalfSpaceClip, InterpolatesAttributesAtCuts) {
  mesh::Mesh whole = test::make_mesh("m", {{-1, 0, 0}, {3, 0, 0}, {3, 4, 0}}, {{0, 1, 2}});
  whole.attributes.push_back(values_of<float>(mesh::ComponentType::f32, {1, 5, -3}));
  whole.attributes.push_back(values_of<std::int32_t>(mesh::ComponentType::i32, {7, 8, 9}));
  whole.attributes.push_back(values_of<std::uint8_t>(mesh::ComponentType::u8, {0, 200, 255}));
  whole.attributes.back().role = mesh::AttributeRole::color;
  whole.attributes.back().normalized = true;
  // Vertices 1 and 2 stay; the plane crosses the edges from 0 to both after a quarter of their length.
  mesh::Mesh right = copy(whole);
  must_clip(right, {{{1, 0, 0}, 0}});
  ASSERT_EQ(right.attributes.size(), 3U);
  EXPECT_EQ(right.attributes[2].role, mesh::AttributeRole::color);
  EXPECT_EQ(values_in<float>(right.attributes[0]), (std::vector<float>{5, -3, 2, 0}));
  EXPECT_EQ(values_in<std::int32_t>(right.attributes[1]), (std::vector<std::int32_t>{8, 9, 7, 7}));
  EXPECT_EQ(values_in<std::uint8_t>(right.attributes[2]), (std::vector<std::uint8_t>{200, 255, 50, 64}));
  // The other side has the same values on the edges.
  mesh::Mesh left = copy(whole);
  must_clip(left, {{{-1, 0, 0}, 0}});
  EXPECT_EQ(values_in<float>(left.attributes[0]), (std::vector<float>{1, 2, 0}));
  EXPECT_EQ(values_in<std::int32_t>(left.attributes[1]), (std::vector<std::int32_t>{7, 7, 7}));
  EXPECT_EQ(values_in<std::uint8_t>(left.attributes[2]), (std::vector<std::uint8_t>{0, 50, 64}));
  // A second plane crosses edges of the first cut.
  must_clip(right, {{{-1, 0, 0}, -2}, {{0, 1, 0}, -9}});
  EXPECT_EQ(values_in<float>(right.attributes[0]).size(), right.positions.size());
  mesh::Mesh none = copy(whole);
  must_clip(none, {{{1, 0, 0}, 9}});
  ASSERT_EQ(none.attributes.size(), 3U);
  EXPECT_TRUE(none.attributes[0].values.empty());
}

TEST(HalfSpaceClip, IsIndependentOfThreadsAndReservesMemory) {
  const mesh::HalfSpace kept{glm::normalize(glm::dvec3(1, 2, 3)), 0.1};
  std::vector<mesh::Mesh> results;
  for (const std::size_t threads : {1, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(surface_of("demo:gyroid?size=30"));
    must_clip(results.back(), {kept});
  }
  EXPECT_EQ(test::triangle_set(results[0]), test::triangle_set(results[1]));
  EXPECT_EQ(std::memcmp(results[0].positions.data(), results[1].positions.data(), results[0].positions.size_bytes()),
            0);
  mesh::Mesh mesh = surface_of("demo:gyroid?size=30");
  EXPECT_FALSE(clip_to_half_spaces(mesh, std::vector{kept}, {CutClosing::open}, Context(MemoryBudget(1000))));
  const Context context(MemoryBudget(std::uint64_t{1} << 30));
  must_clip(mesh, {kept}, context);
  EXPECT_EQ(context.memory().reserved(),
            mesh.positions.size_bytes() + mesh.normals.size_bytes() + mesh.triangles.size_bytes());
  test::add_attribute(mesh, "heat", mesh::ComponentType::f64, 2);
  must_clip(mesh, {{{1, 0, 0}, 0.05}}, context);
  EXPECT_EQ(context.memory().reserved(), mesh.positions.size_bytes() + mesh.normals.size_bytes() +
                                             mesh.triangles.size_bytes() + mesh.attributes[0].values.size());
}

}  // namespace
}  // namespace isoextract::edit
