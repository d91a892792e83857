// Backends kept from one run to the next.
#include "convert/backends.hpp"

#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "support/fields.hpp"

namespace isoextract::convert {
namespace {

extract::ExtractOptions half() {
  extract::ExtractOptions options;
  options.iso = 500;
  return options;
}

TEST(BackendCache, OpensDeviceOnce) {
  BackendCache kept;
  EXPECT_EQ(kept.devices_opened(), 0) << "not before it is asked for";
  EXPECT_EQ(kept.open(Backend::cpu, {}).value().extractor->name(), "cpu");
  EXPECT_EQ(kept.devices_opened(), 0);
  const field::ScalarField field = test::random_field<float>({18, 17, 20}, 5, 1000);
  std::vector<std::size_t> triangles(4);
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      threads.emplace_back([&, t] {
        const auto opened = kept.open(Backend::gpu, {});
        const auto made = opened.value().extractor->extract(field, half(), Context());
        triangles[t] = made.value().mesh.triangles.size();
      });
    }
  }
  const std::size_t expected =
      extract::make_cpu_extractor()->extract(field, half(), Context()).value().mesh.triangles.size();
  EXPECT_EQ(triangles, std::vector(4, expected));
  EXPECT_EQ(kept.devices_opened(), 1);
}

TEST(BackendCache, ReopensDeviceAfterFailure) {
  BackendCache kept;
  const field::ScalarField sound = test::random_field<float>({18, 17, 20}, 5, 1000);
  const field::ScalarField bad = test::dense_field<float>({8, 8, 8}, [](int, int, int) { return test::kNaN; });
  const auto first = kept.open(Backend::gpu, {}).value().extractor;
  const auto second = kept.open(Backend::gpu, {}).value().extractor;
  EXPECT_FALSE(first->extract(bad, half(), Context()));
  EXPECT_TRUE(second->extract(sound, half(), Context())) << "who has it goes on with it";
  const auto third = kept.open(Backend::gpu, {}).value().extractor;
  EXPECT_EQ(kept.devices_opened(), 2);
  EXPECT_FALSE(second->extract(bad, half(), Context()));
  EXPECT_TRUE(kept.open(Backend::gpu, {}));
  EXPECT_EQ(kept.devices_opened(), 2) << "it was another one that failed";
  const auto made = third->extract(sound, half(), Context());
  ASSERT_TRUE(made);
  EXPECT_GT(made->stats.device->samples_uploaded, 0U) << "nothing stayed of the one before";
}

TEST(BackendCache, AutomaticRefusesSoftwareGpu) {
  BackendCache kept;
  for (int again = 0; again < 2; ++again) {
    const auto opened = kept.open(Backend::automatic, {});
    const auto alone = open_backend(Backend::automatic, {});
    ASSERT_TRUE(opened && alone);
    EXPECT_EQ(opened->reason, alone->reason);
    EXPECT_EQ(opened->extractor->name(), alone->extractor->name());
  }
  EXPECT_EQ(kept.devices_opened(), 1) << "it is not looked for again";
}

TEST(BackendCache, FailsEachTimeForMissingDevice) {
  BackendCache kept;
  for (int again = 0; again < 2; ++again) {
    const auto opened = kept.open(Backend::gpu, {.device = 99, .memory_bytes = {}});
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::unavailable);
  }
  EXPECT_TRUE(kept.open(Backend::gpu, {}));
}

}  // namespace
}  // namespace isoextract::convert
