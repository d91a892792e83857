#include "batch/output_names.hpp"

#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "batch/output_template.hpp"
#include "files/name_parts.hpp"
#include "support/hints.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;
using mesh_io::MeshFormat;
using Lines = std::vector<std::string>;

OutputSource output_source(std::int64_t frame, const std::string& input, const std::string& grid = {},
                           std::vector<convert::IsoChoice> isos = {0.5}) {
  return {frame, input, grid, std::move(isos)};
}

std::string expanded_name(const std::string& name, const OutputWords& words) {
  const auto parsed = OutputTemplate::parse(name);
  return parsed ? parsed->expand(words) : parsed.error().message;
}

TEST(OutputTemplate, ExpandsWordsAndNumbers) {
  const OutputWords words{"sim", 7, "density", "0.1"};
  EXPECT_EQ(expanded_name("o/{stem}_{frame:04}_{grid}_{iso}.glb", words), "o/sim_0007_density_0.1.glb");
  EXPECT_EQ(expanded_name("{:03}/m_####_%02d_{}_{frame}.ply", words), "007/m_0007_07_7_7.ply");
  EXPECT_EQ(expanded_name("a{{stem}}%%04d{#}#c#.ply", words), "a{stem}%04d##c#.ply");
  EXPECT_EQ(expanded_name("{iso}_{iso}", {"", 0, "", "p99"}), "p99_p99");
  EXPECT_EQ(expanded_name("f{}_{step}.ply", {"", 7, "", "", 2500}), "f7_2500.ply");
  EXPECT_EQ(expanded_name("{step:06}.ply", {"", 7, "", "", 2500}), "002500.ply");
  EXPECT_EQ(expanded_name("f{:04}", {"", -1, "", ""}), "f-0001");
  EXPECT_EQ(expanded_name("{stem", words), "{stem");
}

TEST(OutputTemplate, RefusesUnknownWords) {
  EXPECT_EQ(expanded_name("{names}.glb", {}),
            "{names}.glb: expected {stem}, {frame}, {frame:04}, {step}, {grid}, {iso}, {label}, {name} or {piece}, "
            "found '{names}'");
  for (const char* name : {"{Stem}.glb", "{iso:.2f}.glb", "{stem:04}", "{step:x}", "{ iso}", "{frame:x}", "{frame:040}",
                           "{:040}", "{1}"}) {
    const auto parsed = OutputTemplate::parse(name);
    ASSERT_FALSE(parsed) << name;
    EXPECT_EQ(parsed.error().code, ErrorCode::usage);
  }
}

TEST(OutputTemplate, ReportsWhichWordsItUses) {
  const auto names = OutputTemplate::parse("{iso}{{grid}}####");
  ASSERT_TRUE(names);
  EXPECT_TRUE(names->uses(OutputWord::iso));
  EXPECT_TRUE(names->uses(OutputWord::frame));
  EXPECT_FALSE(names->uses(OutputWord::grid));
  EXPECT_FALSE(names->uses(OutputWord::stem));
}

TEST(SafeInFileNames, ReturnsOneVisibleName) {
  EXPECT_EQ(files::safe_file_name("density"), "density");
  EXPECT_EQ(files::safe_file_name("Dichte \xc3\xa4\xe2\x82\xac\xf0\x9f\x92\xa7 v1.0"),
            "Dichte \xc3\xa4\xe2\x82\xac\xf0\x9f\x92\xa7 v1.0");
  EXPECT_EQ(files::safe_file_name("../../etc/passwd"), "___.._etc_passwd");
  EXPECT_EQ(files::safe_file_name(".."), "__");
  EXPECT_EQ(files::safe_file_name(".hidden"), "_hidden");
  EXPECT_EQ(files::safe_file_name("a\\b:c*d?e\"f<g>h|i"), "a_b_c_d_e_f_g_h_i");
  EXPECT_EQ(files::safe_file_name("a\nb\x1b[2J\x7f"), "a_b_[2J_");
  EXPECT_EQ(files::safe_file_name(std::string("a\0b", 3)), "a_b");
  EXPECT_EQ(files::safe_file_name("\xe9t\xe9"), "_t_");  // Latin-1, no valid UTF-8
  EXPECT_EQ(files::safe_file_name("x\xe2\x80\xae"
                                  "y"),
            "x___y");  // changes the writing direction
  EXPECT_EQ(files::safe_file_name("a\xc3"), "a_");
  EXPECT_EQ(files::safe_file_name("\xc3/b"), "__b");
  EXPECT_EQ(files::safe_file_name("\xf0\x9f/\x80"), "____");
  EXPECT_EQ(files::safe_file_name("\x80\x80/"), "___");
}

