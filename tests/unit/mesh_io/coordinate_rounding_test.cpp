#include "mesh_io/write/coordinate_rounding.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "support/hints.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using namespace test;

bool is_kept(const mesh::Mesh& mesh, MeshFormat format) {
  const auto kept = check_coordinate_rounding(mesh, "a.mesh", format);
  if (kept) return true;
  EXPECT_EQ(kept.error().code, ErrorCode::output);
  EXPECT_TRUE(test::has_step(kept.error().hint, Remedy::use, Setting::position));
  EXPECT_TRUE(kept.error().message.starts_with("a.mesh: expected ")) << kept.error().message;
  return false;
}

constexpr MeshFormat kDoubleFormats[] = {MeshFormat::glb, MeshFormat::gltf, MeshFormat::ply, MeshFormat::obj};

// A sphere of radius 1 whose triangles are about 0.1 wide.
mesh::Mesh ball(const glm::dvec3& origin) { return sphere(30, false, "ball", origin); }

TEST(WrittenPlaces, AcceptsOrdinaryMeshes) {
  for (const MeshFormatInfo& info : mesh_formats()) {
    for (const double far : {0.0, 4.0, 1000.0, -2000.0, 10000.0}) {
      EXPECT_TRUE(is_kept(ball({far, -far, far}), info.format)) << info.name << " " << far;
      EXPECT_TRUE(is_kept(ball({0, far, 0}), info.format)) << info.name << " " << far;
    }
    EXPECT_TRUE(is_kept(make_mesh("nothing", {}, {}, {}, {1e300, 0, 0}), info.format)) << info.name;
    EXPECT_TRUE(
        is_kept(make_mesh("no area", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}, {}, {1e9, 0, 0}), info.format));
  }
}

// If many samples equal the iso value, most triangles are slivers that float32 flattens at 1000. This is invisible.
TEST(WrittenPlaces, IgnoresSlivers) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  const auto strip = [&](float x, float width) {
    const auto first = static_cast<unsigned>(positions.size());
    for (int j = 0; j <= 20; ++j) {
      const float y = 0.1F * static_cast<float>(j);
      positions.insert(positions.end(), {{x, y, 0}, {x + width, y, 0}});
    }
    for (unsigned j = 0; j < 20; ++j) {
      const unsigned v = first + 2 * j;
      triangles.insert(triangles.end(), {{v, v + 1, v + 2}, {v + 1, v + 3, v + 2}});
    }
  };
  for (int i = 0; i < 20; ++i) {
    strip(0.1F * static_cast<float>(i), 0.1F - 2e-5F);
    strip(0.1F * static_cast<float>(i) + 0.1F - 2e-5F, 1e-5F);
    strip(0.1F * static_cast<float>(i) + 0.1F - 1e-5F, 1e-5F);
  }
  const mesh::Mesh mesh = make_mesh("ties", positions, triangles, {}, {1000, 1000, 1000});
  std::size_t flat = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const auto written = [&](std::uint32_t v) { return glm::dvec3(glm::vec3(mesh.position(v))); };
    const glm::dvec3 a = written(t.x);
    flat += glm::length(glm::cross(written(t.y) - a, written(t.z) - a)) == 0 ? 1 : 0;
  }
  EXPECT_GT(flat, mesh.triangles.size() / 3);
  EXPECT_TRUE(is_kept(mesh, MeshFormat::stl));
  const std::uint64_t collapsed =
      check_coordinate_rounding(mesh, "a.stl", MeshFormat::stl).value();  // with two corners at equal coordinates
  EXPECT_GT(collapsed, 0U);
  EXPECT_LE(collapsed, flat);
  EXPECT_EQ(check_coordinate_rounding(mesh, "a.ply", MeshFormat::ply).value(), 0U);
}

TEST(WrittenPlaces, RefusesFloat32BeforeDouble) {
  const mesh::Mesh far = ball({0, 1e7, 0});
  for (const MeshFormat format : kDoubleFormats) EXPECT_TRUE(is_kept(far, format));
  EXPECT_FALSE(is_kept(far, MeshFormat::stl));
  const Error error = check_coordinate_rounding(far, "far.stl", MeshFormat::stl).error();
  EXPECT_EQ(test::text_of(error.hint), "glb, gltf, ply, obj");
  for (const char* part : {"far.stl: ", "at 1e+07", "float32 are 1 apart", "about 0.08"}) {
    EXPECT_NE(error.message.find(part), std::string::npos) << error.message;
  }
}

