#include "accuracy/mesh_distance.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "mesh/closest_point.hpp"
#include "mesh/triangle_tree.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::accuracy {
namespace {

using test::make_mesh;

DistanceOptions few_samples() {
  DistanceOptions options;
  options.samples = 1 << 13;
  return options;
}

MeshDistance distance(const mesh::Mesh& a, const mesh::Mesh& b, const DistanceOptions& options = few_samples()) {
  auto result = measure_distance(a, b, options, Context());
  if (!result) {
    ADD_FAILURE() << result.error().message;
    return {};
  }
  return *result;
}

// n x n squares of the unit square at height z, each cut along the diagonal that `turned` selects.
mesh::Mesh plane(unsigned n, float z, bool turned = false) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (unsigned j = 0; j <= n; ++j) {
    for (unsigned i = 0; i <= n; ++i) {
      positions.emplace_back(static_cast<float>(i) / static_cast<float>(n),
                             static_cast<float>(j) / static_cast<float>(n), z);
    }
  }
  for (unsigned j = 0; j < n; ++j) {
    for (unsigned i = 0; i < n; ++i) {
      const unsigned v = j * (n + 1) + i;
      const unsigned w = v + n + 1;
      if (turned) {
        triangles.insert(triangles.end(), {{v, v + 1, w}, {v + 1, w + 1, w}});
      } else {
        triangles.insert(triangles.end(), {{v, v + 1, w + 1}, {v, w + 1, w}});
      }
    }
  }
  return make_mesh("plane", positions, triangles);
}

mesh::Mesh cube(unsigned n) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  const mesh::Mesh side = plane(n, 0);
  for (int face = 0; face < 6; ++face) {
    const auto first = static_cast<unsigned>(positions.size());
    for (const glm::vec3& p : side.positions) {
      const float height = face < 3 ? 0.0F : 1.0F;
      const glm::vec3 q(p.x, p.y, height);
      positions.push_back(face % 3 == 0 ? q : face % 3 == 1 ? glm::vec3(q.z, q.x, q.y) : glm::vec3(q.y, q.z, q.x));
    }
    for (const glm::uvec3& t : side.triangles) triangles.push_back(t + first);
  }
  return make_mesh("cube", positions, triangles);
}

mesh::Mesh scaled(mesh::Mesh mesh, float factor) {
  for (glm::vec3& p : mesh.positions) p *= factor;
  return mesh;
}

mesh::Mesh random_soup(std::mt19937& random, unsigned triangles, float size) {
  std::uniform_real_distribution<float> place(-1, 1);
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> corners;
  for (unsigned t = 0; t < triangles; ++t) {
    const glm::vec3 center(place(random), place(random), place(random));
    for (int c = 0; c < 3; ++c) {
      positions.push_back(center + size * glm::vec3(place(random), place(random), place(random)));
    }
    corners.emplace_back(3 * t, 3 * t + 1, 3 * t + 2);
  }
  return make_mesh("soup", positions, corners);
}

// Returns the least distance to any triangle, by brute force.
double brute_distance(const glm::dvec3& p, const mesh::Mesh& mesh) {
  double least = std::numeric_limits<double>::infinity();
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 q =
        mesh::ClosestPointTriangle(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]).closest(p);
    least = std::min(least, glm::length(p - q));
  }
  return least;
}

void expect_interval(const MeshDistance& d, double wanted, double slack) {
  EXPECT_LE(d.hausdorff_lower, wanted + slack);
  EXPECT_GE(d.hausdorff_upper, wanted - slack);
  EXPECT_LE(d.hausdorff_upper, d.hausdorff_lower * 1.0100001 + d.resolution);
}

