#include "convert/conversion.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "convert/json_values.hpp"
#include "convert/source.hpp"
#include "field/sparse_lookup.hpp"
#include "support/outcomes.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::convert {
namespace {

namespace fs = std::filesystem;

// Records the events, in order.
class Log final : public Events {
 public:
  void note(const Note& note) override { lines.push_back("note " + note.text); }
  void end(const StageReport& report) override {
    const auto of_figures = [&](Key key) { return find(report.entries.at(0), {key})->json().dump(); };
    if (report.stage == StageName::read) {
      lines.push_back("read " + of_figures(Key::path));
      if (cancel_at_read != nullptr) cancel_at_read->cancel();
      if (no_memory_after_read) throw std::bad_alloc();
    }
    if (report.stage == StageName::extract) {
      lines.push_back("extracted " + of_figures(Key::triangles));
      if (memory != nullptr) reserved.push_back(memory->reserved());
    }
    if (report.output) lines.push_back("written " + std::to_string(report.output->surfaces.size()));
  }

  std::vector<std::string> lines;
  const Context* cancel_at_read = nullptr;
  bool no_memory_after_read = false;
  const MemoryBudget* memory = nullptr;  // read after each extraction
  std::vector<std::uint64_t> reserved;
};

class ConversionTest : public testing::Test {
 protected:
  ConversionJob job(const std::string& input, double iso, const std::string& name) {
    ConversionJob one;
    one.source.input = input;
    one.file = MeshFileOptions{mesh_io::MeshFormat::ply};
    one.normals = Normals::none;
    one.outputs = {{(folder_ / name).string(), {iso}}};
    return one;
  }

  ConversionJob several(mesh_io::MeshFormat format, std::vector<IsoChoice> isos) {
    ConversionJob one = job("demo:gyroid?size=40", 0, "several");
    one.file = MeshFileOptions{format};
    one.outputs[0].isos = std::move(isos);
    return one;
  }

  // Writes the same surface four times, and returns the reserved memory after each extraction.
  std::vector<std::uint64_t> reserved_by_four(mesh_io::MeshFormat format) {
    const Context context;
    log_.memory = &context.memory();
    log_.reserved.clear();
    EXPECT_TRUE(convert::run(several(format, {0.1, 0.1, 0.1, 0.1}), context, log_).done());
    log_.memory = nullptr;
    return std::exchange(log_.reserved, {});
  }

  std::uint64_t peak_of(mesh_io::MeshFormat format, std::vector<IsoChoice> isos) {
    const Outcome outcome = convert::run(several(format, std::move(isos)), Context(), log_);
    EXPECT_TRUE(outcome.done()) << outcome.error->message;
    return outcome.reserved_memory;
  }

  static std::vector<std::uint64_t> triangles_of(const MeshCollector& collected) {
    std::vector<std::uint64_t> triangles;
    for (const mesh::Mesh& surface : collected.meshes) triangles.push_back(surface.triangles.size());
    return triangles;
  }
  static std::vector<std::uint64_t> triangles_of(const Outcome& outcome, StageName stage) {
    return test::figures<std::uint64_t>(outcome, stage, Key::triangles);
  }

  Outcome run(const ConversionJob& job) { return convert::run(job, Context(), log_, {true}); }

