// Samples of which only some layers are in memory give the same mesh.
#include <atomic>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/parallel.hpp"
#include "extract/dense_masks.hpp"
#include "field/sample_layers.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

// Layers of the samples of a field, copied into windows between samples that would change the mesh.
template <class T>
class CopiedLayers final : public field::SampleLayers {
 public:
  explicit CopiedLayers(const field::DenseSamples& samples)
      : samples_(static_cast<const T*>(samples.data)),
        layer_(static_cast<std::size_t>(samples.dims.x) * static_cast<std::size_t>(samples.dims.y)) {}

  [[nodiscard]] Result<std::unique_ptr<Window>> open(int layers) const override {
    if (++opened > most_windows) return fail(ErrorCode::out_of_memory, "no room for a window");
    return std::make_unique<CopiedWindow>(*this, static_cast<std::size_t>(layers));
  }

  mutable std::atomic<int> opened{0};
  mutable std::atomic<int> moves{0};
  int most_windows = std::numeric_limits<int>::max();
  int most_moves = std::numeric_limits<int>::max();

 private:
  class CopiedWindow final : public Window {
   public:
    CopiedWindow(const CopiedLayers& layers, std::size_t room) : layers_(layers), room_(room) {}

    [[nodiscard]] Result<const void*> move_to(int begin, int end) override {
      if (++layers_.moves > layers_.most_moves) return fail(ErrorCode::out_of_memory, "no room to move");
      const auto count = static_cast<std::size_t>(end - begin);
      EXPECT_LE(count, room_);
      const std::size_t layer = layers_.layer_;
      samples_.assign((count + 2 * kMargin) * layer, test::sample<T>(101));
      std::copy_n(layers_.samples_ + static_cast<std::size_t>(begin) * layer, count * layer,
                  samples_.begin() + kMargin * layer);
      return samples_.data() + kMargin * layer;
    }

   private:
    static constexpr std::ptrdiff_t kMargin = 3;
    const CopiedLayers& layers_;
    std::size_t room_;
    std::vector<T> samples_;
  };

  const T* samples_;
  std::size_t layer_;
};

field::ScalarField with_layers(field::ScalarField field, const field::SampleLayers& layers) {
  auto& samples = std::get<field::DenseSamples>(field.samples);
  samples.data = nullptr;
  samples.layers = &layers;
  return field;
}

class ByLayers : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, ByLayers, testing::ValuesIn(test::cell_methods()), test::method_name);

template <class T>
void expect_same_meshes(Method method, const glm::ivec3& dims) {
  const field::ScalarField field = test::random_field<T>(dims, 5, 100);
  const CopiedLayers<T> layers(std::get<field::DenseSamples>(field.samples));
  const field::ScalarField layered = with_layers(field, layers);
  for (const bool normals : {false, true}) {
    for (int low = 0; low + 1 < dims.z; low += 5) {
      ExtractOptions options = test::options_of(method, 50);
      options.smooth_normals = normals;
      options.region = field::IndexBox{{1, 2, low}, {dims.x - 1, dims.y - 2, dims.z - 1}};
      const Extraction whole = test::extract(field, options);
      const Extraction by_layers = test::extract(layered, options);
      EXPECT_GT(whole.mesh.triangles.size(), 0U);
      EXPECT_TRUE(test::same_bytes(by_layers.mesh.positions, whole.mesh.positions)) << dims.z << " " << low;
      EXPECT_TRUE(test::same_bytes(by_layers.mesh.normals, whole.mesh.normals)) << dims.z << " " << low;
      EXPECT_TRUE(test::same_bytes(by_layers.mesh.triangles, whole.mesh.triangles)) << dims.z << " " << low;
      EXPECT_EQ(by_layers.stats.meets_boundary, whole.stats.meets_boundary);
      EXPECT_EQ(by_layers.stats.bricks_visited, whole.stats.bricks_visited);
    }
  }
  EXPECT_GT(layers.moves, 0);
}

TEST_P(ByLayers, GiveTheSameMesh) {
  for (const int depth : {2, 3, 8, 9, 10, 16, 17, 18, 27}) expect_same_meshes<float>(GetParam(), {70, 19, depth});
  expect_same_meshes<std::uint8_t>(GetParam(), {33, 20, 21});
  expect_same_meshes<field::Half>(GetParam(), {33, 20, 21});
}

TEST_P(ByLayers, NameTheFirstNan) {
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  const field::ScalarField field = test::dense_field<float>({20, 9, 30}, [&](int i, int j, int k) {
    return (i == 7 && j == 4 && k == 17) || (i == 2 && j == 3 && k == 21) ? nan : static_cast<float>(i);
  });
  const CopiedLayers<float> layers(std::get<field::DenseSamples>(field.samples));
  for (const double iso : {5.0, std::numeric_limits<double>::max()}) {  // no sample can be above the last one
    const ExtractOptions options = test::options_of(GetParam(), iso);
    const auto extraction = make_cpu_extractor()->extract(with_layers(field, layers), options, Context());
    ASSERT_FALSE(extraction);
    EXPECT_EQ(extraction.error().message, make_cpu_extractor()->extract(field, options, Context()).error().message);
  }
  ExtractOptions options = test::options_of(GetParam(), 5);
  options.nan = NanPolicy::outside;
  EXPECT_TRUE(test::same_bytes(test::extract(with_layers(field, layers), options).mesh.positions,
                               test::extract(field, options).mesh.positions));
}

TEST_P(ByLayers, NeedOneWindow) {
  const field::ScalarField field = test::random_field<float>({20, 19, 40}, 5, 100);
  for (const int windows : {0, 1, 2}) {
    CopiedLayers<float> layers(std::get<field::DenseSamples>(field.samples));
    // Both passes open windows.
    const ExtractOptions options = test::options_of(GetParam(), 50);
    layers.most_windows = windows;
    const auto extraction = make_cpu_extractor()->extract(with_layers(field, layers), options, Context());
    if (windows < 2) {
      ASSERT_FALSE(extraction);
      EXPECT_EQ(extraction.error().message, "no room for a window");
    }
    if (extraction) {
      EXPECT_TRUE(test::same_bytes(extraction->mesh.positions, test::extract(field, options).mesh.positions));
    }
  }
  CopiedLayers<float> layers(std::get<field::DenseSamples>(field.samples));
  layers.most_moves = 7;  // the second pass fails
  const auto extraction =
      make_cpu_extractor()->extract(with_layers(field, layers), test::options_of(GetParam(), 50), Context());
  ASSERT_FALSE(extraction);
  EXPECT_EQ(extraction.error().message, "no room to move");
}

TEST(ByLayersOnly, AreRefusedIfTheSurfaceNeedsAllSamples) {
  const field::ScalarField field = test::random_field<float>({10, 11, 12}, 5, 100);
  const CopiedLayers<float> layers(std::get<field::DenseSamples>(field.samples));
  ExtractOptions holes = test::options_of(Method::mc, 50);
  holes.nan = NanPolicy::hole;
  for (const ExtractOptions& options :
       {test::options_of(Method::mc, 50, true), test::options_of(Method::mt, 50, true), holes,
        test::options_of(Method::voxels, 50), test::options_of(Method::surface_nets, 50)}) {
    const auto extraction = make_cpu_extractor()->extract(with_layers(field, layers), options, Context());
    ASSERT_FALSE(extraction);
    EXPECT_EQ(extraction.error().code, ErrorCode::out_of_memory);
    EXPECT_NE(extraction.error().message.find("needs all samples in memory or mapped"), std::string::npos);
  }
  EXPECT_EQ(layers.opened, 0);
}

}  // namespace
}  // namespace isoextract::extract
