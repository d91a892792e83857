// Fields that need several draws, cases that break extraction in float32, and real volumes.
#include "bench/stability.hpp"
#include "drawings.hpp"
#include "field/demo_field.hpp"
#include "support/data_folder.hpp"
#include "support/fields.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::gpu {
namespace {

// llvmpipe repeats the first batch in a tessellated draw of more than 65,536 vertices (128 sites). The number of
// triangles is still right.
TEST(LargeDraw, RepeatsNoTessellatedVertices) {
  const auto field = field::make_demo_field("demo:gyroid?size=56", Context());
  ASSERT_TRUE(field);
  EXPECT_GT(test::extract_on_gpu(*field, {}).stats.bricks_visited, 300U);
  EXPECT_GT(test::expect_parity(*field, extract::ExtractOptions{}), 40000U);
}

TEST(LargeDraw, ReportsStats) {
  const auto field = field::make_demo_field("demo:gyroid?size=40", Context());
  ASSERT_TRUE(field);
  const extract::Extraction result = test::extract_on_gpu(*field, {});
  ASSERT_TRUE(result.stats.device);
  const extract::DeviceStats& device = *result.stats.device;
  EXPECT_EQ(device.bytes_uploaded, 40U * 40 * 40 * sizeof(float)) << "the surface is everywhere";
  EXPECT_EQ(device.samples_uploaded, 40U * 40 * 40);
  // Three vertices a triangle, each with a position and a key. Ambiguous cells may capture fewer triangles than they
  // draw.
  EXPECT_NEAR(static_cast<double>(device.bytes_captured), 48.0 * static_cast<double>(result.mesh.triangles.size()),
              48.0 * 4 * static_cast<double>(device.cells_decided) + 1);
  EXPECT_GE(result.stats.emit.wall_seconds, device.weld.wall_seconds);
  EXPECT_EQ(result.stats.bricks, 125U);
}

class GpuStability : public testing::TestWithParam<extract::Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, GpuStability, testing::Values(extract::Method::mc, extract::Method::mt),
                         test::method_name);

TEST_P(GpuStability, AllCasesPass) {
  extract::Extractor* gpu = test::kGpuExtractors->find({GetParam()});
  ASSERT_NE(gpu, nullptr);
  for (const bench::StabilityCase& test : bench::stability_cases()) {
    const bench::StabilityRow row = bench::run_stability_case(test, extract::method_info(GetParam()), *gpu, Context());
    EXPECT_EQ(row.backend, "gpu");
    for (const std::string& failure : row.failures) ADD_FAILURE() << test.name << ": " << failure;
  }
}

struct Volume {
  const char* file;
  double iso;
  const char* grid = nullptr;
  std::optional<volume_io::RawLayout> raw = std::nullopt;
  std::optional<field::IndexBox> region = std::nullopt;
};

void PrintTo(const Volume& volume, std::ostream* out) { *out << volume.file; }

class GpuRealVolume : public testing::TestWithParam<Volume> {};
INSTANTIATE_TEST_SUITE_P(
    Small, GpuRealVolume,
    testing::Values(Volume{"med/HeadMRVolume.raw", 60, nullptr,
                           volume_io::RawLayout{{48, 62, 42}, field::SampleType::u8, std::endian::little, 0}},
                    Volume{"mol/m4_TotalDensity.nrrd", 0.1}, Volume{"mol/betaGal.npy", 0.05},
                    Volume{"med/FLAIR.nrrd", 60, nullptr, std::nullopt, field::IndexBox{{30, 50, 40}, {71, 100, 77}}},
                    Volume{"vdb/sphere.vdb", 0}, Volume{"vdb/c42_gas_seq/fluid_data_0002.vdb", 0.5, "density"}),
    [](const auto& parameter) {
      std::string name = parameter.param.file;
      std::ranges::replace_if(
          name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
      return name;
    });

TEST_P(GpuRealVolume, EqualsCpu) {
  ISOEXTRACT_NEEDS_DATA(GetParam().file);
  volume_io::ReadOptions read;
  read.raw = GetParam().raw;
  if (GetParam().grid != nullptr) read.grid = GetParam().grid;
  const auto field = volume_io::read_volume(test::data_file(GetParam().file).string(), read, Context());
  ASSERT_TRUE(field) << field.error().message;
  extract::ExtractOptions options;
  options.iso = GetParam().iso;
  options.output_from_index = field->index_to_world;
  options.smooth_normals = true;
  options.region = GetParam().region;
  options.cap = GetParam().region.has_value();
  EXPECT_GT(test::expect_parity(*field, options), 0U);
}

}  // namespace
}  // namespace isoextract::gpu
