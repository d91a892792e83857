#include "measure/benchmark.hpp"

#include <gtest/gtest.h>

#include "field/demo_field.hpp"
#include "support/fields.hpp"

namespace isoextract {
namespace {

BenchOptions quick(double iso = 0) {
  BenchOptions options;
  options.iso = iso;
  options.methods = {Method::mc, Method::mt};
  options.backends = {{"cpu", make_cpu_extractor()}};
  options.threads = {1};
  options.repeats = 1;
  return options;
}

// The promise: second order for position, smooth normals, area and volume, by both methods.
TEST(Benchmark, OrdersOfConvergence) {
  const struct {
    const char* name;
    double iso;
    std::vector<int> sizes;
  } cases[] = {{"sphere", 0, {20, 40, 80}}, {"torus", 0, {20, 40, 80}}, {"gyroid", 0.3, {40, 57, 80}}};
  for (const auto& [name, iso, sizes] : cases) {
    const BenchResult result = bench_demo(name, sizes, quick(iso)).value();
    ASSERT_EQ(result.rows.size(), 2 * sizes.size());
    for (const BenchRow& row : result.rows) EXPECT_EQ(row.position.unmeasured(), 0U);
    for (const BenchOrders& orders : result.orders) {
      SCOPED_TRACE(std::string(name) + " " + std::string(method_name(orders.method)));
      EXPECT_GE(orders.position->slope, 1.9);
      EXPECT_GE(orders.smooth_normals->slope, 1.9);
      EXPECT_NEAR(orders.flat_normals->slope, 1, 0.2);
      EXPECT_GE(orders.area->slope, 1.9);
      EXPECT_GE(orders.volume->slope, 1.9);
    }
  }
}

TEST(Benchmark, RowsAreWhatWasAskedFor) {
  BenchOptions options = quick();
  options.threads = {1, 2};
  options.repeats = 3;
  const BenchResult result = bench_demo("sphere", {16, 24}, options).value();
  EXPECT_EQ(result.input, "demo:sphere");
  ASSERT_EQ(result.levels.size(), 2U);
  EXPECT_EQ(result.levels[1].size, "24");
  EXPECT_NEAR(result.levels[1].spacing, 2.0 / 23, 1e-12);
  ASSERT_EQ(result.rows.size(), 2U * 2 * 2);
  bool front = false;
  for (const BenchRow& row : result.rows) {
    EXPECT_LE(row.min_seconds, row.median_seconds);
    EXPECT_LE(row.median_seconds, row.max_seconds);
    EXPECT_GT(row.triangles, 0U);
    EXPECT_TRUE(row.smooth_normals && row.flat_normals && row.area_error && row.volume_error);
    front = front || row.on_front;
  }
  EXPECT_TRUE(front);
  EXPECT_EQ(bench_demo("random", {16}, options).error().kind, ErrorKind::usage);
  EXPECT_EQ(bench_demo("sphere", {16}, quick(9)).error().kind, ErrorKind::input);
}

// The finest data are the truth; what is coarser is worse, with the order of the box filter and the mesh: two.
TEST(Benchmark, OfAFieldComparesCoarserVersionsOfIt) {
  const ScalarField field = make_demo_field("demo:torus?size=128", default_limits()).value();
  const BenchResult result = bench_field(field, {4, 2, 1}, quick()).value();
  ASSERT_EQ(result.rows.size(), 6U);
  for (std::size_t r = 0; r + 2 < 6; ++r) {
    EXPECT_GT(result.rows[r].position.rms.world, 2.5 * result.rows[r + 2].position.rms.world);
    EXPECT_EQ(result.rows[r].position.unmeasured(), 0U);
    EXPECT_TRUE(result.rows[r].area_error && result.rows[r].volume_error);
  }
  EXPECT_FALSE(result.rows[4].area_error) << "it is the truth";
  EXPECT_EQ(result.levels[0].size, "32");
  EXPECT_TRUE(result.levels[2].is_truth);
  for (const BenchOrders& orders : result.orders) {
    EXPECT_NEAR(orders.position->slope, 2, 0.4);
    EXPECT_NEAR(orders.position->slope, orders.position->last, 1e-9) << "of the two that are not the truth";
  }
}

TEST(Convergence, OrderOfAPowerIsItsExponent) {
  const std::vector<double> spacings{1, 0.5, 0.25};
  const std::vector<double> errors{3, 3.0 / 8, 3.0 / 64};
  const auto order = observed_order(spacings, errors, 0);
  ASSERT_TRUE(order);
  EXPECT_NEAR(order->slope, 3, 1e-12);
  EXPECT_NEAR(order->last, 3, 1e-12);
  EXPECT_FALSE(observed_order(spacings, errors, 0.1)) << "the last is rounding";
  EXPECT_FALSE(observed_order(std::vector<double>{1}, std::vector<double>{1}, 0));
}

TEST(Convergence, TheFrontIsWhatNothingBeats) {
  const std::vector<Cost> costs{{1, 1}, {0.5, 2}, {0.6, 2}, {2, 0.5}, {1, 1}, {0.5, 3}};
  EXPECT_EQ(pareto_front(costs), (std::vector<bool>{true, true, false, true, true, false}));
}

}  // namespace
}  // namespace isoextract
