#include "batch/existing_files.hpp"

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/temp_folder.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

convert::ConversionJob job_of(const fs::path& output, mesh_io::MeshFormat format = mesh_io::MeshFormat::stl) {
  convert::ConversionJob job;
  job.file = convert::MeshFileOptions{format};
  job.outputs = {{output.string(), {convert::IsoChoice::all_labels()}}};
  return job;
}

void make_files(const TempFolder& folder, const std::vector<std::string>& names) {
  for (const std::string& name : names) test::write_bytes(folder / name, "mine");
}

// Returns the names of the files that exist for this output name.
std::vector<std::string> found(ExistingFiles& existing, const TempFolder& folder, const std::string& output,
                               mesh_io::MeshFormat format = mesh_io::MeshFormat::stl) {
  std::vector<std::string> names;
  for (const fs::path& file : existing.find(job_of(folder / output, format))) {
    EXPECT_EQ(file.parent_path(), folder.path());
    names.push_back(file.filename().string());
  }
  return names;
}

std::vector<std::string> names_of(const std::vector<convert::OutputFileJob>& outputs) {
  std::vector<std::string> names;
  for (const convert::OutputFileJob& output : outputs) names.push_back(fs::path(output.path).filename().string());
  return names;
}

using Names = std::vector<std::string>;

TEST(MatchOutputName, MatchesNumbersAsLabels) {
  EXPECT_EQ(match_output_name("o_5.stl", "o_{label}.stl"), "o_5.stl");
  EXPECT_EQ(match_output_name("o_-12.stl", "o_{label}.stl"), "o_-12.stl");
  EXPECT_EQ(match_output_name("o_4-7_4.stl", "o_{label}-{label}_{label}.stl"), "o_4-7_4.stl");
  for (const char* other :
       {"o_.stl", "o_-.stl", "o_+5.stl", "o_5_.stl", "o_5_1.stl", "o_5_02.stl", "o_5_2_3.stl", "o_five.stl",
        "o_5.stl.old", "xo_5.stl", "o_5.ply", "o_{label}.stl", "o_--5.stl", "o_ 5.stl", ""}) {
    EXPECT_FALSE(match_output_name(other, "o_{label}.stl")) << other;
  }
}

// convert::LabelFileNames gives these names to a label that occurs in several layers.
TEST(MatchOutputName, MatchesRepeatedLabels) {
  EXPECT_EQ(match_output_name("o_5_2.stl", "o_{label}.stl"), "o_5_2.stl");
  EXPECT_EQ(match_output_name("o_-5_12.stl", "o_{label}.stl"), "o_-5_12.stl");
  EXPECT_EQ(match_output_name("5_2_3.stl", "{label}_3.stl"), "5_2_3.stl");
  EXPECT_EQ(match_output_name("5_3.stl", "{label}_3.stl"), "5_3.stl");
  EXPECT_EQ(match_output_name("o_5_2_1.stl", "o_{label}_{piece}.stl"), "o_5_2_{piece}.stl");
  const TempFolder folder;
  make_files(folder, {"o_5.stl", "o_5_2.stl", "o_5_2_2.stl"});
  ExistingFiles existing;
  EXPECT_EQ(found(existing, folder, "o_{label}.stl"), (Names{"o_5.stl", "o_5_2.stl"}));
}

TEST(MatchOutputName, MatchesTextsAsNames) {
  EXPECT_EQ(match_output_name("1_left atrium.stl", "1_{name}.stl"), "1_left atrium.stl");
  EXPECT_EQ(match_output_name("1_a.stl.stl", "1_{name}.stl"), "1_a.stl.stl");
  EXPECT_EQ(match_output_name("f/1_a_b_3.stl", "f/1_{name}_{label}.stl"), "f/1_a_b_3.stl");
  EXPECT_FALSE(match_output_name("1_.stl", "1_{name}.stl"));
  EXPECT_FALSE(match_output_name("1_a/b.stl", "1_{name}.stl"));
}

TEST(MatchOutputName, KeepsPlaceholderOfFirstBody) {
  EXPECT_EQ(match_output_name("o_11_1.stl", "o_{label}_{piece}.stl"), "o_11_{piece}.stl");
  EXPECT_FALSE(match_output_name("o_11_2.stl", "o_{label}_{piece}.stl"));
  EXPECT_EQ(match_output_name("plain.stl", "plain.stl"), "plain.stl");
}

