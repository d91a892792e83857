// Samples that stay on the device: which of them are uploaded again, and that the mesh equals that of an extractor that
// keeps none.
#include "gpu/detail/resident_samples.hpp"

#include <atomic>

#include "drawings.hpp"
#include "field/demo_field.hpp"
#include "support/fields.hpp"

namespace isoextract::gpu {
namespace {

std::unique_ptr<extract::Extractor> keeping_extractor(std::optional<std::uint64_t> bytes = std::nullopt) {
  GpuOptions options;
  options.memory_bytes = bytes;
  options.keep_samples = true;
  options.debug = true;
  auto made = make_gpu_extractor(options);
  if (!made) throw std::runtime_error(made.error().message);
  return std::move(made->extractor);
}

// Returns the upload figures. Expects the mesh of a new extractor.
extract::DeviceStats draw(extract::Extractor& keeping, const field::ScalarField& field,
                          extract::ExtractOptions options) {
  options.edge_keys = true;
  const extract::Extraction fresh = test::extract_on_gpu(field, options);
  const auto found = keeping.extract(field, options, Context());
  if (!found) {
    ADD_FAILURE() << found.error().message;
    return {};
  }
  EXPECT_FALSE(fresh.mesh.triangles.empty());
  test::expect_same_bytes(fresh.mesh, found->mesh);
  EXPECT_EQ(fresh.stats.device->samples_uploaded,
            found->stats.device->samples_uploaded + found->stats.device->samples_kept);
  return *found->stats.device;
}

// Returns a field in which every brick is crossed; the sample `changed` has another value.
field::ScalarField noise(const glm::ivec3& changed) {
  std::mt19937 engine(11);
  return test::dense_field<float>({24, 21, 24}, [&](int i, int j, int k) {
    const auto value = static_cast<double>(engine() % 1000);
    return glm::ivec3(i, j, k) == changed ? value + 0.25 : value;
  });
}

class Resident : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static extract::ExtractOptions options(double iso) {
    extract::ExtractOptions options = test::at_iso(iso);
    options.smooth_normals = GetParam();
    return options;
  }
};
INSTANTIATE_TEST_SUITE_P(Normals, Resident, testing::Bool());

TEST_P(Resident, UploadsNoSampleTwice) {
  const auto keeping = keeping_extractor();
  const field::ScalarField field = noise(glm::ivec3(-1));
  const extract::DeviceStats first = draw(*keeping, field, options(500));
  EXPECT_EQ(first.samples_uploaded, 24U * 21 * 24);
  EXPECT_EQ(first.bricks_uploaded, GetParam() ? 4U * 3 * 4 : 3U * 3 * 3);
  EXPECT_EQ(first.bricks_kept + first.samples_kept, 0U);
  // A copy: only the values of the samples count, not their address, nor the iso value.
  for (const double iso : {500.0, 300.5}) {
    const extract::DeviceStats again = draw(*keeping, noise(glm::ivec3(-1)), options(iso));
    EXPECT_EQ(again.samples_uploaded + again.bricks_uploaded + again.bytes_uploaded, 0U);
    EXPECT_EQ(again.bricks_kept, first.bricks_uploaded);
    EXPECT_EQ(again.samples_kept, first.samples_uploaded);
  }
}

TEST_P(Resident, UploadsBrickOfChangedSample) {
  const auto keeping = keeping_extractor();
  draw(*keeping, noise(glm::ivec3(-1)), options(500));
  for (const glm::ivec3& p : {glm::ivec3(12), glm::ivec3(10, 12, 20)}) {
    const extract::DeviceStats changed = draw(*keeping, noise(p), options(500));
    EXPECT_EQ(changed.bricks_uploaded, p == glm::ivec3(12) ? 1U : 2U) << "the one before comes back as well";
    EXPECT_EQ(changed.samples_uploaded, 512 * changed.bricks_uploaded);
  }
  // A brick at the data boundary: 5 samples in y, and one or no more in x and z.
  const extract::DeviceStats corner = draw(*keeping, noise({23, 20, 23}), options(500));
  EXPECT_EQ(corner.samples_uploaded, 512U + (GetParam() ? 1U * 6 * 1 : 8U * 5 * 8));
}

// A fixed ball and a moving one: the box around both moves, grows and shrinks.
TEST_P(Resident, KeepsBricksInWindow) {
  const auto ball = [](const glm::dvec3& place) {
    return test::dense_field<float>({96, 90, 100}, [&](int i, int j, int k) {
      const glm::dvec3 p(i, j, k);
      const double distance = std::min(glm::length(p - glm::dvec3(44, 41, 50)), glm::length(p - place));
      return std::clamp(5.3 - distance, -3.0, 3.0);
    });
  };
  const auto keeping = keeping_extractor();
  draw(*keeping, ball({60, 41, 50}), options(0));
  std::uint64_t kept = 0;
  for (const glm::dvec3& place : {glm::dvec3(60, 41, 50), glm::dvec3(58, 41, 50), glm::dvec3(44, 41, 50),
                                  glm::dvec3(30, 41, 50), glm::dvec3(30, 30, 40), glm::dvec3(12, 80, 85),
                                  glm::dvec3(85, 12, 10), glm::dvec3(60, 41, 50), glm::dvec3(44, 41, 50)}) {
    SCOPED_TRACE(testing::Message() << place.x << ", " << place.y << ", " << place.z);
    const extract::DeviceStats moved = draw(*keeping, ball(place), options(0));
    EXPECT_GT(moved.bricks_uploaded + moved.bricks_kept, 0U);
    kept += moved.bricks_kept > 0 ? 1 : 0;
  }
  EXPECT_GE(kept, 6U) << "it grows three times at most, and all of it is uploaded then";
}

TEST_P(Resident, SurvivesOtherFieldsInBetween) {
  const auto keeping = keeping_extractor();
  const field::ScalarField field = noise(glm::ivec3(-1));
  const extract::DeviceStats first = draw(*keeping, field, options(500));
  const auto expect_all_anew = [&] {
    EXPECT_EQ(draw(*keeping, field, options(500)).samples_uploaded, first.samples_uploaded);
    EXPECT_EQ(draw(*keeping, field, options(500)).samples_uploaded, 0U);
  };

  draw(*keeping, test::random_field<std::int32_t>({24, 21, 24}, 3, 1000), options(500));  // as many bytes a sample
  expect_all_anew();
  draw(*keeping, test::sparse_copy<float>(test::random_field<float>({16, 16, 16}, 3, 1000), 0), options(500));
  expect_all_anew();
  extract::ExtractOptions part = options(500);
  part.region = field::IndexBox{{3, 0, 5}, {20, 20, 20}};
  draw(*keeping, field, part);
  expect_all_anew();
  part.region = field::IndexBox{{0, 0, 0}, {12, 12, 12}};  // its bricks begin at the same samples as those of the whole
  EXPECT_GT(draw(*keeping, field, part).bricks_kept, 0U);
  EXPECT_GT(draw(*keeping, field, options(500)).bricks_kept, 0U);
}

TEST_P(Resident, KeepsNothingIfTooLarge) {
  const auto keeping = keeping_extractor(std::uint64_t{1} << 20);
  const field::ScalarField large = test::random_field<double>({50, 48, 44}, 12, 1000);
  const field::ScalarField small = noise(glm::ivec3(-1));
  EXPECT_EQ(draw(*keeping, small, options(500)).bricks_kept, 0U);
  EXPECT_EQ(draw(*keeping, small, options(500)).samples_uploaded, 0U);
  for (int again = 0; again < 2; ++again) {
    extract::ExtractOptions few = options(995);
    few.edge_keys = true;
    const auto found = keeping->extract(large, few, Context());
    ASSERT_TRUE(found) << found.error().message;
    const extract::Extraction fresh = test::extract_on_gpu(large, few);
    test::expect_same_bytes(fresh.mesh, found->mesh);
    EXPECT_EQ(found->stats.device->bricks_uploaded + found->stats.device->bricks_kept, 0U);
    EXPECT_EQ(found->stats.device->samples_uploaded, fresh.stats.device->samples_uploaded) << "in slabs, each once";
  }
  EXPECT_EQ(draw(*keeping, small, options(500)).bricks_kept, 0U);
}

// The uploaded samples may differ from the hashed ones.
TEST_P(Resident, DropsSamplesOfTruncatedFile) {
  const auto keeping = keeping_extractor();
  field::ScalarField field = noise(glm::ivec3(-1));
  std::atomic<bool> loss{true};
  std::get<field::DenseSamples>(field.samples).loss = &loss;
  draw(*keeping, field, options(500));
  EXPECT_EQ(draw(*keeping, field, options(500)).samples_kept, 0U);
  loss = false;
  EXPECT_EQ(draw(*keeping, field, options(500)).samples_kept, 0U);
  EXPECT_EQ(draw(*keeping, field, options(500)).samples_uploaded, 0U);
}

TEST(BrickHash, DependsOnSamplesAndPosition) {
  const field::ScalarField field = test::dense_field<float>({20, 9, 10}, [](int i, int, int) { return i % 8; });
  const auto& samples = std::get<field::DenseSamples>(field.samples);
  const field::IndexBox first{{0, 0, 0}, {7, 7, 7}};
  const field::ScalarField other = test::dense_field<float>(
      {20, 9, 10}, [](int i, int j, int k) { return glm::ivec3(i, j, k) == glm::ivec3(7) ? 9 : i % 8; });
  EXPECT_EQ(brick_hash(samples, first), brick_hash(samples, first));
  EXPECT_NE(brick_hash(samples, first), brick_hash(std::get<field::DenseSamples>(other.samples), first));
  EXPECT_NE(brick_hash(samples, first), brick_hash(samples, {{8, 0, 0}, {15, 7, 7}})) << "the same samples elsewhere";
  EXPECT_NE(brick_hash(samples, first), brick_hash(samples, {{0, 0, 0}, {7, 7, 6}}));
}

}  // namespace
}  // namespace isoextract::gpu