TEST(ClosestOnTriangle, MatchesSamplesIncludingZeroArea) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-1, 1);
  const auto point = [&] { return glm::dvec3(place(random), place(random), place(random)); };
  for (int round = 0; round < 300; ++round) {
    const glm::dvec3 a = point();
    glm::dvec3 b = point();
    glm::dvec3 c = point();
    if (round % 6 == 1) b = a;
    if (round % 6 == 2) c = b;
    if (round % 6 == 3) c = a;
    if (round % 6 == 4) c = a + (b - a) * 0.5;
    if (round % 6 == 5) b = c = a;
    const glm::dvec3 p = point() * 2.0;
    const double found = glm::length(p - mesh::ClosestPointTriangle(a, b, c).closest(p));
    double least = std::numeric_limits<double>::infinity();
    constexpr int kSteps = 60;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const double u = static_cast<double>(i) / kSteps;
        const double v = static_cast<double>(j) / kSteps;
        least = std::min(least, glm::length(p - ((1 - u - v) * a + u * b + v * c)));
      }
    }
    EXPECT_LE(found, least + 1e-12) << round;
    EXPECT_GE(found, least - 0.06) << round;
  }
}

// Triangles whose corners are collinear up to float32 rounding, and points near that line.
TEST(ClosestOnTriangle, HandlesNeedles) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-5, 5);
  const auto point = [&] {
    const float x = std::round(place(random));
    const float y = std::round(place(random));
    return glm::vec3(x, y, std::round(place(random)));
  };
  for (int round = 0; round < 3000; ++round) {
    const glm::vec3 start = point();
    const glm::vec3 direction = point();
    mesh::Mesh needle;
    needle.positions = Buffer<glm::vec3>(3);
    for (std::size_t c = 0; c < 3; ++c) {
      const float t = place(random);
      needle.positions[c] = start + (round % 2 == 0 ? std::round(t) : t) * direction;
    }
    const glm::dvec3 a = needle.positions[0];
    const glm::dvec3 b = needle.positions[1];
    const glm::dvec3 c = needle.positions[2];
    const glm::dvec3 p = glm::dvec3(start + place(random) * direction) + glm::dvec3(0.01, -0.02, 0.01);
    const double found = glm::length(p - mesh::ClosestPointTriangle(a, b, c).closest(p));
    const double sides = std::min({glm::length(p - mesh::closest_on_segment(p, a, b)),
                                   glm::length(p - mesh::closest_on_segment(p, b, c)),
                                   glm::length(p - mesh::closest_on_segment(p, c, a))});
    EXPECT_LE(found, sides) << round;
    EXPECT_GE(found, sides - 1e-5) << round;  // the needle's width
  }
}

TEST(TriangleTree, NearestMatchesBruteForce) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-2, 2);
  for (const unsigned triangles : {1U, 2U, 4U, 5U, 9U, 100U, 1000U}) {
    const mesh::Mesh soup = random_soup(random, triangles, 0.2F);
    const mesh::TriangleTree tree(soup.positions.span(), soup.triangles.span());
    for (int round = 0; round < 50; ++round) {
      const glm::dvec3 p(place(random), place(random), place(random));
      const auto nearest = tree.nearest(p, static_cast<std::uint32_t>(round) % triangles);
      EXPECT_DOUBLE_EQ(std::sqrt(nearest.distance_squared), brute_distance(p, soup));
      EXPECT_NEAR(glm::length(p - nearest.point), std::sqrt(nearest.distance_squared), 1e-14);
      EXPECT_EQ(tree.nearest_on_triangle(nearest.slot, p).point, nearest.point);
    }
  }
}

TEST(MeshDistance, MeasuresParallelPlanes) {
  const MeshDistance d = distance(plane(7, 0), plane(5, 0.25F, true));
  expect_interval(d, 0.25, 0);
  for (const double figure : {d.rms, d.mean, d.percentile99, d.a_to_b.rms, d.b_to_a.mean, d.a_to_b.max_lower}) {
    EXPECT_NEAR(figure, 0.25, 1e-12);
  }
}

TEST(MeshDistance, MeasuresConcentricSpheres) {
  const mesh::Mesh inner = test::sphere(60, false);
  const mesh::Mesh outer = scaled(test::sphere(45, false), 1.25F);
  const MeshDistance d = distance(inner, outer);
  // The facets of 45 rings are less than 1.25 * (1 - cos(pi / 92)) = 0.0008 inside their sphere.
  expect_interval(d, 0.25, 1e-3);
  EXPECT_NEAR(d.mean, 0.25, 2e-3);
  EXPECT_NEAR(d.rms, 0.25, 2e-3);
  EXPECT_NEAR(glm::length(d.b_to_a.place), 1.25, 1e-3);
  EXPECT_NEAR(glm::length(d.b_to_a.place - d.b_to_a.nearest), d.b_to_a.max_lower, 1e-12);
}