TEST(StemOf, RemovesFolderAndExtension) {
  EXPECT_EQ(stem_of("dir.x/a.b.vdb"), "a.b");
  EXPECT_EQ(stem_of("a.nii.gz"), "a");
  EXPECT_EQ(stem_of("demo:sphere?size=9"), "sphere");
  EXPECT_EQ(stem_of("demo:torus"), "torus");
}

class OutputNames : public testing::Test {
 protected:
  OutputNames() { fs::current_path(folder_.path()); }
  ~OutputNames() override { fs::current_path(before_); }

  static Lines named(const std::vector<OutputSource>& sources, const std::optional<std::string>& output,
                     MeshFormat format = MeshFormat::glb) {
    const auto names = name_outputs(sources, output, format);
    if (!names) {
      EXPECT_EQ(names.error().code, ErrorCode::usage);
      return {names.error().message};
    }
    Lines lines;
    for (const OutputFiles& files : *names) {
      for (const convert::OutputFileJob& file : files) {
        std::string line = file.path + ":";
        for (const convert::IsoChoice& iso : file.isos) line += " " + text_of(iso);
        if (file.grid) line += " of " + *file.grid;
        lines.push_back(line);
      }
    }
    return lines;
  }

 private:
  fs::path before_ = fs::current_path();
  test::TempFolder folder_;
};

TEST_F(OutputNames, NamesEveryFrameByTemplate) {
  EXPECT_EQ(named({output_source(1, "a_1.vdb"), output_source(12, "a_12.vdb")}, "out/m_{:04}.glb"),
            (Lines{"out/m_0001.glb: 0.5", "out/m_0012.glb: 0.5"}));
  EXPECT_EQ(named({output_source(1, "x/a.vdb"), output_source(2, "x/b.vdb")}, "{stem}.glb"),
            (Lines{"a.glb: 0.5", "b.glb: 0.5"}));
}

TEST_F(OutputNames, NamesFileForEachIso) {
  EXPECT_EQ(named({output_source(1, "a.vdb", "", {0.1, 0.2}), output_source(2, "b.vdb", "", {3})}, "{frame}_{iso}.ply",
                  MeshFormat::ply),
            (Lines{"1_0.1.ply: 0.1", "1_0.2.ply: 0.2", "2_3.ply: 3"}));
  EXPECT_EQ(named({output_source(1, "a.vdb", "", {0.1, 0.2})}, "a.glb"), Lines{"a.glb: 0.1 0.2"});
  const auto refused = name_outputs(std::vector{output_source(1, "a.vdb", "", {0.1, 0.2})}, "a.ply", MeshFormat::ply);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(test::has_step(refused.error().hint, Remedy::set, Setting::mesh_format));
}

TEST_F(OutputNames, NamesFileForEachGrid) {
  OutputSource source = output_source(1, "a.vdb", "density", {0.5, 1});
  source.more_grids = {"flame"};
  EXPECT_EQ(named({source}, "{grid}_{iso}.ply", MeshFormat::ply),
            (Lines{"density_0.5.ply: 0.5 of density", "density_1.ply: 1 of density", "flame_0.5.ply: 0.5 of flame",
                   "flame_1.ply: 1 of flame"}));
  EXPECT_EQ(named({source}, "{grid}.glb"), (Lines{"density.glb: 0.5 1 of density", "flame.glb: 0.5 1 of flame"}));
  EXPECT_EQ(named({source}, "{iso}.glb"), (Lines{"0.5.glb: 0.5", "1.glb: 1"}));
  const auto refused = name_outputs(std::vector{source}, "{iso}.ply", MeshFormat::ply);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "frame 1 (a.vdb, grid density): one ply file holds one surface, found 2 grids");
}

