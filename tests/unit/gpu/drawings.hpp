// The ways in which a GPU can draw a mesh, and the comparison with the CPU mesh.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "extract/extractor.hpp"
#include "gpu/gpu_extractor.hpp"
#include "support/meshes.hpp"

namespace isoextract::test {

inline extract::ExtractOptions at_iso(double iso) {
  extract::ExtractOptions options;
  options.iso = iso;
  return options;
}

struct Drawing {
  extract::Method method = extract::Method::mc;
  bool tessellation = true;
  bool swizzle = true;
};

// The default, for most tests, and all ways.
inline constexpr std::array kUsualDrawings{Drawing{extract::Method::mc, true, true},
                                           Drawing{extract::Method::mt, true, true}};
inline constexpr std::array kAllDrawings{
    Drawing{extract::Method::mc, true, true},  Drawing{extract::Method::mc, true, false},
    Drawing{extract::Method::mc, false, true}, Drawing{extract::Method::mc, false, false},
    Drawing{extract::Method::mt, true, true},  Drawing{extract::Method::mt, true, false}};

inline std::string words(const Drawing& drawing) {
  if (drawing.method == extract::Method::mt) return drawing.swizzle ? "mt" : "mt row by row";
  return std::string("mc by ") + (drawing.tessellation ? "tessellation" : "points") +
         (drawing.swizzle ? "" : " row by row");
}

// One extractor for each set of options, opened at first use and destroyed before the program ends. Messages of the
// driver are errors.
class GpuExtractors final : public testing::Environment {
 public:
  extract::Extractor* find(const Drawing& drawing) {
    auto& extractor = extractors_[{drawing.tessellation, drawing.swizzle}];
    if (extractor == nullptr) {
      gpu::GpuOptions options;
      options.tessellation = drawing.tessellation;
      options.swizzle = drawing.swizzle;
      options.debug = true;
      auto made = gpu::make_gpu_extractor(options);
      if (!made) {
        ADD_FAILURE() << made.error().message;
        return nullptr;
      }
      extractor = std::move(made->extractor);
    }
    return extractor.get();
  }
  void TearDown() override { extractors_.clear(); }

 private:
  std::map<std::pair<bool, bool>, std::unique_ptr<extract::Extractor>> extractors_;
};

inline auto* const kGpuExtractors =
    static_cast<GpuExtractors*>(testing::AddGlobalTestEnvironment(new GpuExtractors));  // gtest owns it

inline extract::Extraction extract_on_gpu(const field::ScalarField& field, const extract::ExtractOptions& options,
                                          const Drawing& drawing = {}) {
  extract::Extractor* gpu = kGpuExtractors->find(drawing);
  if (gpu == nullptr) return {};
  Result<extract::Extraction> result = gpu->extract(field, options, Context());
  if (!result) {
    ADD_FAILURE() << result.error().message;
    return {};
  }
  return std::move(*result);
}

using KeyTriangle = std::array<mesh::EdgeKey, 3>;

// Returns triangles as edge keys, starting at the lowest: independent of order, but not of winding.
inline std::vector<KeyTriangle> key_triangles(const mesh::Mesh& mesh) {
  std::vector<KeyTriangle> set;
  set.reserve(mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles) {
    KeyTriangle keys{mesh.edges[t.x], mesh.edges[t.y], mesh.edges[t.z]};
    std::ranges::rotate(keys, std::ranges::min_element(keys, std::less<>()));
    set.push_back(keys);
  }
  std::ranges::sort(set, std::less<>());
  return set;
}

// Returns a unit in the last place of the mesh's local coordinates.
inline double local_unit(const mesh::Mesh& mesh) {
  float largest = 0;
  for (const glm::vec3& p : mesh.positions) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return static_cast<double>(std::nextafter(largest, std::numeric_limits<float>::infinity())) -
         static_cast<double>(largest);
}

// Returns the angle in degrees; exact for small angles, unlike an arc cosine.
inline double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 57.29577951308232;
}