TEST(WrittenPlaces, RefusesPositionsBeyondDouble) {
  for (const double far : {1e16, 1e20, 1e40, -1e300}) {
    for (const MeshFormatInfo& info : mesh_formats()) {
      const auto kept = check_coordinate_rounding(ball({0, 0, far}), "a", info.format);
      ASSERT_FALSE(kept) << info.name << " " << far;
      EXPECT_EQ(test::text_of(kept.error().hint), "") << info.name << " " << far;
    }
  }
  for (const MeshFormat format : kDoubleFormats) {
    EXPECT_TRUE(is_kept(ball({1e12, 0, 0}), format));
    EXPECT_FALSE(is_kept(ball({0, std::numeric_limits<double>::infinity(), 0}), format));
    EXPECT_FALSE(is_kept(ball({0, std::numeric_limits<double>::quiet_NaN(), 0}), format));
  }
}

// A huge mesh with an origin that only double can hold.
TEST(WrittenPlaces, RequiresFloat32TranslationsForGltf) {
  mesh::Mesh mesh = ball({1e40, 0, 0});
  for (glm::vec3& p : mesh.positions) p *= 1e37F;
  EXPECT_FALSE(is_kept(mesh, MeshFormat::glb));
  EXPECT_FALSE(is_kept(mesh, MeshFormat::gltf));
  EXPECT_FALSE(is_kept(mesh, MeshFormat::stl));
  EXPECT_TRUE(is_kept(mesh, MeshFormat::ply));
  EXPECT_EQ(test::text_of(check_coordinate_rounding(mesh, "a", MeshFormat::glb).error().hint), "ply, obj");
}

// Without an origin, numbers of any size are written unchanged.
TEST(WrittenPlaces, AcceptsUnroundedPositions) {
  const std::vector<glm::vec3> corners{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}};
  const std::vector<glm::uvec3> triangles{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  EXPECT_TRUE(is_kept(make_mesh("lattice", corners, triangles, {}, {0x1p25, -0x1p25, 0x1p25}), MeshFormat::stl));
  EXPECT_FALSE(is_kept(make_mesh("beside", corners, triangles, {}, {0x1p27, -0x1p27, 0x1p27}), MeshFormat::stl));
  mesh::Mesh large = ball({0, 0, 0});
  for (glm::vec3& p : large.positions) p *= 1e38F;
  EXPECT_TRUE(is_kept(large, MeshFormat::stl));
}

// The mean angle by which rounding tilts triangles grows with the spacing of the numbers.
TEST(WrittenPlaces, RefusesVisibleRounding) {
  // Numbers are 1/128 apart at the first place, 1/16 at the second.
  EXPECT_TRUE(is_kept(ball({0x1.8p16, 0x1.8p16, 0x1.8p16}), MeshFormat::stl));
  EXPECT_FALSE(is_kept(ball({0x1.8p19, 0x1.8p19, 0x1.8p19}), MeshFormat::stl));
}

TEST(WrittenPlaces, WritesNothingOfRefusedMesh) {
  const glm::dvec3 far(1e16, 0, 0);
  for (const MeshFormatInfo& info : mesh_formats()) {
    const TempFolder folder;
    const auto all = one(ball(far));
    const auto at_once = write_meshes(all, folder / "out", {info.format, false, false}, Context());
    ASSERT_FALSE(at_once) << info.name;
    EXPECT_EQ(at_once.error().code, ErrorCode::output);
    MeshWriter writer(folder / "out", {info.format, false, false}, Context());
    if (info.can_hold_several_meshes) {
      ASSERT_TRUE(writer.add(ball({0, 0, 0})));
    }
    ASSERT_FALSE(writer.add(ball(far)));
    const auto finished = writer.finish();
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().message, at_once.error().message);
    EXPECT_FALSE(fs::exists(folder / "out"));
  }
}

}  // namespace
}  // namespace isoextract::mesh_io