TEST_F(OutputNames, NamesFilesInFolderAfterInputs) {
  const std::vector<OutputSource> two{output_source(1, "x/a_1.vdb"), output_source(2, "x/a_2.vdb")};
  EXPECT_EQ(named(two, "out/"), (Lines{"out/a_1.glb: 0.5", "out/a_2.glb: 0.5"}));
  EXPECT_EQ(named(two, std::nullopt, MeshFormat::ply), (Lines{"a_1.ply: 0.5", "a_2.ply: 0.5"}));
  fs::create_directory("there");
  EXPECT_EQ(named(two, "there"), (Lines{"there/a_1.glb: 0.5", "there/a_2.glb: 0.5"}));
  fs::create_directory("{iso}##");
  EXPECT_EQ(named(two, "{iso}##"), (Lines{"{iso}##/a_1.glb: 0.5", "{iso}##/a_2.glb: 0.5"}));
  EXPECT_EQ(named(two, "new_{iso}/"), (Lines{"new_0.5/a_1.glb: 0.5", "new_0.5/a_2.glb: 0.5"}));
}

TEST_F(OutputNames, NumbersEqualStemsInFolder) {
  EXPECT_EQ(named({output_source(1, "demo:sphere?size=1"), output_source(2, "demo:sphere?size=2")}, "o/"),
            (Lines{"o/sphere_0001.glb: 0.5", "o/sphere_0002.glb: 0.5"}));
  EXPECT_EQ(named({output_source(-3, "s1/d.vdb"), output_source(123456, "s2/d.vdb")}, std::nullopt),
            (Lines{"d_-000003.glb: 0.5", "d_123456.glb: 0.5"}));
  EXPECT_EQ(named({output_source(1, "a.vdb", "fuel"), output_source(1, "a.vdb", "heat")}, "o/"),
            (Lines{"o/a_fuel.glb: 0.5", "o/a_heat.glb: 0.5"}));
  EXPECT_EQ(named({output_source(1, "a.vdb", "fuel"), output_source(2, "b.vdb", "fuel")}, "o/"),
            (Lines{"o/a.glb: 0.5", "o/b.glb: 0.5"}));
}

TEST_F(OutputNames, RefusesTwoWritersOfFile) {
  const std::vector<OutputSource> two{output_source(1, "a\x1b.vdb"), output_source(2, "b.vdb", "fuel")};
  EXPECT_EQ(named(two, "m.glb"),
            Lines{"m.glb: frame 1 (a\\x1b.vdb) and frame 2 (b.vdb, grid fuel) would both write this file"});
  EXPECT_EQ(named(two, "-", MeshFormat::ply),
            Lines{"standard output: frame 1 (a\\x1b.vdb) and frame 2 (b.vdb, grid fuel) would both write this file"});
  const auto refused = name_outputs(two, "m.glb", MeshFormat::glb);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(test::has_step(refused.error().hint, Remedy::use, Setting::animation));
  // Two names that safe_file_name() makes equal.
  EXPECT_EQ(named({output_source(1, "a.vdb", "x/y"), output_source(1, "a.vdb", "x:y")}, "{grid}.glb"),
            Lines{"x_y.glb: frame 1 (a.vdb, grid x/y) and frame 1 (a.vdb, grid x:y) would both write this file"});
}

TEST_F(OutputNames, ChecksBinFileOfGltf) {
  EXPECT_EQ(named({output_source(1, "a.vdb", "", {0.1, 0.2})}, "m_{iso}", MeshFormat::gltf),
            Lines{"m_0.bin: two outputs of frame 1 (a.vdb) would share this file"});
  EXPECT_EQ(named({output_source(1, "a.vdb", "", {0.1, 0.2})}, "m_{iso}.gltf", MeshFormat::gltf),
            (Lines{"m_0.1.gltf: 0.1", "m_0.2.gltf: 0.2"}));
  EXPECT_EQ(named({output_source(1, "a.vdb")}, "m.bin", MeshFormat::gltf),
            Lines{"m.bin: a gltf file has its data in a .bin file beside it, which would overwrite this one"});
  const auto refused = name_outputs(std::vector{output_source(1, "a.vdb")}, "m.bin", MeshFormat::gltf);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(test::has_step(refused.error().hint, Remedy::change, Setting::output_name));
  test::write_bytes("m.bin", "");
  EXPECT_EQ(named({output_source(1, "m.bin")}, "m.gltf", MeshFormat::gltf).front().substr(0, 7), "m.bin: ");
}

