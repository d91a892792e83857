#include "accuracy/mesh_match.hpp"

#include <limits>
#include <map>
#include <tuple>

#include <gtest/gtest.h>

#include "accuracy/float_spacing.hpp"
#include "field/demo_field.hpp"
#include "mesh/local_origin.hpp"
#include "support/fields.hpp"
#include "support/mesh_copies.hpp"
#include "support/meshes.hpp"

namespace isoextract::accuracy {
namespace {

MeshMatch match(const mesh::Mesh& written, const mesh::Mesh& extracted, bool float32_world = false) {
  return match_written_mesh(written, extracted, float32_world, Context()).value();
}

std::string told(const MeshMatch& found) {
  std::string text;
  for (const std::string& sentence : differences(found, {"file", "volume"})) text += sentence + "\n";
  return text;
}

// Returns what the reader makes of a file's coordinates: float32 relative to an origin that it chooses.
mesh::Mesh reread(const mesh::Mesh& mesh, bool float32_world) {
  std::vector<glm::vec3> rounded;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) rounded.emplace_back(mesh.position(v));
  const auto stored = [&](std::size_t v) { return float32_world ? glm::dvec3(rounded[v]) : mesh.position(v); };
  glm::dvec3 low = stored(0);
  glm::dvec3 high = low;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    low = glm::min(low, stored(v));
    high = glm::max(high, stored(v));
  }
  mesh::Mesh result = test::copy_of(mesh);
  result.origin = mesh::choose_local_origin(low, high);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) result.positions[v] = stored(v) - result.origin;
  return result;
}

// Merges vertices at the same place, as the reader does for formats without connectivity.
mesh::Mesh welded(const mesh::Mesh& mesh) {
  std::map<test::Point, std::uint32_t> numbers;
  std::vector<glm::vec3> positions;
  mesh::Mesh result = test::copy_of(mesh);
  for (glm::uvec3& t : result.triangles) {
    for (int c = 0; c < 3; ++c) {
      const glm::vec3 p = mesh.positions[t[c]];
      const auto [found, added] = numbers.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(positions.size()));
      if (added) positions.push_back(p);
      t[c] = found->second;
    }
  }
  result.positions = Buffer<glm::vec3>(positions.size());
  std::copy(positions.begin(), positions.end(), result.positions.begin());
  return result;
}