TEST(ExistingFiles, FindsFilesOfLabels) {
  const TempFolder folder;
  make_files(folder, {"o_1_2.stl", "o_1_-3.stl", "o_11_2.stl", "o_1_x.stl", "o_2_left lung.stl", "9_7.stl", "8_7.stl"});
  fs::create_symlink("absent", folder / "o_1_4.stl");
  fs::create_symlink("9_7.stl", folder / "o_1_5.stl");
  ExistingFiles existing;
  EXPECT_EQ(found(existing, folder, "o_1_{label}.stl"), (Names{"o_1_-3.stl", "o_1_2.stl", "o_1_5.stl"}));
  EXPECT_EQ(found(existing, folder, "o_2_{name}.stl"), Names{"o_2_left lung.stl"});
  EXPECT_EQ(found(existing, folder, "{label}_7.stl"), (Names{"8_7.stl", "9_7.stl"}));
  EXPECT_EQ(found(existing, folder, "o_3_{label}.stl"), Names());
  EXPECT_EQ(found(existing, folder, "9_7.stl"), Names{"9_7.stl"});
  EXPECT_EQ(found(existing, folder, "7_9.stl"), Names());
  EXPECT_TRUE(existing.find(job_of(folder / "none/{label}.stl")).empty());
}

TEST(ExistingFiles, FindsDataFilesAndFirstBodies) {
  const TempFolder folder;
  make_files(folder, {"1_2.gltf", "1_2.bin", "1_3.bin", "b_4_1.stl", "b_4_2.stl", "b_5_2.stl"});
  ExistingFiles existing;
  EXPECT_EQ(found(existing, folder, "1_{label}.gltf", mesh_io::MeshFormat::gltf),
            (Names{"1_2.gltf", "1_2.bin", "1_3.bin"}));
  EXPECT_EQ(names_of(existing.find_label_outputs(job_of(folder / "1_{label}.gltf", mesh_io::MeshFormat::gltf))),
            Names{"1_2.gltf"});
  EXPECT_EQ(found(existing, folder, "b_{label}_{piece}.stl"), Names{"b_4_1.stl"});
  EXPECT_EQ(names_of(existing.find_label_outputs(job_of(folder / "b_{label}_{piece}.stl"))), Names{"b_4_{piece}.stl"});
  EXPECT_TRUE(existing.find_label_outputs(job_of(folder / "b_4_1.stl")).empty());
}

// It would take 25 million comparisons to try each name for each frame.
TEST(ExistingFiles, FindsFilesOfThousandsOfFrames) {
  constexpr int kFrames = 5000;
  const TempFolder folder;
  for (int i = 0; i < kFrames; ++i) test::write_bytes(folder / (std::to_string(i) + "_1_" + std::to_string(i)), "");
  ExistingFiles existing;
  for (int i = 0; i < kFrames; ++i) {
    const std::string frame = std::to_string(i);
    ASSERT_EQ(found(existing, folder, frame + "_{label}_" + frame), Names{frame + "_1_" + frame});
    ASSERT_EQ(found(existing, folder, "{name}_1_" + frame), Names{frame + "_1_" + frame});
  }
  make_files(folder, {"7_2_7"});
  EXPECT_EQ(found(existing, folder, "7_{label}_7"), Names{"7_1_7"}) << "the folder is listed once";
}

TEST(FindLabelOutputs, LeavesOutFilesOfSeveralFrames) {
  const TempFolder folder;
  make_files(folder, {"15.stl", "111.stl", "112.stl", "2x.stl"});
  BatchJob batch;
  for (const int frame : {1, 2, 11}) {
    batch.frames.push_back({frame, job_of(folder / (std::to_string(frame) + "{label}.stl"))});
  }
  const auto outputs = find_label_outputs(batch);
  ASSERT_EQ(outputs.size(), 3U);
  EXPECT_EQ(names_of(outputs[0]), Names{"15.stl"});
  EXPECT_TRUE(outputs[1].empty());
  EXPECT_TRUE(outputs[2].empty());
}

}  // namespace
}  // namespace isoextract::batch