// Checks two outputs with these paths; returns "fine" or the error message.
std::string output_verdict(const std::string& one, const std::string& other, const std::string& input = "in.vdb") {
  const std::vector<OutputSource> sources{output_source(1, input), output_source(2, "other.vdb")};
  const std::vector<OutputFiles> outputs{{{one, {0.5}}}, {{other, {0.5}}}};
  const auto checked = check_outputs(sources, outputs, MeshFormat::glb);
  return checked ? "fine" : checked.error().message;
}

TEST_F(OutputNames, ComparesFilesNotTexts) {
  fs::create_directories("real/sub");
  fs::create_directory_symlink("real", "link");
  const std::string absolute = (fs::current_path() / "m.glb").string();
  EXPECT_EQ(output_verdict("m.glb", "n.glb"), "fine");
  for (const auto& [one, other] :
       std::vector<std::pair<std::string, std::string>>{{"m.glb", "./m.glb"},
                                                        {"m.glb", absolute},
                                                        {"real/m.glb", "link/m.glb"},
                                                        {"real/m.glb", "real//sub/../m.glb"},
                                                        {"real/m.glb", "link/sub/../m.glb"},
                                                        {"no/m.glb", "no/./no/../m.glb"},
                                                        {"link/no/m.glb", "real/no/m.glb"}}) {
    EXPECT_NE(output_verdict(one, other).find("would both write this file"), std::string::npos) << one << " " << other;
  }
  EXPECT_EQ(output_verdict("real/m.glb", "m.glb"), "fine");
  test::write_bytes("m.glb", "");
  fs::create_symlink("m.glb", "l.glb");
  EXPECT_NE(output_verdict("m.glb", "l.glb"), "fine");
}

TEST_F(OutputNames, RefusesToOverwriteInputs) {
  fs::create_directory("d");
  test::write_bytes("d/in.vdb", "");
  fs::create_symlink("d/in.vdb", "l.glb");
  EXPECT_EQ(output_verdict("m.glb", "d/./in.vdb", "d/in.vdb"),
            "d/./in.vdb: frame 2 (other.vdb) needs another output name: this is the input of frame 1 (d/in.vdb); it "
            "is not overwritten");
  EXPECT_NE(output_verdict("l.glb", "m.glb", "d/in.vdb"), "fine");
  EXPECT_NE(output_verdict("other.vdb", "m.glb"), "fine");  // the input does not exist yet, but the run reads it
  EXPECT_EQ(output_verdict("demo:sphere", "m.glb", "demo:sphere"), "fine");
  EXPECT_EQ(output_verdict("-", "m.glb", "-"), "fine");
}

TEST_F(OutputNames, RequiresChosenGrid) {
  EXPECT_EQ(named({output_source(1, "a.vdb")}, "{grid}.glb"),
            Lines{"frame 1 (a.vdb): expected the name of a grid for {grid} in the output name, found none"});
  EXPECT_EQ(named({output_source(1, "a.vdb", "../x")}, "o/{grid}/m.glb"), Lines{"o/___x/m.glb: 0.5"});
  EXPECT_EQ(named({output_source(1, "a.vdb")}, ""), Lines{"expected the name of an output, found an empty one"});
}

TEST_F(OutputNames, ChecksManyNamesQuickly) {
  std::vector<OutputSource> sources;
  for (int i = 0; i < 50000; ++i) sources.push_back(output_source(i, fmt::format("in/f_{}.vdb", i), "", {0.1, 0.2}));
  const auto names = name_outputs(sources, "out/{stem}_{iso}.gltf", MeshFormat::gltf);
  ASSERT_TRUE(names) << names.error().message;
  EXPECT_EQ(names->back().back().path, "out/f_49999_0.2.gltf");
}

}  // namespace
}  // namespace isoextract::batch
