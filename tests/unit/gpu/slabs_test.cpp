// Dense samples through windows of every height and width: the mesh is the same, and only needed samples are uploaded.
#include "captured_surface.hpp"
#include "drawings.hpp"
#include "support/fields.hpp"
#include "support/hints.hpp"

namespace isoextract::gpu {
namespace {

constexpr std::uint64_t kPlenty = std::uint64_t{1} << 24;
// A field in which every brick is crossed and all samples differ.
field::ScalarField noise(const glm::ivec3& dims) { return test::random_field<float>(dims, 17, 1000000); }

extract::ExtractOptions half(extract::Method method, bool normals) {
  extract::ExtractOptions options;
  options.iso = 500000;
  options.method = method;
  options.smooth_normals = normals;
  return options;
}

std::uint64_t product(const glm::ivec3& v) {
  return static_cast<std::uint64_t>(v.x) * static_cast<std::uint64_t>(v.y) * static_cast<std::uint64_t>(v.z);
}

class Slabs : public testing::TestWithParam<extract::Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, Slabs, testing::Values(extract::Method::mc, extract::Method::mt), test::method_name);

TEST_P(Slabs, HeightDoesNotChangeMesh) {
  const glm::ivec3 dims(18, 11, 35);
  const field::ScalarField field = noise(dims);
  const bool normals = GetParam() == extract::Method::mc;
  test::DenseSurface surface(field, half(GetParam(), normals));
  auto whole = surface.source(kPlenty, 2048);
  ASSERT_TRUE(whole);
  const mesh::Mesh expected = test::captured_mesh(surface.sites(), *whole, test::kFeedback);
  EXPECT_EQ(whole->uploads().samples, product(dims));
  EXPECT_EQ(whole->uploads().bytes, 4 * product(dims));
  EXPECT_EQ(whole->uploads().left_out, 0U);
  extract::ExtractOptions options = half(GetParam(), normals);
  options.edge_keys = true;
  test::expect_same_surface(test::extract(field, options).mesh, [&] {
    mesh::Mesh named = test::extract_on_gpu(field, options, {GetParam()}).mesh;
    test::expect_same_bytes(named, expected);
    return named;
  }());

  const std::uint64_t slice = 4 * product({dims.x, dims.y, 1});
  for (int height = normals ? 11 : 9; height < dims.z; ++height) {
    SCOPED_TRACE(height);
    auto source = surface.source(slice * static_cast<std::uint64_t>(height) + (height % 3 == 0 ? slice - 1 : 0), 2048);
    ASSERT_TRUE(source);
    test::expect_same_bytes(expected, test::captured_mesh(surface.sites(), *source, test::kFeedback));
    EXPECT_EQ(source->uploads().samples, product(dims)) << "each once";
  }
}

TEST_P(Slabs, ColumnsDoNotChangeMesh) {
  const glm::ivec3 dims(27, 34, 19);
  const field::ScalarField field = noise(dims);
  const bool normals = GetParam() == extract::Method::mc;
  test::DenseSurface surface(field, half(GetParam(), normals));
  auto whole = surface.source(kPlenty, 2048);
  ASSERT_TRUE(whole);
  const mesh::Mesh expected = test::captured_mesh(surface.sites(), *whole, test::kFeedback);
  const int least = normals ? 11 : 9;
  std::uint64_t before = ~std::uint64_t{0};
  for (const glm::ivec3& window : {glm::ivec3(least), glm::ivec3(least, least, 14), glm::ivec3(17, least, least),
                                   glm::ivec3(19, 27, least), glm::ivec3(27, 34, least)}) {
    SCOPED_TRACE(testing::Message() << window.x << " x " << window.y << " x " << window.z);
    auto source = surface.source(4 * product(window), 2048);
    ASSERT_TRUE(source);
    test::expect_same_bytes(expected, test::captured_mesh(surface.sites(), *source, test::kFeedback));
    EXPECT_GE(source->uploads().samples, product(dims));
    EXPECT_LE(source->uploads().samples, before) << "wider columns share less";
    before = source->uploads().samples;
  }
  EXPECT_EQ(before, product(dims)) << "one column";
  // The texture size is limited, the memory is not.
  for (const int size : {least, 12, 20, 30}) {
    SCOPED_TRACE(testing::Message() << "textures of " << size);
    auto source = surface.source(kPlenty, size);
    ASSERT_TRUE(source);
    test::expect_same_bytes(expected, test::captured_mesh(surface.sites(), *source, test::kFeedback));
  }
}

// Through the public interface.
TEST_P(Slabs, LittleMemoryDoesNotChangeMesh) {
  const field::ScalarField field = test::random_field<double>({66, 64, 40}, 12, 1000000);
  extract::ExtractOptions options = half(GetParam(), false);
  options.iso = 995000;  // small balls, and few ambiguous cells
  options.edge_keys = true;
  GpuOptions little;
  little.memory_bytes = 1 << 20;
  little.debug = true;
  auto extractor = make_gpu_extractor(little);
  ASSERT_TRUE(extractor);
  const auto found = extractor->extractor->extract(field, options, Context());
  ASSERT_TRUE(found) << found.error().message;
  test::expect_same_bytes(test::extract_on_gpu(field, options, {GetParam()}).mesh, found->mesh);
  EXPECT_EQ(found->stats.device->bytes_uploaded, 8 * product({66, 64, 40})) << "in slabs, each sample once";
}

TEST_P(Slabs, PortionsDoNotChangeMesh) {
  const field::ScalarField field = noise({18, 17, 20});
  test::DenseSurface surface(field, half(GetParam(), false));
  std::optional<mesh::Mesh> expected;
  for (const std::uint64_t feedback :
       {test::kFeedback, std::uint64_t{1}, std::uint64_t{100000}, std::uint64_t{333333}}) {
    auto source = surface.source(kPlenty, 2048);
    ASSERT_TRUE(source);
    mesh::Mesh mesh = test::captured_mesh(surface.sites(), *source, feedback);
    if (expected) test::expect_same_bytes(*expected, mesh);
    expected = std::move(mesh);
  }
}

TEST_P(Slabs, UploadsOnlyCrossedBricks) {
  const glm::ivec3 dims(96, 90, 100);
  // Two balls in opposite corners of their common box.
  const field::ScalarField field = test::dense_field<float>(dims, [](int i, int j, int k) {
    const glm::dvec3 p(i, j, k);
    return 5.3 - std::min(glm::length(p - glm::dvec3(20, 22, 18)), glm::length(p - glm::dvec3(70, 61, 80)));
  });
  extract::ExtractOptions options;
  options.method = GetParam();
  options.edge_keys = true;
  test::DenseSurface surface(field, options);
  const std::size_t sites = surface.sites().origins.size();
  EXPECT_LE(sites, 2 * 27U);
  for (const std::uint64_t bytes : {kPlenty, 4 * product({96, 90, 9}), 4 * product({30, 30, 30})}) {
    auto source = surface.source(bytes, 2048);
    ASSERT_TRUE(source);
    const mesh::Mesh mesh = test::captured_mesh(surface.sites(), *source, test::kFeedback);
    test::expect_sound(mesh, true);
    test::expect_same_surface(test::extract(field, options).mesh, mesh);
    const UploadFigures figures = source->uploads();
    EXPECT_EQ(figures.bytes, 4 * figures.samples);
    EXPECT_LE(figures.samples, 2 * 64 * 512U) << "4 x 4 x 4 bricks of samples around 3 x 3 x 3 of cells";
    EXPECT_GT(figures.samples, 0U);
    EXPECT_EQ(figures.left_out, product(dims) - figures.samples);
  }
}

TEST_P(Slabs, FailsAndReportsSufficientMemory) {
  const field::ScalarField field = noise({20, 20, 20});
  test::DenseSurface surface(field, half(GetParam(), false));
  EXPECT_TRUE(surface.source(4 * product(glm::ivec3(9)), 2048));
  EXPECT_TRUE(surface.source(kPlenty, 9));
  const auto bytes = surface.source(4 * product(glm::ivec3(9)) - 1, 2048);
  ASSERT_FALSE(bytes);
  EXPECT_EQ(bytes.error().code, ErrorCode::usage);
  EXPECT_TRUE(test::has_step(bytes.error().hint, Remedy::raise, Setting::gpu_memory));
  EXPECT_NE(bytes.error().message.find(format_byte_size(4 * product(glm::ivec3(9)))), std::string::npos);
  EXPECT_FALSE(surface.source(kPlenty, 8));
  GpuOptions options;
  options.memory_bytes = 1 << 19;
  const auto extractor = make_gpu_extractor(options);
  ASSERT_FALSE(extractor);
  EXPECT_EQ(extractor.error().code, ErrorCode::usage);
}

TEST(DeviceMemory, IsNotUsedWithoutSurface) {
  field::DenseSamples samples;
  samples.dims = glm::ivec3(1 << 20);
  auto source =
      DenseSource::make(test::kOwnContext->context(), samples, {}, {glm::ivec3(0), samples.dims - 1}, {false, 1, 2048});
  ASSERT_TRUE(source);
  for (int again = 0; again < 2; ++again) {
    const auto ready = source->advance();
    ASSERT_TRUE(ready);
    EXPECT_TRUE(ready->empty());
  }
  // Two adjacent sites far out: the texture has their size, however large the field is.
  const std::vector<glm::ivec3> sites{{80000, 8000, 88}, {80008, 8000, 88}};
  EXPECT_TRUE(DenseSource::make(test::kOwnContext->context(), samples, sites, {glm::ivec3(0), samples.dims - 1},
                                {false, 4 * 17 * 9 * 9, 17}));
}

// The device cannot allocate it: the call returns an error, and the context stays usable.
TEST(DeviceMemory, FailsForTooLargeTexture) {
  const gl::GlContext& context = test::kOwnContext->context();
  field::DenseSamples samples;
  samples.type = field::SampleType::f64;
  samples.dims = glm::ivec3(test::max_texture_size());
  const std::vector<glm::ivec3> sites{glm::ivec3(0), (samples.dims - 2) / 8 * 8};
  const auto source = DenseSource::make(context, samples, sites, {glm::ivec3(0), samples.dims - 1},
                                        {false, ~std::uint64_t{0}, samples.dims.x});
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::unavailable);
  EXPECT_NE(source.error().message.find("not enough GPU memory"), std::string::npos) << source.error().message;
  EXPECT_TRUE(test::has_step(source.error().hint, Remedy::lower, Setting::gpu_memory));
  EXPECT_TRUE(context.check("looking again"));
}

}  // namespace
}  // namespace isoextract::gpu
