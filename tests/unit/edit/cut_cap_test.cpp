#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "edit/half_space_clip.hpp"
#include "field/demo_field.hpp"
#include "mesh/topology.hpp"
#include "support/box_mesh.hpp"
#include "support/meshes.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::edit {
namespace {

mesh::Mesh closed_surface(const char* demo, double iso = 0, const glm::dvec3& origin = glm::dvec3(0)) {
  const field::ScalarField field = field::make_demo_field(demo, Context()).value();
  extract::ExtractOptions options;
  options.iso = iso;
  options.cap = true;
  options.smooth_normals = true;
  options.output_from_index = field.index_to_world;
  options.output_from_index.offset += origin;
  return test::extract(field, options).mesh;
}

ClipFigures must_cap(mesh::Mesh& mesh, const std::vector<mesh::HalfSpace>& kept, const Context& context = Context()) {
  auto facts = clip_to_half_spaces(mesh, kept, {CutClosing::capped}, context);
  if (!facts) throw std::runtime_error(facts.error().message);
  return *facts;
}

// Returns the area of the triangles in a plane, and of those that face its kept side.
struct PlaneArea {
  double area = 0;
  double against = 0;
};
PlaneArea area_in(const mesh::Mesh& mesh, const mesh::HalfSpace& plane) {
  PlaneArea sum;
  for (const glm::uvec3& t : mesh.triangles) {
    bool in = true;
    for (int i = 0; i < 3; ++i) in = in && std::abs(plane.depth(mesh.position(t[i]))) < 3e-6;
    if (!in) continue;
    const glm::dvec3 across =
        glm::cross(mesh.position(t.y) - mesh.position(t.x), mesh.position(t.z) - mesh.position(t.x));
    const double out = -glm::dot(across, plane.normal) / 2;
    sum.area += out;
    sum.against += std::max(-out, 0.0);
  }
  return sum;
}

void expect_closed(const mesh::Mesh& mesh, const std::string& what) {
  const mesh::Topology topology = mesh::measure_topology(mesh);
  EXPECT_TRUE(topology.is_closed_oriented_manifold())
      << what << ": " << topology.open_edges << " open, " << topology.nonmanifold_edges << " non-manifold, "
      << topology.misoriented_edges << " misoriented edges, " << topology.nonmanifold_vertices << " vertices";
  EXPECT_EQ(topology.unused_vertices, 0U) << what;
  EXPECT_EQ(mesh.normals.size(), mesh.positions.size()) << what;
}

double volume_of(const mesh::Mesh& mesh) { return mesh::measure_size(mesh).volume; }

// General planes, planes along the sample axes between samples, and planes through samples.
TEST(CutCap, ClosesBothSidesAndKeepsVolume) {
  struct Surface {
    const char* demo;
    double iso;
  };
  const std::vector<glm::dvec3> normals{{0.3, -0.7, 0.5}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {0, -1, 0}};
  for (const auto& [demo, iso] : {Surface{"demo:sphere?size=33", 0}, Surface{"demo:torus?size=40", 0},
                                  Surface{"demo:gyroid?size=33", 0}, Surface{"demo:gyroid?size=24", 0.25}}) {
    for (const double offset : {0.0, 0.05, -0.125}) {
      for (const glm::dvec3& along : normals) {
        const std::string what = std::string(demo) + " " + std::to_string(offset) + " " + std::to_string(along.x);
        const mesh::Mesh whole = closed_surface(demo, iso);
        ASSERT_TRUE(mesh::measure_topology(whole).is_closed_oriented_manifold());
        const mesh::HalfSpace one{glm::normalize(along), offset};
        const mesh::HalfSpace other{-one.normal, -offset};
        mesh::Mesh a = copy(whole);
        mesh::Mesh b = copy(whole);
        const ClipFigures facts = must_cap(a, {one});
        must_cap(b, {other});
        EXPECT_GT(facts.cap_triangles, 8U) << what;
        EXPECT_EQ(facts.overlapping_cap_triangles, 0U) << what;
        EXPECT_EQ(facts.triangles_after, a.triangles.size()) << what;
        expect_closed(a, what);
        expect_closed(b, what);
        EXPECT_NEAR(volume_of(a) + volume_of(b), volume_of(whole), 2e-6) << what;
        EXPECT_GT(volume_of(a), 0.1 * volume_of(whole)) << what;
        const PlaneArea in_a = area_in(a, one);
        const PlaneArea in_b = area_in(b, other);
        EXPECT_NEAR(in_a.area, in_b.area, 1e-5) << what;
        EXPECT_GT(in_a.area, 0.01) << what;
        EXPECT_LT(in_a.against + in_b.against, 1e-5 * in_a.area) << what;  // rounding along all edges
      }
    }
  }
}

// A half, a quarter and an eighth: later planes cut the caps of earlier ones. No handles, no extra components.
TEST(CutCap, CutsCapsOfEarlierPlanes) {
  for (const glm::dvec3& origin : {glm::dvec3(0), glm::dvec3(1e5, -2e5, 3e5)}) {
    mesh::Mesh part = closed_surface("demo:sphere?size=49", 0, origin);
    double volume = volume_of(part);
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 normal(0);
      normal[axis] = 1;
      must_cap(part, {{normal, origin[axis]}});
      expect_closed(part, std::to_string(axis));
      EXPECT_NEAR(volume_of(part) / volume, 0.5, 1e-3) << axis;
      volume = volume_of(part);
      const mesh::Topology topology = mesh::measure_topology(part);
      EXPECT_EQ(topology.components, 1U);
      EXPECT_EQ(topology.euler, 2);
    }
  }
  mesh::Mesh ring = closed_surface("demo:torus?size=40");
  must_cap(ring, {{glm::normalize(glm::dvec3(1, 0.1, 0)), 0}});
  EXPECT_EQ(mesh::measure_topology(ring).euler, 2);  // a half of a ring
}

