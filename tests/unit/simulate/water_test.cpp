// The automaton against plain versions of both rules, and its conservation laws.
#include "simulate/water.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "simulate/terrain.hpp"

namespace isoextract::simulate {
namespace {

// Rows i of columns j, as in the paper.
using Rows = std::vector<std::vector<double>>;

struct PlainWater {
  Rows terrain, water, energy;
  int dim_i, dim_j;
};

// Listing 3.3.1 line by line, with the loops around it.
void listing(PlainWater& s, double friction, double flow_div) {
  for (int i = 0; i < s.dim_i; ++i) {
    for (int j = 0; j < s.dim_j; ++j) {
      Rows& T = s.terrain;
      Rows& W = s.water;
      Rows& E = s.energy;
      const double left_pressure = i > 0 ? T[i - 1][j] + W[i - 1][j] + E[i - 1][j] : 0.0;
      const double right_pressure = i < s.dim_i - 1 ? T[i + 1][j] + W[i + 1][j] + -E[i + 1][j] : 0.0;
      const double back_pressure = j > 0 ? T[i][j - 1] + W[i][j - 1] + E[i][j - 1] : 0.0;
      const double front_pressure = j < s.dim_j - 1 ? T[i][j + 1] + W[i][j + 1] + -E[i][j + 1] : 0.0;
      if (i > 0 && T[i][j] + W[i][j] + E[i][j] > left_pressure) {
        const double flow = std::min(W[i][j], T[i][j] + W[i][j] + -E[i][j] + -left_pressure) / flow_div;
        W[i - 1][j] = W[i - 1][j] + flow;
        W[i][j] = W[i][j] + -flow;
        E[i - 1][j] = E[i - 1][j] * (1.0 - friction);
        E[i - 1][j] = E[i - 1][j] + -flow;
      }
      if (i < s.dim_i - 1 && T[i][j] + W[i][j] + E[i][j] > right_pressure) {
        const double flow = std::min(W[i][j], T[i][j] + W[i][j] + E[i][j] + -right_pressure) / flow_div;
        W[i + 1][j] = W[i + 1][j] + flow;
        W[i][j] = W[i][j] + -flow;
        E[i + 1][j] = E[i + 1][j] * (1.0 - friction);
        E[i + 1][j] = E[i + 1][j] + flow;
      }
      if (j > 0 && T[i][j] + W[i][j] + -E[i][j] > back_pressure) {
        const double flow = std::min(W[i][j], T[i][j] + W[i][j] + -E[i][j] + -back_pressure) / flow_div;
        W[i][j - 1] = W[i][j - 1] + flow;
        W[i][j] = W[i][j] + -flow;
        E[i][j - 1] = E[i][j - 1] * (1.0 - friction);
        E[i][j - 1] = E[i][j - 1] + -flow;
      }
      if (j < s.dim_j - 1 && T[i][j] + W[i][j] + E[i][j] > front_pressure) {
        const double flow = std::min(W[i][j], T[i][j] + W[i][j] + E[i][j] + -front_pressure) / flow_div;
        W[i][j + 1] = W[i][j + 1] + flow;
        W[i][j] = W[i][j] + -flow;
        E[i][j + 1] = E[i][j + 1] * (1.0 - friction);
        E[i][j + 1] = E[i][j + 1] + flow;
      }
    }
  }
}

// The conservative rule as in water.hpp, one cell at a time, with branches at the wall.
void conservative(PlainWater& s, double friction, double flow_div) {
  const int di[4] = {-1, 1, 0, 0};
  const int dj[4] = {0, 0, -1, 1};
  const auto there = [&](int i, int j) { return i >= 0 && j >= 0 && i < s.dim_i && j < s.dim_j; };
  std::vector<std::array<double, 4>> out(static_cast<std::size_t>(s.dim_i * s.dim_j));
  const auto flows = [&](int i, int j) -> std::array<double, 4>& {
    return out[static_cast<std::size_t>(i * s.dim_j + j)];
  };
  for (int i = 0; i < s.dim_i; ++i) {
    for (int j = 0; j < s.dim_j; ++j) {
      std::array<double, 4> flow{};
      double depth = s.water[i][j];
      for (int side = 0; side < 4; ++side) {
        const int ni = i + di[side];
        const int nj = j + dj[side];
        if (!there(ni, nj)) continue;
        const double sign = side % 2 == 0 ? -1 : 1;
        const double pressure = (s.terrain[ni][nj] + s.water[ni][nj]) - sign * s.energy[ni][nj];
        const double head = ((s.terrain[i][j] + depth) + sign * s.energy[i][j]) - pressure;
        if (head > 0) flow[static_cast<std::size_t>(side)] = std::min(depth, head) * (1 / flow_div);
      }
      const double sum = (flow[0] + flow[1]) + (flow[2] + flow[3]);
      for (double& each : flow) {
        if (sum > depth) each *= depth / sum;
        each = std::min(each, depth);
      }
      double rest = s.water[i][j];
      for (double& each : flow) {
        each = std::min(each, rest);
        rest -= each;
      }
      flows(i, j) = flow;
    }
  }
  for (int i = 0; i < s.dim_i; ++i) {
    for (int j = 0; j < s.dim_j; ++j) {
      std::array<double, 4> in{};
      for (int side = 0; side < 4; ++side) {
        const int ni = i + di[side];
        const int nj = j + dj[side];
        if (there(ni, nj)) in[static_cast<std::size_t>(side)] = flows(ni, nj)[static_cast<std::size_t>(side ^ 1)];
      }
      for (const double flow : flows(i, j)) s.water[i][j] -= flow;
      s.water[i][j] += (in[0] + in[1]) + (in[2] + in[3]);
      s.energy[i][j] = (1 - friction) * s.energy[i][j] + ((in[0] - in[1]) + (in[2] - in[3]));
    }
  }
}

// i is x and j is y.
PlainWater plain_of(const WaterAutomaton& automaton) {
  PlainWater plain;
  plain.dim_i = automaton.size().x;
  plain.dim_j = automaton.size().y;
  for (int i = 0; i < plain.dim_i; ++i) {
    for (Rows* rows : {&plain.terrain, &plain.water, &plain.energy}) rows->emplace_back();
    for (int j = 0; j < plain.dim_j; ++j) {
      const auto x = static_cast<std::size_t>(i);
      plain.terrain.back().push_back(automaton.terrain(j)[x]);
      plain.water.back().push_back(automaton.water(j)[x]);
      plain.energy.back().push_back(automaton.energy(j)[x]);
    }
  }
  return plain;
}

WaterAutomaton automaton_on(glm::ivec2 size, const std::vector<double>& terrain, const std::vector<double>& depth,
                            WaterOptions options, const Context& context = Context()) {
  auto made = WaterAutomaton::create(size, terrain, depth, std::move(options), context);
  EXPECT_TRUE(made) << made.error().message;
  return std::move(*made);
}

// Hills with water everywhere, deeper in one corner.
WaterAutomaton hills(glm::ivec2 size, WaterOptions options) {
  TerrainOptions terrain;
  terrain.size = size;
  terrain.relief = 6;
  const auto land = make_terrain(terrain, Context());
  std::vector<double> heights((*land)->values.begin(), (*land)->values.end());
  std::vector<double> depth(heights.size(), 0.25);
  for (std::size_t n = 0; n < depth.size() / 5; ++n) depth[n] = 3;
  return automaton_on(size, heights, depth, std::move(options));
}

TEST(PrintedRule, MatchesHandComputedStep) {
  WaterOptions options;
  options.rule = WaterRule::printed;
  options.friction = 0;
  options.flow_div = 4;
  WaterAutomaton automaton = automaton_on({3, 3}, std::vector<double>(9, 0), {0, 0, 0, 0, 4, 0, 0, 0, 0}, options);
  ASSERT_TRUE(automaton.run(1));
  // Each flow takes a quarter of what the previous one left: 1, 0.75, 0.5625, 0.421875.
  EXPECT_EQ(automaton.water(1)[0], 1.0);
  EXPECT_EQ(automaton.energy(1)[0], -1.0);
  EXPECT_EQ(automaton.water(0)[1], 0.5625);
  EXPECT_EQ(automaton.energy(0)[1], -0.5625);
  // The right cell (depth 0.75, energy 0.75) tests its left side: 1.5 exceeds 1.265625, but the flow 0.75 - 0.75 -
  // 1.265625 is negative. So the deeper middle cell loses 0.31640625, which flows uphill.
  EXPECT_EQ(automaton.water(1)[1], 1.265625 - 0.31640625);
}

TEST(PrintedRule, MatchesListing) {
  for (const double friction : {0.0, 0.3, 1.0}) {
    WaterOptions options;
    options.rule = WaterRule::printed;
    options.friction = friction;
    options.flow_div = 3;
    WaterAutomaton automaton = hills({7, 5}, options);
    PlainWater plain = plain_of(automaton);
    for (int step = 0; step < 40; ++step) {
      ASSERT_TRUE(automaton.run(1));
      listing(plain, friction, 3);
      const PlainWater now = plain_of(automaton);
      ASSERT_EQ(now.water, plain.water) << "step " << step;
      ASSERT_EQ(now.energy, plain.energy) << "step " << step;
    }
  }
}

TEST(PrintedRule, MakesNegativeDepths) {
  WaterOptions options;
  options.friction = 0;
  WaterAutomaton kept = hills({16, 16}, options);
  options.rule = WaterRule::printed;
  WaterAutomaton printed = hills({16, 16}, options);
  while (printed.extremes().least_depth > -0.01) {
    ASSERT_LT(printed.steps_done(), 200U);
    ASSERT_TRUE(printed.run(1) && kept.run(1));
    EXPECT_GE(kept.extremes().least_depth, 0);
  }
  EXPECT_LT(printed.balance().drift(), 1e-12) << "what goes below zero is elsewhere above";
  ASSERT_TRUE(printed.run(400) && kept.run(400));
  EXPECT_FALSE(printed.balance().drift() < 1) << "until the numbers are so large that rounding swallows the water";
  EXPECT_LT(kept.balance().drift(), 1e-12);
}

TEST(ConservativeRule, MatchesHeader) {
  for (const double flow_div : {1.0, 2.5, 4.0}) {
    WaterOptions options;
    options.friction = 0.2;
    options.flow_div = flow_div;
    WaterAutomaton automaton = hills({37, 11}, options);
    PlainWater plain = plain_of(automaton);
    for (int step = 0; step < 100; ++step) {
      ASSERT_TRUE(automaton.run(1));
      conservative(plain, 0.2, flow_div);
      const PlainWater now = plain_of(automaton);
      for (int i = 0; i < plain.dim_i; ++i) {
        for (int j = 0; j < plain.dim_j; ++j) {
          ASSERT_NEAR(now.water[i][j], plain.water[i][j], 1e-12) << "step " << step;
          ASSERT_NEAR(now.energy[i][j], plain.energy[i][j], 1e-12) << "step " << step;
        }
      }
    }
  }
}

TEST(ConservativeRule, ConservesWaterOverTenThousandSteps) {
  for (const double flow_div : {1.0, 4.0}) {
    WaterOptions options;
    options.flow_div = flow_div;
    options.sources = {{{2, 3}, 0.037}, {{20, 11}, 0.3}};
    options.drains = {{{15, 9}, 0.21}, {{0, 0}, 100}};
    WaterAutomaton automaton = hills({24, 18}, options);
    double least = 0;
    for (int n = 0; n < 100; ++n) {
      ASSERT_TRUE(automaton.run(100));
      least = std::min(least, automaton.extremes().least_depth);
    }
    const WaterBalance balance = automaton.balance();
    EXPECT_EQ(automaton.steps_done(), 10'000U);
    EXPECT_NEAR(balance.poured, 3370, 1e-9);
    EXPECT_GT(balance.drained, 1000);
    EXPECT_LE(std::abs(balance.there + balance.drained - balance.poured - balance.at_start), 1e-12 * balance.poured);
    EXPECT_LE(balance.drift(), 1e-12);
    EXPECT_GE(least, 0);
  }
}

TEST(ConservativeRule, LeavesLakeUnchanged) {
  std::vector<double> terrain;
  std::vector<double> depth;
  for (int n = 0; n < 48; ++n) {
    terrain.push_back(0.125 * (n * 7 % 13));
    depth.push_back(std::max(1.25 - terrain.back(), 0.0));
  }
  WaterAutomaton automaton = automaton_on({8, 6}, terrain, depth, {});
  ASSERT_TRUE(automaton.run(100));
  for (int y = 0; y < 6; ++y) {
    for (std::size_t x = 0; x < 8; ++x) EXPECT_EQ(automaton.water(y)[x], depth[x + 8 * static_cast<std::size_t>(y)]);
  }
}

// An even lake with energy E passes 2 E / D over each face, so a cell gets 4 E / D from its left and back and keeps (1
// - F) E. The movement decays if D F is above 4.
TEST(ConservativeRule, ComesToRestAboveFourOverFriction) {
  for (const auto& [friction, flow_div, rests] :
       {std::tuple{0.8, 5.5, true}, std::tuple{0.5, 8.5, true}, std::tuple{0.3, 14.0, true},
        std::tuple{0.8, 4.5, false}, std::tuple{0.5, 6.0, false}, std::tuple{0.3, 12.0, false}}) {
    WaterOptions options;
    options.friction = friction;
    options.flow_div = flow_div;
    std::vector<double> depth(144, 0);
    depth[0] = 144;
    WaterAutomaton automaton = automaton_on({12, 12}, std::vector<double>(144, 0), depth, options);
    ASSERT_TRUE(automaton.run(20'000));
    const WaterExtremes found = automaton.extremes();
    EXPECT_EQ(found.max_depth - found.least_depth < 1e-9, rests) << friction << " " << flow_div;
  }
}

TEST(ConservativeRule, IsBitwiseIndependentOfThreads) {
  const auto water_of = [](int threads) {
    WaterOptions options;
    options.sources = {{{100, 70}, 2}};
    WaterAutomaton automaton = hills({300, 200}, options);
    tbb::task_arena arena(threads);
    arena.execute([&] { EXPECT_TRUE(automaton.run(60)); });
    return plain_of(automaton);
  };
  const PlainWater one = water_of(1);
  const PlainWater two = water_of(2);
  EXPECT_EQ(two.water, one.water);
  EXPECT_EQ(two.energy, one.energy);
}

TEST(Water, StopsBetweenStepsWhenCancelled) {
  const Context context;
  WaterAutomaton automaton = automaton_on({4, 4}, std::vector<double>(16, 0), {}, {}, context);
  ASSERT_TRUE(automaton.run(3));
  context.cancel();
  EXPECT_EQ(automaton.run(5).error().code, ErrorCode::cancelled);
  EXPECT_EQ(automaton.steps_done(), 3U);
}

TEST(Water, RejectsInvalidOptions) {
  const std::vector<double> flat(12, 0);
  const auto said = [&](glm::ivec2 size, const std::vector<double>& terrain, const std::vector<double>& depth) {
    const auto made = WaterAutomaton::create(size, terrain, depth, {}, Context());
    return made ? std::string("made") : made.error().message;
  };
  EXPECT_EQ(said({4, 3}, flat, {}), "made");
  EXPECT_NE(said({5, 3}, flat, {}).find("15 cells, found 12"), std::string::npos);
  EXPECT_NE(said({4, 3}, flat, std::vector<double>(12, -1)).find("depths of 0 or more"), std::string::npos);
  EXPECT_NE(said({4, 3}, std::vector<double>(12, std::nan("")), {}).find("finite heights"), std::string::npos);
  const auto with = [&](const auto& change) {
    WaterOptions options;
    change(options);
    const auto made = WaterAutomaton::create({4, 3}, flat, {}, options, Context());
    return made ? std::string("made") : made.error().message;
  };
  using Options = WaterOptions;
  EXPECT_NE(with([](Options& o) { o.friction = 1.5; }).find("0 to 1, found 1.5"), std::string::npos);
  EXPECT_NE(with([](Options& o) { o.flow_div = 0.5; }).find("1 or more, found 0.5"), std::string::npos);
  EXPECT_NE(with([](Options& o) { o.sources = {{{4, 0}, 1}}; }).find("0,0 to 3,2, found 4,0"), std::string::npos);
  EXPECT_NE(with([](Options& o) { o.drains = {{{0, 0}, 0}}; }).find("a rate above 0"), std::string::npos);
  const auto poor = WaterAutomaton::create({4, 3}, flat, {}, {}, Context(MemoryBudget(100)));
  EXPECT_EQ(poor.error().hint, Hint(Remedy::raise, Setting::memory_limit));
}

}  // namespace
}  // namespace isoextract::simulate