  test::TempFolder folder_;
  Log log_;
};

TEST_F(ConversionTest, ReportsStagesInOrder) {
  const Outcome outcome = run(job("demo:sphere?size=16", 0, "a.ply"));
  ASSERT_TRUE(outcome.done()) << outcome.error->message;
  const std::vector<std::uint64_t> extracted = triangles_of(outcome, StageName::extract);
  ASSERT_EQ(extracted.size(), 1U);
  EXPECT_EQ(log_.lines, (std::vector<std::string>{"read \"demo:sphere?size=16\"",
                                                  "extracted " + std::to_string(extracted[0]), "written 1"}));
  EXPECT_EQ(triangles_of(outcome, StageName::mesh_facts), extracted);
  EXPECT_EQ(test::figures<bool>(outcome, StageName::mesh_facts, Key::closed), std::vector<bool>{true});
  ASSERT_EQ(outcome.files.size(), 1U);
  EXPECT_EQ(outcome.files[0].bytes, fs::file_size(folder_ / "a.ply"));
  EXPECT_EQ(outcome.backend, "cpu");
}

TEST_F(ConversionTest, CollectsSourceWithAllSamples) {
  {
    std::ofstream file(folder_ / "block.xyz");
    file << "216\nblock\n";
    for (int n = 0; n < 216; ++n) file << n % 6 << ' ' << n / 6 % 6 << ' ' << n / 36 << '\n';
  }
  ConversionJob wanted = job((folder_ / "block.xyz").string(), 0.5, "block.ply");
  wanted.source.particles.expected = true;
  wanted.source.particles.radius = 0.6;
  const Outcome written = run(wanted);
  ASSERT_TRUE(written.done()) << written.error->message;
  log_.lines.clear();
  MeshCollector collected{.wants_source = true};
  ASSERT_TRUE(convert::run(wanted, Context(), log_, {}, nullptr, &collected).done());
  EXPECT_EQ(triangles_of(collected), triangles_of(written, StageName::mesh_facts));
  EXPECT_EQ(std::ranges::count_if(log_.lines, [](const std::string& line) { return line.starts_with("read "); }), 1);
  ASSERT_TRUE(collected.source.has_value());
  EXPECT_TRUE(collected.source->of_particles);
  // Block in the middle, which the surface alone does not need.
  const auto& samples = std::get<field::SparseSamples>(collected.source->field.samples);
  const field::SparseLookup lookup(samples);
  const glm::dvec3 middle = collected.source->field.index_to_world.inverse()(glm::dvec3(2.5));
  EXPECT_GE(lookup.block(field::block_origin(glm::ivec3(middle))), 0);

  wanted.outputs[0].isos = {99};
  MeshCollector none{.wants_source = true};
  EXPECT_FALSE(convert::run(wanted, Context(), log_, {}, nullptr, &none).done());
  EXPECT_FALSE(none.source.has_value());
}

TEST_F(ConversionTest, CollectsMeshesInsteadOfWriting) {
  const ConversionJob wanted = several(mesh_io::MeshFormat::glb, {0.1, 9, 0.3});
  ConversionJob skipping = wanted;
  skipping.empty = EmptyPolicy::skip;
  const Outcome written = run(skipping);
  ASSERT_TRUE(written.done()) << written.error->message;
  std::ofstream(folder_ / "several") << "old";

  MeshCollector collected;
  Outcome outcome = convert::run(skipping, Context(), log_, {true}, nullptr, &collected);
  ASSERT_TRUE(outcome.done()) << outcome.error->message;
  EXPECT_EQ(collected.ids, (std::vector<SurfaceId>{0.1, 0.3}));
  ASSERT_EQ(collected.meshes.size(), 2U);
  EXPECT_EQ(collected.meshes[0].name, "gyroid iso 0.1");
  EXPECT_EQ(collected.meshes[1].name, "gyroid iso 0.3");
  EXPECT_EQ(triangles_of(collected), triangles_of(written, StageName::mesh_facts));
  EXPECT_FALSE(collected.source.has_value());
  EXPECT_EQ(test::entries(outcome, StageName::mesh_facts).size(), 2U);
  EXPECT_TRUE(outcome.files.empty());
  EXPECT_EQ(test::read_bytes(folder_ / "several"), "old");

  skipping.outputs[0].isos = {9};  // no mesh to collect; a collecting conversion must not remove the old file
  collected = {};
  outcome = convert::run(skipping, Context(), log_, {}, nullptr, &collected);
  EXPECT_TRUE(outcome.done());
  EXPECT_TRUE(collected.meshes.empty());
  ASSERT_EQ(outcome.notes.size(), 1U);
  EXPECT_NE(outcome.notes[0].text.find("several contains only the other surfaces"), std::string::npos)
      << outcome.notes[0].text;
  EXPECT_EQ(test::read_bytes(folder_ / "several"), "old");

  skipping.empty = EmptyPolicy::write;
  EXPECT_TRUE(convert::run(skipping, Context(), log_, {}, nullptr, &collected).done());
  EXPECT_EQ(triangles_of(collected), std::vector<std::uint64_t>{0});
  skipping.empty = EmptyPolicy::error;
  EXPECT_EQ(convert::run(skipping, Context(), log_, {}, nullptr, &collected).error->code, ErrorCode::no_surface);
}

TEST_F(ConversionTest, ReturnsErrorAndLeavesNoFile) {
  for (const char* input : {"demo:nothing", "no-such-file.vdb", "demo:sphere?size=16"}) {
    const Outcome outcome = run(job(input, 9, "a.ply"));
    ASSERT_FALSE(outcome.done());
    EXPECT_EQ(outcome.error->message.find("--"), std::string::npos) << outcome.error->message;
    EXPECT_TRUE(folder_.names().empty());
  }
}

// std::bad_alloc is the only exception that rooms throw.
TEST_F(ConversionTest, ReturnsErrorOnBadAlloc) {
  log_.no_memory_after_read = true;
  const Outcome outcome = run(job("demo:sphere?size=16", 0, "a.ply"));
  ASSERT_FALSE(outcome.done());
  EXPECT_EQ(outcome.error->code, ErrorCode::out_of_memory);
  EXPECT_EQ(outcome.error->message, "demo:sphere?size=16: not enough memory");
  EXPECT_EQ(outcome.error->hint, Hint(Remedy::use, Setting::parts));
  EXPECT_TRUE(folder_.names().empty());
}

TEST_F(ConversionTest, NotesSkippedSurfaces) {
  ConversionJob two = job("demo:sphere?size=16", 0, "a.glb");
  two.file = MeshFileOptions{mesh_io::MeshFormat::glb};
  two.empty = EmptyPolicy::skip;
  two.outputs[0].isos = {0, 9};
  ASSERT_TRUE(run(two).done());
  EXPECT_EQ(log_.lines.back(), "written 1");
  two.outputs[0] = {(folder_ / "b.glb").string(), {9}};
  const Outcome outcome = run(two);
  ASSERT_TRUE(outcome.done());
  EXPECT_FALSE(fs::exists(folder_ / "b.glb"));
  EXPECT_EQ(log_.lines.back(), "written 0");
  EXPECT_NE(outcome.notes.at(0).text.find("the conversion did not write"), std::string::npos);
}

TEST_F(ConversionTest, RemovesOldFileOfSkippedOutput) {
  ConversionJob one = job("demo:sphere?size=16", 0, "a.gltf");
  one.file = MeshFileOptions{mesh_io::MeshFormat::gltf};
  one.empty = EmptyPolicy::skip;
  ASSERT_TRUE(run(one).done());
  ASSERT_EQ(folder_.names(), (std::set<std::string>{"a.bin", "a.gltf"}));
  one.outputs[0].isos = {9};
  const Outcome outcome = run(one);
  ASSERT_TRUE(outcome.done());
  EXPECT_TRUE(folder_.names().empty());
  EXPECT_NE(outcome.notes.at(0).text.find(" and removed the old "), std::string::npos) << outcome.notes.at(0).text;
}

TEST_F(ConversionTest, ReportsMissingCapsOnlyAtOpenBoundary) {
  const auto tells_of_caps = [&](const std::string& input, bool cap) {
    ConversionJob one = job(input, 0, "a.ply");
    one.surface.cap = cap;
    const Outcome outcome = run(one);
    return std::ranges::any_of(outcome.first(StageName::extract)->work,
                               [](const WorkFact& fact) { return fact.what == WorkTopic::caps; });
  };
  EXPECT_FALSE(tells_of_caps("demo:sphere?size=16", false));
  EXPECT_TRUE(tells_of_caps("demo:gyroid?size=16", false));
  EXPECT_FALSE(tells_of_caps("demo:gyroid?size=16", true));
}

// If the format allows it, a surface is written and freed before the next is extracted.
TEST_F(ConversionTest, HoldsOneMeshAtATime) {
  for (const mesh_io::MeshFormat format : {mesh_io::MeshFormat::obj, mesh_io::MeshFormat::gltf}) {
    const std::vector<std::uint64_t> reserved = reserved_by_four(format);
    EXPECT_EQ(reserved, std::vector(4, reserved.at(0))) << word_of(format);
    // Twice the same surface: an OBJ of one surface would take it part by part.
    const std::uint64_t largest =
        std::max({peak_of(format, {0, 0}), peak_of(format, {0.5, 0.5}), peak_of(format, {-0.7, -0.7})});
    EXPECT_EQ(peak_of(format, {0, 0.5, -0.7}), largest) << word_of(format);
  }
  const std::vector<std::uint64_t> held = reserved_by_four(mesh_io::MeshFormat::glb);
  EXPECT_EQ(held.at(3) - held.at(2), held.at(1) - held.at(0));
  EXPECT_GT(held.at(1), held.at(0)) << "a GLB begins with where everything is";
}

TEST_F(ConversionTest, LeavesNoFileIfLaterSurfaceFails) {
  for (const mesh_io::MeshFormat format :
       {mesh_io::MeshFormat::glb, mesh_io::MeshFormat::gltf, mesh_io::MeshFormat::obj}) {
    EXPECT_FALSE(run(several(format, {0, 9})).done());
    EXPECT_TRUE(folder_.names().empty()) << word_of(format);
  }
}

TEST_F(ConversionTest, RecordsEverySurfaceOfFile) {
  const Outcome outcome = run(several(mesh_io::MeshFormat::obj, {0, 0.5}));
  ASSERT_EQ(test::entries(outcome, StageName::mesh_facts).size(), 2U);
  std::vector<std::string> stages;
  for (const StageReport::Part& stage : outcome.times()) stages.emplace_back(word_of(stage.stage));
  const std::vector<std::string> once{"classify", "count", "emit"};
  std::vector<std::string> expected{"read"};
  for (int surface = 0; surface < 2; ++surface) expected.insert(expected.end(), once.begin(), once.end());
  expected.insert(expected.end(), {"mesh facts", "write"});
  EXPECT_EQ(stages, expected);
  EXPECT_EQ(triangles_of(outcome, StageName::mesh_facts), triangles_of(outcome, StageName::extract));
  const Figures second = test::entries(outcome, StageName::mesh_facts).at(1);
  EXPECT_EQ(value_at<double>(second, {Key::iso}), 0.5);
  EXPECT_EQ(value_at<std::string>(second, {Key::name}), "gyroid iso 0.5");
  EXPECT_EQ(log_.lines.back(), "written 2");
}

TEST_F(ConversionTest, EndsWhenCancelled) {
  const Context context;
  log_.cancel_at_read = &context;
  const Outcome outcome = convert::run(job("demo:sphere?size=16", 0, "a.ply"), context, log_);
  ASSERT_FALSE(outcome.done());
  EXPECT_EQ(outcome.error->code, ErrorCode::cancelled);
  EXPECT_TRUE(folder_.names().empty());
}

// Conversions side by side write the same bytes as one after the other, and keep their records apart.
TEST_F(ConversionTest, RunsTwoAtOnceIndependently) {
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
        threads.emplace_back([&, i] { outcomes[i] = convert::run(jobs[i], Context(), logs[i], {true}); });
      }
    }
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      ASSERT_TRUE(outcomes[i].done()) << outcomes[i].error->message;
      EXPECT_EQ(test::entries(outcomes[i], StageName::mesh_facts).size(), 1U);
      EXPECT_EQ(logs[i].lines.at(0), "read \"" + inputs[i] + "\"");
      EXPECT_EQ(test::read_bytes(folder_ / (std::to_string(i) + ".ply")), alone[i]);
    }
  }
}

}  // namespace
}  // namespace isoextract::convert