// An attribute that holds the position does so at the vertices of cuts and caps too, also at the midpoints that a cap
// adds.
TEST(CutCap, InterpolatesAttributes) {
  for (const char* demo : {"demo:gyroid?size=33", "demo:torus?size=40", "demo:sphere?size=33"}) {
    for (const glm::dvec3& along : {glm::dvec3(0.3, -0.7, 0.5), glm::dvec3(0, 0, 1), glm::dvec3(1, 1, 0)}) {
      mesh::Mesh mesh = closed_surface(demo);
      mesh::Attribute place{"place", mesh::AttributeRole::other, mesh::ComponentType::f32, 3, false, {}};
      place.values = Buffer<std::byte>(mesh.positions.size_bytes());
      std::memcpy(place.values.data(), mesh.positions.data(), mesh.positions.size_bytes());
      mesh.attributes.push_back(std::move(place));
      const ClipFigures facts = must_cap(mesh, {{glm::normalize(along), 0.05}, {{0, 1, 0}, -0.23}});
      EXPECT_GT(facts.cap_triangles, 8U) << demo;
      expect_closed(mesh, demo);
      ASSERT_EQ(mesh.attributes.size(), 1U);
      ASSERT_EQ(mesh.attributes[0].values.size(), mesh.positions.size_bytes());
      for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        glm::vec3 value;
        std::memcpy(&value, mesh.attributes[0].at(v).data(), sizeof value);
        ASSERT_LT(glm::distance(value, mesh.positions[v]), 2e-6F) << demo << " " << v;
      }
    }
  }
}

// In a plane, triangles of a removed body go, triangles of a kept body stay, and the rest of the plane is capped.
TEST(CutCap, DropsOrKeepsFacesInPlane) {
  // A block with a smaller one on top: the step is at z = 0.
  mesh::Mesh above = test::box_mesh({0, 0, 0}, {1, 1, 1});
  must_cap(above, {{{0, 0, 1}, 0}});
  EXPECT_EQ(above.triangles.size(), 12U);  // nothing is outside
  mesh::Mesh below = test::box_mesh({0, 0, -1}, {1, 1, 0});
  must_cap(below, {{{0, 0, 1}, 0}});
  EXPECT_TRUE(below.triangles.empty());
  mesh::Mesh half = test::box_mesh({0, 0, -1}, {1, 2, 3});
  half.normals = {};
  const ClipFigures facts = must_cap(half, {{{0, 0, 1}, 0}});
  EXPECT_GE(facts.cap_triangles, 2U);
  EXPECT_TRUE(mesh::measure_topology(half).is_closed_oriented_manifold());
  EXPECT_NEAR(volume_of(half), 6, 1e-6);
}

TEST(CutCap, RejectsCutsThatEndAtBoundaryEdges) {
  const field::ScalarField field = field::make_demo_field("demo:gyroid?size=30", Context()).value();
  extract::ExtractOptions options;
  options.iso = 0;
  options.output_from_index = field.index_to_world;
  mesh::Mesh open = test::extract(field, options).mesh;
  const std::vector<mesh::HalfSpace> kept{{{0.6, 0.8, 0}, 0.1}};
  const auto refused = clip_to_half_spaces(open, kept, {CutClosing::capped}, Context());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::input);
  EXPECT_NE(refused.error().message.find("cannot cap the cut"), std::string::npos);
}

TEST(CutCap, IsIndependentOfThreadsAndReservesMemory) {
  const std::vector<mesh::HalfSpace> kept{{glm::normalize(glm::dvec3(1, 2, 3)), 0.1}, {{0, 0, -1}, -0.5}};
  std::vector<mesh::Mesh> results;
  for (const std::size_t threads : {1, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(closed_surface("demo:gyroid?size=30"));
    must_cap(results.back(), kept);
  }
  ASSERT_EQ(results[0].triangles.size(), results[1].triangles.size());
  EXPECT_EQ(std::memcmp(results[0].triangles.data(), results[1].triangles.data(), results[0].triangles.size_bytes()),
            0);
  mesh::Mesh mesh = closed_surface("demo:gyroid?size=30");
  EXPECT_FALSE(clip_to_half_spaces(mesh, kept, {CutClosing::capped}, Context(MemoryBudget(1000))));
  const Context context(MemoryBudget(std::uint64_t{1} << 30));
  must_cap(mesh, kept, context);
  EXPECT_EQ(context.memory().reserved(),
            mesh.positions.size_bytes() + mesh.normals.size_bytes() + mesh.triangles.size_bytes());
}

}  // namespace
}  // namespace isoextract::edit
