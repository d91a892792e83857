// Tests the extracted surfaces of particle fields.
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

#include "extract/extractor.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"
#include "support/data_folder.hpp"
#include "support/meshes.hpp"
#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

constexpr double kSurfaceRadius = 0.025;

FieldOptions options_of(Method method) {
  FieldOptions options;
  options.method = method;
  options.radius = kSurfaceRadius;
  return options;
}

mesh::Mesh surface_of(const ParticleField& made, double iso) {
  extract::ExtractOptions options;
  options.iso = iso;
  options.smooth_normals = true;
  options.output_from_index = made.field.index_to_world;
  return test::extract(made.field, options).mesh;
}

mesh::Mesh surface_of(const std::vector<glm::dvec3>& positions, const FieldOptions& options) {
  return surface_of(field_of(particles_at(positions), options), method_info(options.method).iso);
}

TEST(ParticleSurface, IsASphereForOneParticle) {
  for (const Method method : {Method::sph, Method::anisotropic}) {
    FieldOptions options = options_of(method);
    options.cell_size = 0.25;
    const glm::dvec3 center(3.01, -2.02, 7.3);
    const mesh::Mesh mesh = surface_of({center}, options);
    test::expect_sound(mesh, true);
    EXPECT_EQ(mesh::measure_topology(mesh).components, 1U);
    // The field of an isolated particle is W / W(0), which is 0.6 at about a third of the support. Its anisotropic
    // kernel is half as long and eight times as high.
    double low = 1;
    double high = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const double distance = glm::length(mesh.position(v) - center);
      low = std::min(low, distance);
      high = std::max(high, distance);
    }
    EXPECT_GT(low, 0.8 * kSurfaceRadius) << word_of(method);
    EXPECT_LT(high, 1.6 * kSurfaceRadius) << word_of(method);
    EXPECT_LT(high - low, 0.05 * kSurfaceRadius) << word_of(method);
  }
}

// Returns the relative difference between the volume of a ball's surface and that of its particles.
double volume_error(Method method, double particle_radius) {
  FieldOptions options = options_of(method);
  options.radius = particle_radius;
  const std::vector<glm::dvec3> positions = lattice_ball(particle_radius, 0.5);
  const mesh::Mesh mesh = surface_of(positions, options);
  test::expect_sound(mesh, true);
  EXPECT_EQ(mesh::measure_topology(mesh).components, 1U);
  const double expected = static_cast<double>(positions.size()) * std::pow(2 * particle_radius, 3);
  return std::abs(mesh::measure_size(mesh).volume / expected - 1);
}

TEST(ParticleSurface, ApproximatesTheVolumeOfABallToFirstOrder) {
  for (const auto& [method, offset] :
       {std::pair(Method::sph, 0.2), std::pair(Method::anisotropic, 0.15), std::pair(Method::weight, 2.5)}) {
    for (const double radius : {0.05, 0.025, 0.0125}) {
      // Error of a surface that is `offset` radii too far in or out: area / volume is 3 / 0.5.
      EXPECT_LT(volume_error(method, radius), 6 * offset * radius) << word_of(method) << " " << radius;
    }
  }
}

TEST(ParticleSurface, IsFlatForABlock) {
  const double half = 0.4;
  const mesh::Mesh mesh =
      surface_of(lattice(kSurfaceRadius, 8, [](const glm::dvec3&) { return true; }), options_of(Method::sph));
  double low = 1;
  double high = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3 p = mesh.position(v);
    if (std::abs(p.y) > half - 0.1 || std::abs(p.z) > half - 0.1 || p.x < 0) continue;
    low = std::min(low, p.x);
    high = std::max(high, p.x);
  }
  EXPECT_GT(high, low);
  EXPECT_LT(high - low, 0.1 * kSurfaceRadius);
  EXPECT_NEAR(high, half + kSurfaceRadius, 0.3 * kSurfaceRadius) << "a radius beyond the outermost centres";
}