// Near the center all of a sphere is equally far and every search visits all of it. The limit ends the search, and the
// interval still holds.
TEST(MeshDistance, LimitsSearchFromCenterOfSphere) {
  const mesh::Mesh speck = make_mesh("speck", {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}}, {{0, 1, 2}});
  const MeshDistance d = distance(speck, test::sphere(60, false));
  // The farthest point of the sphere is opposite the speck; the nearest facets are less than 0.0004 inside the sphere.
  expect_interval(d, 1, 2e-3);
}

TEST(MeshDistance, IsZeroForOtherTessellation) {
  for (const unsigned n : {1U, 2U, 3U, 10U, 33U}) {
    const MeshDistance d = distance(cube(1), cube(n));
    EXPECT_LE(d.hausdorff_upper, d.resolution) << n;
    EXPECT_LE(d.rms, d.resolution) << n;
  }
  const mesh::Mesh ball = test::sphere(20, false);
  EXPECT_LE(distance(ball, ball).hausdorff_upper, 1e-15);
}

// Equal triangles in another order, winding and vertex order, with another sign of zeros.
TEST(MeshDistance, IsZeroForEqualTriangles) {
  std::mt19937 random(5);
  for (const glm::dvec3& origin : {glm::dvec3(0), glm::dvec3(1e7, -3.25, 0.1)}) {
    const mesh::Mesh a = test::sphere(33, false, "a", origin);
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles(a.triangles.begin(), a.triangles.end());
    std::shuffle(triangles.begin(), triangles.end(), random);
    for (glm::uvec3& t : triangles) {
      const auto first = static_cast<unsigned>(positions.size());
      for (int c = 0; c < 3; ++c) {
        glm::vec3 p = a.positions[t[c]];
        for (int axis = 0; axis < 3; ++axis) {
          if (p[axis] == 0 && first % 2 == 0) p[axis] = -p[axis];
        }
        positions.push_back(p);
      }
      t = first % 2 == 0 ? glm::uvec3(first + 1, first + 2, first) : glm::uvec3(first + 2, first + 1, first);
    }
    const mesh::Mesh b = make_mesh("b", positions, triangles, {}, origin);
    for (const MeshDistance& d : {distance(a, a), distance(a, b), distance(b, a)}) {
      for (const double figure : {d.hausdorff_lower, d.hausdorff_upper, d.rms, d.mean, d.percentile99,
                                  d.a_to_b.max_upper, d.b_to_a.max_upper, d.a_to_b.rms, d.b_to_a.rms}) {
        EXPECT_EQ(figure, 0);
      }
      EXPECT_NEAR(glm::length(d.a_to_b.place - origin), 1, 1e-6) << "a point of the surface";
      EXPECT_EQ(d.a_to_b.place, d.a_to_b.nearest);
    }
    // Only the additional triangle is measured.
    triangles.emplace_back(0, 4, 8);
    const mesh::Mesh more = make_mesh("more", positions, triangles, {}, origin);
    EXPECT_EQ(distance(a, more).a_to_b.max_upper, 0);
    EXPECT_GT(distance(a, more).b_to_a.max_lower, 0.001);
  }
}

TEST(MeshDistance, FindsMovedVertex) {
  const mesh::Mesh flat = plane(10, 0);
  mesh::Mesh raised = plane(10, 0);
  constexpr std::size_t kMoved = 5 * 11 + 4;
  raised.positions[kMoved].z = 0.01F;
  const MeshDistance d = distance(raised, flat);
  EXPECT_FLOAT_EQ(static_cast<float>(d.a_to_b.max_lower), 0.01F);
  EXPECT_EQ(d.a_to_b.place, glm::dvec3(raised.positions[kMoved]));
  EXPECT_GE(d.a_to_b.max_upper, d.a_to_b.max_lower);
  // The flat point below is nearer to the slopes than to the raised vertex.
  EXPECT_LT(d.b_to_a.max_upper, 0.01);
  EXPECT_GT(d.b_to_a.max_lower, 0.009);
  EXPECT_LT(d.a_to_b.mean, 0.001);
}

