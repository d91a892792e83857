#include "convert/stage_report.hpp"
#include "convert/json_values.hpp"

#include <gtest/gtest.h>

namespace isoextract::convert {
namespace {

const Figures kFigures{{Key::method, "taubin"},
                       {Key::vertices, 24},
                       {Key::greatest_move, Figures{{Key::voxels, 0.5}, {Key::world, 2.0}}},
                       Figure::of_tables(Key::unit_of_lengths, "mm"),
                       {Key::genus, Value()}};

TEST(StageReport, FindsFiguresByKey) {
  EXPECT_EQ(value_at<std::string>(kFigures, {Key::method}), "taubin");
  EXPECT_EQ(value_at<double>(kFigures, {Key::greatest_move, Key::world}), 2.0);
  EXPECT_EQ(value_at<std::string>(kFigures, {Key::unit_of_lengths}), "mm");
  EXPECT_EQ(find(kFigures, {Key::genus}), nullptr) << "null is no figure";
  EXPECT_EQ(find(kFigures, {Key::volume}), nullptr);
  EXPECT_EQ(find(kFigures, {Key::greatest_move, Key::volume}), nullptr);
}

TEST(StageReport, ListsFiguresInOrder) {
  StageReport report = report_on(StageName::smooth, "fire.vdb");
  report.id = 0.5;
  report.grid = "heat";
  report.add_timed(kFigures, {1, 2});
  EXPECT_EQ(entry_of(report, report.entries.front()).dump(),
            R"({"iso":0.5,"method":"taubin","vertices":24,"greatest_move":{"voxels":0.5,"world":2.0},"genus":null,)"
            R"("time":{"wall_seconds":1.0,"cpu_seconds":2.0},"grid":"heat"})");
  EXPECT_EQ(text_of(report.entries.front()),
            "method taubin, 24 vertices, greatest move 0.5 voxels, 2 world, genus null");
  ASSERT_EQ(times_of(report).size(), 1U);
  EXPECT_EQ(times_of(report)[0].stage, StageName::smooth);
}

// A stage that is part of another reports no time of its own, and parts replace the whole time.
TEST(StageReport, ReportsEachTimeOnce) {
  StageReport report = report_on(StageName::pack, "a.glb");
  report.time = StageTime{1, 1};
  EXPECT_TRUE(times_of(report).empty());
  report.parts.push_back({StageName::count, 0.5, {1, 1}});
  EXPECT_EQ(times_of(report).size(), 1U);
}

TEST(Stages, AreIndexedByStageName) {
  for (const StageInfo& stage : kStages) EXPECT_EQ(&stage_info(stage.name), &stage) << stage.word;
}

}  // namespace
}  // namespace isoextract::convert