template <class T>
bool equal_bytes(const Buffer<T>& a, const Buffer<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

TEST(ParticleSurface, IsTheSameWithInsideTiles) {
  // Varying density, and a hole.
  std::vector<glm::dvec3> positions = lattice_ball(kSurfaceRadius, 0.75, 0.4);
  std::erase_if(positions, [](const glm::dvec3& p) { return glm::length(p - glm::dvec3(0.3, 0, 0)) < 0.06; });
  const ParticleSet particles = particles_at(positions);
  for (const auto& [method, cell] :
       {std::pair(Method::sph, 0.5), std::pair(Method::sph, 0.75), std::pair(Method::anisotropic, 0.5)}) {
    FieldOptions options = options_of(method);
    options.cell_size = cell;
    const double iso = method_info(method).iso;
    const mesh::Mesh whole = surface_of(field_of(particles, options), iso);
    options.tile_iso = iso;
    const ParticleField left_out = field_of(particles, options);
    EXPECT_GT(left_out.figures.inside_tiles, 15U);
    EXPECT_GT(left_out.figures.particles_deep_inside, 20U);
    EXPECT_LT(left_out.figures.particles_deep_inside, positions.size());
    const mesh::Mesh mesh = surface_of(left_out, iso);
    EXPECT_EQ(mesh.origin, whole.origin);
    EXPECT_TRUE(equal_bytes(mesh.positions, whole.positions));
    EXPECT_TRUE(equal_bytes(mesh.normals, whole.normals));
    EXPECT_TRUE(equal_bytes(mesh.triangles, whole.triangles));
  }
}

TEST(ParticleSurface, HasNoTilesForIsoValuesOfOneAndMore) {
  FieldOptions options = options_of(Method::sph);
  options.tile_iso = 1.0;
  EXPECT_EQ(field_of(particles_at(lattice_ball(kSurfaceRadius, 0.5)), options).figures.inside_tiles, 0U);
}

TEST(ParticleSurface, IsSmootherWithAnisotropicKernels) {
  const std::vector<glm::dvec3> positions = lattice_ball(kSurfaceRadius, 0.5, 0.4);
  // Ratio of the area to that of a ball with the same volume.
  const auto roughness = [&](Method method) {
    const mesh::MeshSize size = mesh::measure_size(surface_of(positions, options_of(method)));
    return size.area / (std::cbrt(36 * std::numbers::pi) * std::pow(size.volume, 2.0 / 3));
  };
  EXPECT_LT(roughness(Method::anisotropic) - 1, 0.5 * (roughness(Method::sph) - 1));
}

TEST(ParticleSurface, KeepsTheThicknessOfASheetWithAnisotropicKernels) {
  // One and two layers: the surface is about a radius beyond the particles.
  for (const int layers : {1, 2}) {
    const std::vector<glm::dvec3> positions = lattice(
        kSurfaceRadius, 12, [&](const glm::dvec3& p) { return p.z > 0 && p.z < 2 * kSurfaceRadius * (layers + 0.5); });
    const auto [low, high] = std::ranges::minmax(positions, {}, &glm::dvec3::z);
    const mesh::Mesh mesh = surface_of(positions, options_of(Method::anisotropic));
    test::expect_sound(mesh, true);
    double above = 0;
    double below = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const glm::dvec3 p = mesh.position(v);
      if (std::max(std::abs(p.x), std::abs(p.y)) > 0.25) continue;
      above = std::max(above, (p.z - high.z) / kSurfaceRadius);
      below = std::max(below, (low.z - p.z) / kSurfaceRadius);
    }
    EXPECT_NEAR(above, 1, 0.15) << layers;
    EXPECT_NEAR(below, 1, 0.15) << layers;
  }
}

// Returns the content of a file of the data folder, decompressed if necessary.
std::string content_of(const std::string& name) {
  std::string bytes(1 << 20, '\0');
  gzFile file = gzopen(test::data_file(name).c_str(), "rb");
  const int read = gzread(file, bytes.data(), static_cast<unsigned>(bytes.size()));
  gzclose(file);
  bytes.resize(static_cast<std::size_t>(std::max(read, 0)));
  return bytes;
}

// Reads a big-endian float32.
float big_endian_float(const char* bytes) {
  std::uint32_t bits = 0;
  for (int n = 0; n < 4; ++n) bits = bits << 8U | static_cast<unsigned char>(bytes[n]);
  float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

std::vector<glm::dvec3> places_in(const std::string& bytes, std::size_t offset, std::size_t count, std::size_t stride) {
  std::vector<glm::dvec3> positions;
  for (std::size_t i = 0; i < count && offset + stride * (i + 1) <= bytes.size(); ++i) {
    const char* at = bytes.data() + offset + stride * i;
    positions.emplace_back(big_endian_float(at), big_endian_float(at + 4), big_endian_float(at + 8));
  }
  EXPECT_EQ(positions.size(), count);
  return positions;
}

// splashsurf's own test expects this number of triangles for this file and these parameters.
TEST(RealParticles, MatchSplashsurfOnOctocat) {
  ISOEXTRACT_NEEDS_DATA("particles/octocat_32614_particles.bgeo");
  const std::string bytes = content_of("particles/octocat_32614_particles.bgeo");
  FieldOptions options = options_of(Method::sph);
  options.smoothing_length = 2;
  options.cell_size = 0.75;
  const mesh::Mesh mesh = surface_of(places_in(bytes, 41, 32614, 16), options);  // x, y, z, w after the header
  test::expect_sound(mesh, true);
  EXPECT_GT(mesh.triangles.size(), 140000U);
  EXPECT_LT(mesh.triangles.size(), 180000U);
}

// A lattice of touching particles: faces are flat and about one radius outside the outermost centers.
TEST(RealParticles, HaveFlatFacesInDamBreak) {
  ISOEXTRACT_NEEDS_DATA("particles/double_dam_break_frame_01_4732_particles.vtk");
  const std::string bytes = content_of("particles/double_dam_break_frame_01_4732_particles.vtk");
  const std::size_t points = bytes.find("POINTS 4732");
  ASSERT_NE(points, std::string::npos);
  const std::vector<glm::dvec3> positions = places_in(bytes, bytes.find('\n', points) + 1, 4732, 12);
  const mesh::Mesh mesh = surface_of(positions, options_of(Method::sph));
  test::expect_sound(mesh, true);
  EXPECT_EQ(mesh::measure_topology(mesh).components, 2U);
  const double top = std::ranges::max_element(positions, {}, [](const glm::dvec3& p) { return p.y; })->y;
  // Returns whether the top layer has a particle at (x, z).
  const auto covered = [&](double x, double z) {
    return std::ranges::any_of(positions, [&](const glm::dvec3& q) {
      return q.y > top - 0.01 && std::abs(q.x - x) < 0.03 && std::abs(q.z - z) < 0.03;
    });
  };
  double low = 10;
  double high = -10;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3 p = mesh.position(v);
    // Checks the upper faces without their rims.
    if (p.y < top || !covered(p.x + 0.1, p.z + 0.1) || !covered(p.x - 0.1, p.z - 0.1)) continue;
    if (!covered(p.x + 0.1, p.z - 0.1) || !covered(p.x - 0.1, p.z + 0.1)) continue;
    low = std::min(low, p.y);
    high = std::max(high, p.y);
  }
  ASSERT_GT(high, low);
  EXPECT_LT(high - low, 0.1 * kSurfaceRadius);
}

}  // namespace
}  // namespace isoextract::points