class MeshMatchTest : public testing::TestWithParam<extract::Method> {
 protected:
  [[nodiscard]] extract::ExtractOptions options() const {
    extract::ExtractOptions o;
    o.method = GetParam();
    return o;
  }
  [[nodiscard]] mesh::Mesh torus(const field::Affine& place = {}) const {
    extract::ExtractOptions o = options();
    o.output_from_index = place;
    return test::extract(field::make_demo_field("demo:torus?size=24", Context()).value(), o).mesh;
  }
  // Few distinct values, among them the iso value: many pairs of vertices are as close as possible.
  [[nodiscard]] mesh::Mesh ties(const field::Affine& place = {}) const {
    extract::ExtractOptions o = options();
    o.iso = 2;
    o.output_from_index = place;
    return test::extract(test::random_field<float>({20, 20, 20}, 3, 5), o).mesh;
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, MeshMatchTest, testing::Values(extract::Method::mc, extract::Method::mt),
                         test::method_name);

TEST_P(MeshMatchTest, IgnoresOrder) {
  for (const mesh::Mesh& mesh : {torus(), ties()}) {
    const MeshMatch found = match(test::shuffled(mesh, 1), mesh);
    EXPECT_EQ(told(found), "");
    EXPECT_EQ(found.distance, glm::dvec3(0));
    EXPECT_EQ(found.vertices[0], mesh.positions.size());
    EXPECT_EQ(found.triangles.total[1], mesh.triangles.size());
  }
}

TEST_P(MeshMatchTest, MatchesFarFramesAsStoredByPlyObjAndStl) {
  for (const double far : {1e3, 1e6, 1e9}) {
    SCOPED_TRACE(far);
    const field::Affine place{glm::dmat3(0.1), glm::dvec3(far, -far / 3, 7)};
    for (const mesh::Mesh& mesh : {torus(place), ties(place)}) {
      ASSERT_NE(mesh.origin, glm::dvec3(0));
      const MeshMatch in_double = match(test::shuffled(reread(mesh, false), 2), mesh);
      EXPECT_EQ(told(in_double), "");
      EXPECT_TRUE(glm::all(glm::lessThanEqual(in_double.distance, in_double.allowed)));
      // Float32 merges the same vertices on both sides.
      const mesh::Mesh as_stl = welded(reread(mesh, true));
      if (far == 1e9) {
        EXPECT_LT(as_stl.positions.size(), mesh.positions.size());
      }
      EXPECT_EQ(told(match(test::shuffled(as_stl, 3), mesh, true)), "");
    }
  }
}

TEST_P(MeshMatchTest, MatchesSplitVerticesThatFormatsMerge) {
  std::mt19937 engine(3);
  const field::ScalarField field = test::dense_field<float>({16, 16, 16}, [&](int, int, int) {
    const auto random = static_cast<float>(engine() % 100);
    return random < 8 ? std::numeric_limits<float>::quiet_NaN() : random;
  });
  extract::ExtractOptions o = options();
  o.iso = 60;
  o.nan = extract::NanPolicy::hole;
  const mesh::Mesh mesh = test::extract(field, o).mesh;
  ASSERT_LT(welded(mesh).positions.size(), mesh.positions.size());
  EXPECT_EQ(told(match(test::shuffled(welded(mesh), 3), mesh)), "");
  EXPECT_EQ(told(match(test::shuffled(mesh, 3), mesh)), "");
}

TEST_P(MeshMatchTest, FindsDroppedAndFlippedTriangles) {
  const mesh::Mesh mesh = torus();
  const MeshMatch dropped = match(test::without_triangle(mesh, 8), mesh);
  EXPECT_EQ(dropped.triangles.only[0], 0U);
  EXPECT_EQ(dropped.triangles.only[1], 1U);
  EXPECT_NE(told(dropped).find("triangles are in volume only"), std::string::npos);
  mesh::Mesh flipped = test::shuffled(mesh, 4);
  std::swap(flipped.triangles[8].y, flipped.triangles[8].z);
  const MeshMatch found = match(flipped, mesh);
  EXPECT_EQ(found.triangles.only[0], 1U);
  EXPECT_EQ(found.triangles.only[1], 1U);
  EXPECT_EQ(found.vertices_only[0], 0U);
}

TEST_P(MeshMatchTest, FindsMovedVertex) {
  const mesh::Mesh mesh = torus();
  const double ulp = float_spacing(23);
  for (const int ulps : {1, 2, 5, 1000}) {
    mesh::Mesh moved = test::copy_of(mesh);
    moved.positions[30].y = static_cast<float>(static_cast<double>(moved.positions[30].y) + ulps * ulp);
    const MeshMatch found = match(test::shuffled(moved, 2), mesh);
    EXPECT_EQ(told(found).empty(), ulps <= 2) << ulps;
    if (ulps <= 2) {
      EXPECT_NEAR(found.distance.y, ulps * ulp, ulp / 2);
      EXPECT_EQ(found.farthest, moved.position(30));
    } else {
      EXPECT_EQ(found.vertices_only[0], 1U);
      EXPECT_EQ(found.vertices_only[1], 1U);
      EXPECT_EQ(found.vertex_example[0], moved.position(30));
      EXPECT_GT(found.triangles.only[0], 2U) << "all around it";
    }
  }
}

// Two vertices are within the limit of the same vertex, but only one may match it.
TEST_P(MeshMatchTest, MatchesOneToOne) {
  const mesh::Mesh mesh = torus();
  mesh::Mesh other = test::copy_of(mesh);
  other.positions[3] = mesh.positions[40];
  other.positions[3].x += static_cast<float>(float_spacing(23));
  const MeshMatch found = match(other, mesh);
  EXPECT_EQ(found.vertices_only[0], 1U);
  EXPECT_EQ(found.vertices_only[1], 1U);
  EXPECT_EQ(found.vertex_example[0], other.position(3));
  EXPECT_EQ(found.vertex_example[1], mesh.position(3));
}

TEST_P(MeshMatchTest, FindsNothingInCommonWithOtherSurface) {
  const mesh::Mesh mesh = torus();
  const MeshMatch found = match(torus(field::Affine{glm::dmat3(1.0), glm::dvec3(1e-3)}), mesh);
  EXPECT_EQ(found.vertices_only[0], mesh.positions.size());
  EXPECT_EQ(found.triangles.only[0], mesh.triangles.size());
  EXPECT_EQ(found.triangles.only[1], mesh.triangles.size());
  // Farther away than cells can be numbered.
  mesh::Mesh far = test::copy_of(mesh);
  far.origin = glm::dvec3(1e200);
  EXPECT_EQ(match(far, mesh).vertices_only[1], mesh.positions.size());
}

TEST_P(MeshMatchTest, HandlesEmptyMeshesAndMemoryLimit) {
  const mesh::Mesh mesh = torus();
  EXPECT_EQ(told(match(mesh::Mesh{}, mesh::Mesh{})), "");
  EXPECT_EQ(match(mesh, mesh::Mesh{}).triangles.only[0], mesh.triangles.size());
  EXPECT_EQ(match(mesh::Mesh{}, mesh).triangles.only[1], mesh.triangles.size());
  const auto small = match_written_mesh(mesh, mesh, false, Context(MemoryBudget(1000)));
  ASSERT_FALSE(small);
  EXPECT_EQ(small.error().code, ErrorCode::out_of_memory);
}

}  // namespace
}  // namespace isoextract::accuracy