TEST(MeshDistance, FindsFarthestPointInsideTriangle) {
  // A right triangle and its own three sides as zero-area triangles: the center of the inscribed circle is farthest, at
  // its radius.
  const mesh::Mesh full = make_mesh("full", {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, {{0, 1, 2}});
  const mesh::Mesh frame = make_mesh("frame", {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, {{0, 1, 1}, {1, 2, 2}, {2, 0, 0}});
  DistanceOptions options;
  options.samples = 0;
  const MeshDistance d = distance(full, frame, options);
  expect_interval(d, 1, 0);
  EXPECT_NEAR(glm::length(d.a_to_b.place - glm::dvec3(1, 1, 0)), 0, 0.05);
  EXPECT_EQ(d.b_to_a.max_upper, 0);
  EXPECT_EQ(d.rms, 0);
}

TEST(MeshDistance, MatchesBruteForceOnRandomMeshes) {
  std::mt19937 random(3);
  for (int round = 0; round < 30; ++round) {
    const mesh::Mesh a = random_soup(random, 1 + static_cast<unsigned>(round), 0.7F);
    const mesh::Mesh b = random_soup(random, 40, 0.4F);
    DistanceOptions options;
    options.samples = 1000;
    const MeshDistance d = distance(a, b, options);
    double farthest = 0;
    constexpr int kSteps = 30;
    for (const glm::uvec3& t : a.triangles) {
      for (int i = 0; i <= kSteps; ++i) {
        for (int j = 0; i + j <= kSteps; ++j) {
          const double u = static_cast<double>(i) / kSteps;
          const double v = static_cast<double>(j) / kSteps;
          const glm::dvec3 p = (1 - u - v) * glm::dvec3(a.positions[t.x]) + u * glm::dvec3(a.positions[t.y]) +
                               v * glm::dvec3(a.positions[t.z]);
          farthest = std::max(farthest, brute_distance(p, b));
        }
      }
    }
    EXPECT_LE(farthest, d.a_to_b.max_upper) << round;
    EXPECT_GE(farthest, d.a_to_b.max_lower - 0.06) << round;  // the samples' step
    EXPECT_NEAR(brute_distance(d.a_to_b.place, b), d.a_to_b.max_lower, 1e-12) << round;
    EXPECT_LE(d.a_to_b.max_upper, d.a_to_b.max_lower * 1.0100001 + d.resolution) << round;
    EXPECT_LE(d.a_to_b.percentile99, d.a_to_b.max_upper) << round;
    EXPECT_LE(d.a_to_b.mean, d.a_to_b.rms) << round;
  }
}

TEST(MeshDistance, IgnoresOrderAndWinding) {
  std::mt19937 random(4);
  const mesh::Mesh a = random_soup(random, 30, 0.5F);
  const mesh::Mesh b = random_soup(random, 50, 0.3F);
  const MeshDistance ab = distance(a, b);
  const MeshDistance ba = distance(b, a);
  EXPECT_EQ(ab.a_to_b.max_lower, ba.b_to_a.max_lower);
  EXPECT_EQ(ab.a_to_b.max_upper, ba.b_to_a.max_upper);
  EXPECT_EQ(ab.hausdorff_upper, ba.hausdorff_upper);
  EXPECT_EQ(ab.percentile99, ba.percentile99);
  EXPECT_NEAR(ab.rms, ba.rms, 1e-12);

  mesh::Mesh turned = make_mesh("turned", {a.positions.begin(), a.positions.end()}, {});
  turned.triangles = Buffer<glm::uvec3>(a.triangles.size());
  for (std::size_t t = 0; t < a.triangles.size(); ++t)
    turned.triangles[t] = {a.triangles[t].x, a.triangles[t].z, a.triangles[t].y};
  EXPECT_LE(distance(a, turned).hausdorff_upper, ab.resolution);

  // Both meshes mirrored at x = 0 have the same distances.
  const auto mirrored = [](const mesh::Mesh& mesh) {
    mesh::Mesh image = make_mesh("image", {mesh.positions.begin(), mesh.positions.end()},
                                 {mesh.triangles.begin(), mesh.triangles.end()});
    for (glm::vec3& p : image.positions) p.x = -p.x;
    return image;
  };
  const MeshDistance images = distance(mirrored(a), mirrored(b));
  EXPECT_NEAR(images.hausdorff_lower, ab.hausdorff_lower, 0.01 * ab.hausdorff_lower);
  EXPECT_NEAR(images.rms, ab.rms, 1e-9);
}

TEST(MeshDistance, KeepsAccuracyAtFarOrigins) {
  const mesh::Mesh near = test::sphere(20, false);
  const mesh::Mesh far = test::sphere(20, false, "far", {1e7, -1e7, 1e7});
  const mesh::Mesh moved = test::sphere(20, false, "moved", {1e7 + 0x1p-10, -1e7, 1e7});
  EXPECT_LE(distance(far, far).hausdorff_upper, 1e-15);
  const MeshDistance d = distance(far, moved);
  EXPECT_LE(d.hausdorff_lower, 0x1p-10);
  EXPECT_NEAR(d.hausdorff_upper, 0x1p-10, 0.02 * 0x1p-10);
  EXPECT_NEAR(d.a_to_b.place.x, 1e7, 1.01);
  EXPECT_NEAR(distance(near, far).hausdorff_lower, std::sqrt(3.0) * 1e7, 2);
}

TEST(MeshDistance, IsIndependentOfThreads) {
  const mesh::Mesh a = test::sphere(40, false);
  mesh::Mesh b = test::sphere(33, false);
  for (glm::vec3& p : b.positions) p.z += 0.1F * std::sin(5 * p.x);
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return distance(a, b);
  };
  const MeshDistance one = with_threads(1);
  const MeshDistance four = with_threads(4);
  EXPECT_EQ(std::memcmp(&one, &four, sizeof one), 0);
}

TEST(MeshDistance, StopsBelowSufficientDistance) {
  const mesh::Mesh a = test::sphere(40, false);
  const mesh::Mesh b = test::sphere(12, false);
  DistanceOptions options;
  options.samples = 0;
  const MeshDistance exact = distance(a, b, options);
  options.enough = 2 * exact.hausdorff_upper;
  const MeshDistance rough = distance(a, b, options);
  EXPECT_GE(rough.hausdorff_upper, exact.hausdorff_lower);
  EXPECT_LE(rough.hausdorff_upper, options.enough);
}

TEST(MeshDistance, RejectsEmptyMeshes) {
  const mesh::Mesh some = test::tetrahedron();
  mesh::Mesh none = make_mesh("nothing", {{0, 0, 0}}, {});
  for (const auto& result :
       {measure_distance(some, none, {}, Context()), measure_distance(none, some, {}, Context())}) {
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::input);
    EXPECT_NE(result.error().message.find("nothing, has no triangles"), std::string::npos);
    EXPECT_TRUE(result.error().hint.empty()) << "the cause is unknown, so there is no hint";
  }
}

