// Columns of land and water as volumes and maps.
#include "simulate/water_fields.hpp"

#include <gtest/gtest.h>

namespace isoextract::simulate {
namespace {

WaterAutomaton columns(std::vector<double> terrain, std::vector<double> depth, WaterOptions options = {}) {
  auto made =
      WaterAutomaton::create({static_cast<int>(terrain.size()) / 2, 2}, terrain, depth, std::move(options), Context());
  EXPECT_TRUE(made) << made.error().message;
  return std::move(*made);
}

const field::DenseSamples& dense(const field::ScalarField& field) {
  return std::get<field::DenseSamples>(field.samples);
}

TEST(WaterFields, FillVoxelsFromBelow) {
  const WaterAutomaton automaton = columns({0.25, 2, 1.5, 3}, {0, 0.5, 2.25, 0});
  ASSERT_EQ(count_layers(automaton), 5);  // 3.75 high, plus an empty layer
  const auto fields = water_fields(automaton, WaterOutput::both, 5, {2, 3, 4}, Context());
  ASSERT_TRUE(fields);
  ASSERT_EQ(fields->size(), 2U);
  EXPECT_EQ((*fields)[0].name, "terrain");
  EXPECT_EQ((*fields)[1].name, "water");
  const auto column = [&](std::size_t which, int cell) {
    const auto* values = static_cast<const float*>(dense((*fields)[which]).data);
    std::vector<float> parts;
    for (int k = 0; k < 5; ++k) parts.push_back(values[cell + 4 * k]);
    return parts;
  };
  EXPECT_EQ(dense((*fields)[0]).dims, glm::ivec3(2, 2, 5));
  EXPECT_EQ(column(0, 0), (std::vector<float>{0.25F, 0, 0, 0, 0}));
  EXPECT_EQ(column(0, 2), (std::vector<float>{1, 0.5F, 0, 0, 0}));
  EXPECT_EQ(column(1, 0), (std::vector<float>{0, 0, 0, 0, 0}));
  EXPECT_EQ(column(1, 1), (std::vector<float>{0, 0, 0.5F, 0, 0}));
  EXPECT_EQ(column(1, 2), (std::vector<float>{0, 0.5F, 1, 0.75F, 0}));
  EXPECT_EQ((*fields)[1].kind, field::FieldKind::density);
  EXPECT_EQ((*fields)[1].index_to_world(glm::dvec3(0)), glm::dvec3(1, 1.5, 2));
  EXPECT_EQ((*fields)[1].index_to_world(glm::dvec3(1)), glm::dvec3(3, 4.5, 6));
}

TEST(WaterFields, ContainRequestedFields) {
  const WaterAutomaton automaton = columns({1, 1, 1, 1}, {1, 0, 0, 0});
  for (const auto& [content, names] : {std::pair{WaterOutput::water, std::vector<std::string>{"water"}},
                                       std::pair{WaterOutput::terrain, std::vector<std::string>{"terrain"}}}) {
    EXPECT_EQ(field_names(content), names);
    const auto fields = water_fields(automaton, content, 3, glm::dvec3(1), Context());
    ASSERT_TRUE(fields);
    ASSERT_EQ(fields->size(), 1U);
    EXPECT_EQ(fields->front().name, names.front());
  }
}

TEST(WaterFields, MapsKeepExactNumbers) {
  const WaterAutomaton automaton = columns({0.1, 2, 1.5, 3}, {0.3, 0.5, 2.25, 0});
  const auto fields = water_fields(automaton, WaterOutput::heights, 1, glm::dvec3(1), Context());
  ASSERT_TRUE(fields);
  EXPECT_EQ(dense((*fields)[0]).dims, glm::ivec3(2, 2, 1));
  EXPECT_EQ(dense((*fields)[0]).type, field::SampleType::f64);
  EXPECT_EQ(static_cast<const double*>(dense((*fields)[0]).data)[0], 0.1);
  EXPECT_EQ(static_cast<const double*>(dense((*fields)[1]).data)[2], 2.25);
}

TEST(WaterFields, TreatNegativeDepthsAsEmpty) {
  WaterOptions options;
  options.rule = WaterRule::printed;
  options.friction = 0;
  WaterAutomaton automaton = columns(
      std::vector<double>(18, 0),
      [] {
        std::vector<double> depth(18, 0);
        depth[4] = 9;
        return depth;
      }(),
      options);
  while (automaton.extremes().below_zero == 0) {
    ASSERT_TRUE(automaton.run(1));
    ASSERT_LT(automaton.steps_done(), 200U);
  }
  const auto fields = water_fields(automaton, WaterOutput::water, 12, glm::dvec3(1), Context());
  ASSERT_TRUE(fields);
  const auto* values = static_cast<const float*>(dense(fields->front()).data);
  for (std::size_t n = 0; n < dense(fields->front()).count(); ++n) {
    EXPECT_GE(values[n], 0);
    EXPECT_LE(values[n], 1);
  }
}

TEST(WaterFields, RejectHeightsThatDoNotFit) {
  const WaterAutomaton tower = columns({0, 0, 0, 1e6}, {});
  EXPECT_EQ(count_layers(tower).error().code, ErrorCode::output);
  const WaterAutomaton low = columns({1, 1, 1, 1}, {});
  const auto poor = water_fields(low, WaterOutput::water, 1000, glm::dvec3(1), Context(MemoryBudget(1000)));
  EXPECT_EQ(poor.error().hint, Hint(Remedy::raise, Setting::memory_limit));
}

}  // namespace
}  // namespace isoextract::simulate
