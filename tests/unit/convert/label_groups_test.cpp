// Labels that are made side by side, beside the same labels one by one: on one thread, each label is made, written and
// freed before the next one.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <nlohmann/json.hpp>

#include "convert/conversion.hpp"
#include "convert/stage_report.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::convert {
namespace {

// Records the events as text, in order.
class Texts final : public Events {
 public:
  void note(const Note& note) override { texts.push_back(note.text); }
  void end(const StageReport& report) override {
    for (const Figures& figures : report.entries) {
      if (report.stage == StageName::extract || report.stage == StageName::relax) {
        texts.push_back(fmt::format("{}: {}", report.subject, json_of(figures).dump()));
      }
    }
  }

  std::vector<std::string> texts;
};

struct Converted {
  std::optional<Error> error;
  std::vector<std::string> texts;
  std::map<std::string, std::string> files;
  std::uint64_t peak = 0;  // of reserved memory
};

class LabelGroups : public testing::Test {
 protected:
  // Writes a map of 36 x 30 x 15 samples with 600 labels: more than are made at the same time.
  void SetUp() override {
    std::ofstream file(folder_ / "map.npy", std::ios::binary);
    std::string header = "{'descr': '<u2', 'fortran_order': False, 'shape': (15, 30, 36), }";
    header.resize(117, ' ');
    file << std::string("\x93NUMPY\x01\x00\x76\x00", 10) << header << '\n';
    for (int z = 0; z < 15; ++z) {
      for (int y = 0; y < 30; ++y) {
        for (int x = 0; x < 36; ++x) {
          const int label = 1 + (x / 3 + y % 2 * (x / 17)) % 12 + 12 * (y / 3) + 120 * (z / 3);
          file.put(static_cast<char>(label & 0xFF)).put(static_cast<char>(label >> 8));
        }
      }
    }
  }

  ConversionJob job(mesh_io::MeshFormat format, const std::string& name) {
    ConversionJob one;
    one.source.input = folder_ / "map.npy";
    one.file = MeshFileOptions{format};
    one.surface.method = extract::Method::surface_nets;
    one.normals = Normals::none;
    one.outputs = {{folder_ / "out" / name, {IsoChoice::all_labels()}}};
    return one;
  }

  Converted run(const ConversionJob& job, std::size_t threads, std::uint64_t limit = std::uint64_t{1} << 40) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    std::filesystem::remove_all(folder_ / "out");
    std::filesystem::create_directory(folder_ / "out");
    const Context context{MemoryBudget(limit)};
    Texts texts;
    const Outcome outcome = convert::run(job, context, texts);
    Converted one{outcome.error, std::move(texts.texts), {}, outcome.reserved_memory};
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "out")) {
      one.files[entry.path().filename()] = test::read_bytes(entry.path());
    }
    return one;
  }

  void expect_same(const Converted& one_by_one, const Converted& at_once) {
    EXPECT_EQ(one_by_one.error.has_value(), at_once.error.has_value());
    if (one_by_one.error && at_once.error) {
      EXPECT_EQ(one_by_one.error->message, at_once.error->message);
    }
    EXPECT_EQ(one_by_one.texts, at_once.texts);
    EXPECT_TRUE(one_by_one.files == at_once.files);
  }

  test::TempFolder folder_;
};

TEST_F(LabelGroups, WriteSameFilesAsOneByOne) {
  for (const auto& [format, name] : {std::pair(mesh_io::MeshFormat::glb, "all.glb"),
                                     {mesh_io::MeshFormat::ply, "{label}.ply"},
                                     {mesh_io::MeshFormat::stl, "{label}.stl"}}) {
    const Converted one_by_one = run(job(format, name), 1);
    EXPECT_FALSE(one_by_one.error);
    EXPECT_EQ(one_by_one.files.size(), format == mesh_io::MeshFormat::glb ? 1U : 600U);
    expect_same(one_by_one, run(job(format, name), 4));
  }
}

TEST_F(LabelGroups, StopAtTheFirstFailedLabelInOrder) {
  ConversionJob cut = job(mesh_io::MeshFormat::ply, "{label}.ply");
  cut.source.clip = {{glm::dvec3(0, 0, -1), -8}};  // removes labels from 361 on
  const Converted one_by_one = run(cut, 1);
  ASSERT_TRUE(one_by_one.error);
  EXPECT_NE(one_by_one.error->message.find("label 361"), std::string::npos) << one_by_one.error->message;
  EXPECT_EQ(one_by_one.files.size(), 360U);
  expect_same(one_by_one, run(cut, 4));
}

TEST_F(LabelGroups, NeedNoMoreMemoryThanOneByOne) {
  ConversionJob voxels = job(mesh_io::MeshFormat::ply, "{label}.ply");
  voxels.surface.method = extract::Method::voxels;
  const Converted one_by_one = run(voxels, 1);
  EXPECT_GT(run(voxels, 4).peak, one_by_one.peak);
  const Converted limited = run(voxels, 4, one_by_one.peak);
  EXPECT_LE(limited.peak, one_by_one.peak);
  expect_same(one_by_one, limited);
}

}  // namespace
}  // namespace isoextract::convert