// Expects equal surfaces; both meshes need edge keys. Vertices with the same key (split at holes) have the same
// position and normal.
inline void expect_same_surface(const mesh::Mesh& cpu, const mesh::Mesh& gpu) {
  constexpr double kUnits = 2;  // in the last place of the local coordinates
  constexpr double kDegrees = 0.01;
  EXPECT_EQ(cpu.origin, gpu.origin);
  EXPECT_EQ(cpu.name, gpu.name);
  ASSERT_EQ(cpu.positions.size(), gpu.positions.size());
  ASSERT_EQ(cpu.normals.size(), gpu.normals.size());
  ASSERT_EQ(cpu.edges.size(), gpu.edges.size());
  ASSERT_EQ(cpu.triangles.size(), gpu.triangles.size());
  ASSERT_TRUE(key_triangles(cpu) == key_triangles(gpu)) << "other triangles";
  const auto by_key = [](const mesh::Mesh& mesh) {
    std::vector<std::size_t> order(mesh.edges.size());
    for (std::size_t v = 0; v < order.size(); ++v) order[v] = v;
    std::ranges::stable_sort(order, std::less<>(), [&](std::size_t v) { return mesh.edges[v]; });
    return order;
  };
  const auto a = by_key(cpu);
  const auto b = by_key(gpu);
  const double unit = local_unit(cpu);
  double units = 0;
  double degrees = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    ASSERT_TRUE(cpu.edges[a[n]] == gpu.edges[b[n]]);
    const glm::dvec3 away = glm::abs(glm::dvec3(cpu.positions[a[n]]) - glm::dvec3(gpu.positions[b[n]]));
    for (int axis = 0; axis < 3; ++axis) ASSERT_TRUE(std::isfinite(gpu.positions[b[n]][axis]));
    units = std::max({units, away.x / unit, away.y / unit, away.z / unit});
    if (cpu.normals.empty()) continue;
    ASSERT_NEAR(glm::length(gpu.normals[b[n]]), 1, 1e-5);
    degrees = std::max(degrees, angle_between(cpu.normals[a[n]], gpu.normals[b[n]]));
  }
  EXPECT_LE(units, kUnits);
  EXPECT_LE(degrees, kDegrees);
}

inline void expect_same_bytes(const mesh::Mesh& a, const mesh::Mesh& b) {
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_TRUE(std::ranges::equal(a.positions, b.positions)) << "positions";
  EXPECT_TRUE(std::ranges::equal(a.normals, b.normals)) << "normals";
  EXPECT_TRUE(std::ranges::equal(a.edges, b.edges)) << "edges";
  EXPECT_TRUE(std::ranges::equal(a.triangles, b.triangles)) << "triangles";
}

// Expects that each drawing gives the CPU mesh, or the same error. Returns the number of triangles of the last one.
template <class Drawings>
std::size_t expect_parity(const field::ScalarField& field, extract::ExtractOptions options, const Drawings& drawings) {
  options.edge_keys = true;
  std::size_t triangles = 0;
  for (const Drawing& drawing : drawings) {
    SCOPED_TRACE(words(drawing));
    extract::Extractor* gpu = kGpuExtractors->find(drawing);
    if (gpu == nullptr) return 0;
    options.method = drawing.method;
    const auto expected = extract::make_cpu_extractor()->extract(field, options, Context());
    const auto found = gpu->extract(field, options, Context());
    EXPECT_EQ(expected.has_value(), found.has_value());
    if (!expected || !found) {
      if (!found && expected) ADD_FAILURE() << found.error().message;
      if (!found && !expected) {
        EXPECT_EQ(expected.error().code, found.error().code);
        EXPECT_EQ(expected.error().message, found.error().message);
      }
      continue;
    }
    expect_same_surface(expected->mesh, found->mesh);
    EXPECT_EQ(expected->stats.nan_samples, found->stats.nan_samples);
    EXPECT_EQ(expected->stats.hole_cells, found->stats.hole_cells);
    EXPECT_EQ(expected->stats.inside_at_boundary, found->stats.inside_at_boundary);
    EXPECT_EQ(expected->stats.meets_boundary, found->stats.meets_boundary);
    if (drawing.method == extract::Method::mt && found->stats.device) {
      EXPECT_EQ(found->stats.device->cells_decided, 0U) << "nothing is ambiguous";
    }
    EXPECT_EQ(expected->stats.samples_classified, found->stats.samples_classified);
    triangles = found->mesh.triangles.size();
  }
  return triangles;
}

inline std::size_t expect_parity(const field::ScalarField& field, const extract::ExtractOptions& options) {
  return expect_parity(field, options, kUsualDrawings);
}

}  // namespace isoextract::test
