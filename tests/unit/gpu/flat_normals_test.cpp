// Normals that the geometry shader takes from each triangle (Suravikin and Korobitsyn).
#include "captured_surface.hpp"
#include "drawings.hpp"
#include "field/demo_field.hpp"

namespace isoextract::gpu {
namespace {

class FlatNormals : public testing::TestWithParam<GpuPipeline> {};
INSTANTIATE_TEST_SUITE_P(Pipelines, FlatNormals,
                         testing::Values(GpuPipeline::mt_geometry, GpuPipeline::mc_tessellation,
                                         GpuPipeline::mc_points),
                         [](const auto& parameter) {
                           return std::string(parameter.param == GpuPipeline::mt_geometry ? "mt"
                                              : parameter.param == GpuPipeline::mc_points ? "mc_by_points"
                                                                                          : "mc_by_tessellation");
                         });

TEST_P(FlatNormals, EqualTriangleNormals) {
  const auto field = field::make_demo_field("demo:gyroid?size=24", Context());
  ASSERT_TRUE(field);
  extract::ExtractOptions options;
  options.method = GetParam() == GpuPipeline::mt_geometry ? extract::Method::mt : extract::Method::mc;
  test::DenseSurface surface(*field, options);
  surface.sites().kind.pipeline = GetParam();
  surface.sites().kind.normals = CapturedNormals::flat;
  auto source = surface.source(1 << 22, 2048);
  ASSERT_TRUE(source);
  std::size_t triangles = 0;
  double farthest = 0;
  const auto drawn = test::capture_sites(surface.sites(), *source, 1 << 22, [&](auto, const CapturedSoup& soup) {
    triangles += soup.vertices() / 3;
    for (std::size_t v = 0; v + 2 < soup.vertices(); v += 3) {
      const glm::dvec3 a(soup.position(v));
      const glm::dvec3 b(soup.position(v + 1));
      const glm::dvec3 c(soup.position(v + 2));
      const glm::dvec3 turned = glm::cross(b - a, c - a);
      for (std::size_t corner = v; corner < v + 3; ++corner) {
        ASSERT_NEAR(glm::length(soup.normal(corner)), 1, 1e-5);
        EXPECT_EQ(soup.normal(corner), soup.normal(v)) << "one normal a triangle";
      }
      // In float32 the cross product of a sliver's edges is not accurate.
      const double longest = std::max({glm::length(b - a), glm::length(c - a), glm::length(c - b)});
      if (glm::length(turned) > 0.01 * longest * longest) {
        farthest = std::max(farthest, test::angle_between(turned, soup.normal(v)));
      }
    }
  });
  ASSERT_TRUE(drawn) << drawn.error().message;
  EXPECT_LT(farthest, 0.1) << "degrees";
  const std::size_t expected = test::extract(*field, options).mesh.triangles.size();
  if (options.method == extract::Method::mt) {
    EXPECT_EQ(triangles, expected);
  } else {
    EXPECT_GT(triangles, expected / 2);  // ambiguous cells have other triangles
  }
}

}  // namespace
}  // namespace isoextract::gpu