// Squared distances would overflow, and no interval would contain the largest.
TEST(MeshDistance, RejectsMeshesTooFarApart) {
  const mesh::Mesh here = test::tetrahedron();
  for (const double place : {1e151, 1e308, std::numeric_limits<double>::infinity()}) {
    mesh::Mesh there = test::tetrahedron();
    there.origin.x = place;
    for (const auto& result :
         {measure_distance(here, there, {}, Context()), measure_distance(there, here, {}, Context())}) {
      ASSERT_FALSE(result) << place;
      EXPECT_EQ(result.error().code, ErrorCode::input);
      EXPECT_NE(result.error().message.find("1e+150 apart"), std::string::npos) << result.error().message;
    }
  }
  mesh::Mesh there = test::tetrahedron();
  there.origin.x = 1e149;
  EXPECT_NEAR(distance(here, there).hausdorff_upper / 1e149, 1, 1e-6);
}

// Vertices without a triangle do not belong to the surface.
TEST(MeshDistance, IgnoresUnusedVertices) {
  const mesh::Mesh a = make_mesh("a", {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-9, 0, 0}}, {{1, 2, 3}});
  const mesh::Mesh b = make_mesh("b", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  EXPECT_EQ(distance(a, b).hausdorff_upper, 0);
}

}  // namespace
}  // namespace isoextract::accuracy
