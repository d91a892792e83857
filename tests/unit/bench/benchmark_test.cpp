#include "bench/benchmark.hpp"

#include <algorithm>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "field/demo_field.hpp"
#include "support/fields.hpp"

namespace isoextract::bench {
namespace {

BenchOptions quick(double iso = 0) {
  BenchOptions options;
  options.iso = iso;
  options.methods = {extract::method_info(extract::Method::mc), extract::method_info(extract::Method::mt)};
  options.backends = {{"cpu", extract::make_cpu_extractor()}};
  options.threads = {1};
  options.repeats = 1;
  return options;
}

// Position, smooth normals, area and volume converge with second order, for both methods.
TEST(Benchmark, ConvergesWithSecondOrder) {
  const struct {
    const char* name;
    double iso;
    std::vector<int> sizes;
  } cases[] = {{"sphere", 0, {20, 40, 80}}, {"torus", 0, {20, 40, 80}}, {"gyroid", 0.3, {40, 57, 80}}};
  for (const auto& [name, iso, sizes] : cases) {
    const BenchResult result = bench_demo(name, sizes, quick(iso), Context()).value();
    ASSERT_EQ(result.rows.size(), 2 * sizes.size());
    for (const BenchRow& row : result.rows) EXPECT_EQ(row.position->unmeasured(), 0U);
    for (const BenchOrders& orders : result.orders) {
      SCOPED_TRACE(std::string(name) + " " + std::string(word_of(orders.method)));
      EXPECT_GE(orders.position->slope, 1.9);
      EXPECT_GE(orders.smooth_normals->slope, 1.9);
      EXPECT_NEAR(orders.flat_normals->slope, 1, 0.2);
      EXPECT_GE(orders.area->slope, 1.9);
      EXPECT_GE(orders.volume->slope, 1.9);
    }
  }
}

TEST(Benchmark, MeasuresRequestedRows) {
  BenchOptions options = quick();
  const int most = tbb::this_task_arena::max_concurrency();
  options.threads = most > 1 ? std::vector<int>{1, 2} : std::vector<int>{1};
  options.repeats = 3;
  const BenchResult result = bench_demo("sphere", {16, 24}, options, Context()).value();
  EXPECT_EQ(result.input, "demo:sphere");
  ASSERT_EQ(result.levels.size(), 2U);
  EXPECT_EQ(result.levels[1].size, "24");
  EXPECT_NEAR(result.levels[1].spacing, 2.0 / 23, 1e-12);
  ASSERT_EQ(result.rows.size(), 2 * 2 * options.threads.size());
  bool front = false;
  for (std::size_t r = 0; r < result.rows.size(); ++r) {
    const BenchRow& row = result.rows[r];
    EXPECT_EQ(row.threads, options.threads[r % options.threads.size()]);
    EXPECT_EQ(row.method, r / options.threads.size() % 2 == 0 ? extract::Method::mc : extract::Method::mt);
    EXPECT_EQ(row.level, r / options.threads.size() / 2);
    EXPECT_LE(row.min_seconds, row.median_seconds);
    EXPECT_LE(row.median_seconds, row.max_seconds);
    EXPECT_GT(row.triangles, 0U);
    EXPECT_TRUE(row.smooth_normals && row.flat_normals && row.area_error && row.volume_error);
    front = front || row.on_front;
  }
  EXPECT_TRUE(front);
  EXPECT_EQ(bench_demo("random", {16}, options, Context()).error().code, ErrorCode::usage);
  options.threads = {1, most + 1};
  EXPECT_EQ(bench_demo("sphere", {16}, options, Context()).error().code, ErrorCode::usage) << "threads in name only";
  const field::ScalarField field = field::make_demo_field("demo:sphere?size=16", Context()).value();
  EXPECT_EQ(bench_field(field, {1}, options, Context()).error().code, ErrorCode::usage);
}

TEST(Benchmark, FailsWithoutSurface) {
  const Hint without_coarsest{{Remedy::change, Setting::resolutions, "without the coarsest"},
                              {Remedy::change, Setting::iso}};
  const Error none = bench_demo("sphere", {16, 32}, quick(9), Context()).error();
  EXPECT_EQ(none.code, ErrorCode::input);
  EXPECT_NE(none.message.find("the values range from -1.03"), std::string::npos) << none.message;
  EXPECT_EQ(none.hint, Hint(Remedy::try_value, Setting::iso, "0"));
  const Error coarse = bench_demo("sphere", {8, 32}, quick(0.6), Context()).error();
  EXPECT_NE(coarse.message.find("with 8 samples"), std::string::npos) << coarse.message;
  EXPECT_EQ(coarse.hint, without_coarsest);
  const field::ScalarField field = field::make_demo_field("demo:sphere?size=32", Context()).value();
  EXPECT_EQ(bench_field(field, {4, 1}, quick(9), Context()).error().hint, Hint(Remedy::try_value, Setting::iso, "0"));
  EXPECT_EQ(bench_field(field, {4, 1}, quick(0.6), Context()).error().hint, without_coarsest);
}

bool has_note(const BenchResult& result, std::string_view text) {
  return std::ranges::any_of(result.notes,
                             [&](const std::string& note) { return note.find(text) != std::string::npos; });
}

// Coarser data cover a smaller box, so a plane's smaller area is no error. The position is exact, and rounding has no
// order and no better or worse values.
TEST(Benchmark, SkipsComparisonsForExactPlane) {
  const glm::dvec3 normal = glm::normalize(glm::dvec3(1, 2, -0.7));
  const field::ScalarField field = test::dense_field<float>({39, 40, 41}, [&](int i, int j, int k) {
    return glm::dot(normal, glm::dvec3(i, j, k) - glm::dvec3(18.3, 19.1, 20.2));
  });
  const BenchResult result = bench_field(field, {4, 2, 1}, quick(), Context()).value();
  ASSERT_EQ(result.rows.size(), 6U);
  std::size_t on_front = 0;
  for (const BenchRow& row : result.rows) {
    EXPECT_LT(row.position->rms.world, row.rounding);
    EXPECT_LT(row.rounding, 1e-4);
    EXPECT_FALSE(row.area_error || row.volume_error);
    on_front += row.on_front ? 1 : 0;
  }
  EXPECT_EQ(on_front, 1U) << "the fastest; all have the same error";
  for (const BenchOrders& orders : result.orders) {
    EXPECT_FALSE(orders.position || orders.area || orders.volume);
  }
  EXPECT_TRUE(has_note(result, "no errors of area and volume with 9x10x10, 19x20x20 samples"));
  EXPECT_TRUE(has_note(result, "coarser by 4: without the last 3, 0 and 1 samples"));
  EXPECT_TRUE(has_note(result, "coarser by 2: without the last 1, 0 and 1 samples"));
}

// A closed surface in data whose size no factor divides: the dropped samples contain none of it.
TEST(Benchmark, ComparesSurfacesInsideCoarserBox) {
  const auto ball = [](double center) {
    return test::dense_field<float>({47, 47, 47}, [&](int i, int j, int k) {
      return 12 - glm::length(glm::dvec3(i, j, k) - glm::dvec3(23.2, 22.7, center));
    });
  };
  const BenchResult inside = bench_field(ball(23.4), {4, 2, 1}, quick(), Context()).value();
  for (const BenchRow& row : inside.rows) EXPECT_EQ(row.area_error && row.volume_error, row.level < 2);
  for (const BenchOrders& orders : inside.orders) EXPECT_NEAR(orders.area->slope, 2, 0.4);
  EXPECT_FALSE(has_note(inside, "no errors of area"));
  EXPECT_TRUE(has_note(inside, "without the last 3, 3 and 3 samples"));
  // Closed at z = 45.2, but the samples coarsened by 4 end at 41.5, those coarsened by 2 at 44.5.
  const BenchResult at_end = bench_field(ball(33.2), {4, 2, 1}, quick(), Context()).value();
  for (const BenchRow& row : at_end.rows) EXPECT_FALSE(row.area_error || row.volume_error);
  EXPECT_TRUE(has_note(at_end, "no errors of area and volume with 11, 23 samples"));
}

// The finest data are the truth; coarser data are worse, with the order 2 of box filter and mesh.
TEST(Benchmark, ComparesFieldWithCoarserVersions) {
  const field::ScalarField field = field::make_demo_field("demo:torus?size=128", Context()).value();
  const BenchResult result = bench_field(field, {4, 2, 1}, quick(), Context()).value();
  ASSERT_EQ(result.rows.size(), 6U);
  for (std::size_t r = 0; r + 2 < 6; ++r) {
    EXPECT_GT(result.rows[r].position->rms.world, 2.5 * result.rows[r + 2].position->rms.world);
    EXPECT_EQ(result.rows[r].position->unmeasured(), 0U);
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

TEST(Convergence, FindsExponentOfPower) {
  const std::vector<double> spacings{1, 0.5, 0.25};
  const std::vector<double> errors{3, 3.0 / 8, 3.0 / 64};
  const auto order = observed_order(spacings, errors, 0);
  ASSERT_TRUE(order);
  EXPECT_NEAR(order->slope, 3, 1e-12);
  EXPECT_NEAR(order->last, 3, 1e-12);
  EXPECT_FALSE(observed_order(spacings, errors, 0.1)) << "the last is rounding";
  EXPECT_FALSE(observed_order(std::vector<double>{1}, std::vector<double>{1}, 0));
}

TEST(Convergence, FindsParetoFront) {
  const std::vector<Cost> costs{{1, 1}, {0.5, 2}, {0.6, 2}, {2, 0.5}, {1, 1}, {0.5, 3}};
  EXPECT_EQ(pareto_front(costs), (std::vector<bool>{true, true, false, true, true, false}));
}

}  // namespace
}  // namespace isoextract::bench
