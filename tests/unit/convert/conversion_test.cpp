#include "convert/conversion.hpp"

#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "support/temp_folder.hpp"

namespace isoextract::convert {
namespace {

namespace fs = std::filesystem;

// What was told, in order.
class Log final : public Events {
 public:
  void note(const std::string& text) override { lines.push_back("note " + text); }
  void opened(const extract::Extractor& extractor, const std::string&, const StageTime&) override {
    lines.push_back("opened " + std::string(extractor.name()));
  }
  void read(const std::string& input, const field::ScalarField&, const StageTime&) override {
    lines.push_back("read " + input);
    if (cancel_at_read != nullptr) cancel_at_read->cancel();
  }
  void extracted(const ExtractedSurface& surface) override {
    lines.push_back("extracted " + std::to_string(surface.triangles));
  }
  void written(const WrittenOutput& output) override {
    lines.push_back("written " + std::to_string(output.isos.size()) + " of " + std::to_string(output.job.isos.size()));
  }

  std::vector<std::string> lines;
  const Context* cancel_at_read = nullptr;
};

class ConversionTest : public testing::Test {
 protected:
  ConversionJob job(const std::string& input, double iso, const std::string& name) {
    ConversionJob one;
    one.source.input = input;
    one.format = meshes::MeshFormat::ply;
    one.normals = Normals::none;
    one.outputs = {{(folder_ / name).string(), {iso}}};
    return one;
  }

  Outcome run(const ConversionJob& job) { return convert::run(job, Context(), log_, {true, true}); }

  test::TempFolder folder_;
  Log log_;
};

TEST_F(ConversionTest, TellsItsStagesInOrderAndRecordsThem) {
  const Outcome outcome = run(job("demo:sphere?size=16", 0, "a.ply"));
  ASSERT_TRUE(outcome.done()) << outcome.error->message;
  ASSERT_EQ(log_.lines.size(), 4U);
  EXPECT_EQ(log_.lines[0], "opened cpu");
  EXPECT_EQ(log_.lines[1], "read demo:sphere?size=16");
  EXPECT_EQ(log_.lines[2], "extracted " + std::to_string(outcome.extractions.at(0).triangles));
  EXPECT_EQ(log_.lines[3], "written 1 of 1");
  ASSERT_EQ(outcome.meshes.size(), 1U);
  EXPECT_TRUE(outcome.meshes[0].topology.is_closed_oriented_manifold());
  ASSERT_EQ(outcome.files.size(), 1U);
  EXPECT_EQ(outcome.files[0].bytes, fs::file_size(folder_ / "a.ply"));
  EXPECT_EQ(outcome.backend, "cpu");
}

TEST_F(ConversionTest, AnErrorIsAValueAndLeavesNoFile) {
  for (const char* input : {"demo:nothing", "no-such-file.vdb", "demo:sphere?size=16"}) {
    const Outcome outcome = run(job(input, 9, "a.ply"));
    ASSERT_FALSE(outcome.done());
    EXPECT_EQ(outcome.error->message.find("--"), std::string::npos) << outcome.error->message;
    EXPECT_TRUE(folder_.names().empty());
  }
}

TEST_F(ConversionTest, SkippedSurfacesAreTold) {
  ConversionJob two = job("demo:sphere?size=16", 0, "a.glb");
  two.format = meshes::MeshFormat::glb;
  two.empty = EmptyPolicy::skip;
  two.outputs[0].isos = {0, 9};
  ASSERT_TRUE(run(two).done());
  EXPECT_EQ(log_.lines.back(), "written 1 of 2");
  two.outputs[0] = {(folder_ / "b.glb").string(), {9}};
  const Outcome outcome = run(two);
  ASSERT_TRUE(outcome.done());
  EXPECT_FALSE(fs::exists(folder_ / "b.glb"));
  EXPECT_EQ(log_.lines.back(), "written 0 of 1");
  EXPECT_NE(outcome.notes.at(0).find("was not written"), std::string::npos);
}

TEST_F(ConversionTest, EndsWhereItIsCancelled) {
  const Context context;
  log_.cancel_at_read = &context;
  const Outcome outcome = convert::run(job("demo:sphere?size=16", 0, "a.ply"), context, log_);
  ASSERT_FALSE(outcome.done());
  EXPECT_EQ(outcome.error->kind, ErrorKind::cancelled);
  EXPECT_TRUE(folder_.names().empty());
}

// Side by side they give what they give one after the other, and keep their records apart.
TEST_F(ConversionTest, TwoAtOnceDoNotMix) {
  const std::vector<std::string> inputs{"demo:gyroid?size=40", "demo:torus?size=50"};
  std::vector<std::string> alone;
  for (const std::string& input : inputs) {
    ASSERT_TRUE(run(job(input, 0, "alone.ply")).done());
    alone.push_back(test::read_bytes(folder_ / "alone.ply"));
  }
  for (int round = 0; round < 3; ++round) {
    std::vector<Outcome> outcomes(inputs.size());
    std::vector<Log> logs(inputs.size());
    std::vector<ConversionJob> jobs;
    for (std::size_t i = 0; i < inputs.size(); ++i) jobs.push_back(job(inputs[i], 0, std::to_string(i) + ".ply"));
    {
      std::vector<std::jthread> threads;
      for (std::size_t i = 0; i < inputs.size(); ++i) {
        threads.emplace_back([&, i] { outcomes[i] = convert::run(jobs[i], Context(), logs[i], {true, true}); });
      }
    }
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      ASSERT_TRUE(outcomes[i].done()) << outcomes[i].error->message;
      EXPECT_EQ(outcomes[i].meshes.size(), 1U);
      EXPECT_EQ(logs[i].lines.at(1), "read " + inputs[i]);
      EXPECT_EQ(test::read_bytes(folder_ / (std::to_string(i) + ".ply")), alone[i]);
    }
  }
}

}  // namespace
}  // namespace isoextract::convert
