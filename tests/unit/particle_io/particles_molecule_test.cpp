// Tests files of molecular dynamics with fixed columns: GROMACS and Protein Data Bank.
#include "unit/particle_io/particle_files.hpp"

namespace isoextract::test {
namespace {

particle_io::ParticleReadOptions all_of_frame(std::int64_t frame) {
  particle_io::ParticleReadOptions options = with_all();
  options.frame = frame;
  return options;
}

TEST(ParticlesGromacs, ReadsFramesOfAnyPrecision) {
  const ParticleInput input{"a.gro", std::string(kGromacs)};
  const particle_io::ParticleInfo info = must_inform(input);
  EXPECT_EQ(info.frames, 2U);
  EXPECT_EQ(info.particles, 3U);
  EXPECT_EQ(info.frame_name, "time 0.5");
  EXPECT_EQ(info.length_unit, "nm");
  EXPECT_EQ(quantities_of(info), (std::vector<std::string>{"resid:1 number", "(residue:1 text)", "(name:1 text)",
                                                           "id:1 number", "v:3 number"}));
  const particle_io::ParticleFile first = must_read_particles(input, all_of_frame(0));
  expect_positions(first.particles, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9.5}});
  expect_attribute(first.particles, "v", 3, {-1, 0, 1, -2, 0, 2, 0.25F, 0, 0});
  expect_attribute(first.particles, "resid", 1, {1, 1, 2});
  expect_positions(must_read_particles(input, of_frame(1)).particles, {{7, 8, 9.5}});
  expect_in(particle_refusal(input).message, "2 frames");
  expect_in(particle_refusal(input, of_frame(2)).message, "there is no frame 2");
  EXPECT_EQ(must_inform(input, of_frame(1)).frame_name, "time 1.5");
}

// Numbers that fill their columns touch each other.
TEST(ParticlesGromacs, SplitsByColumns) {
  const ParticleInput input{
      "a.gro",
      "t\n2\n12345SOL     OW99999-100.000-200.000-300.000\n    1SOL     OW    1 100.000 200.000 300.000\n"
      "1 1 1\n\n"};
  expect_positions(must_read_particles(input).particles, {{-100, -200, -300}, {100, 200, 300}});
  EXPECT_EQ(must_inform(input).frames, 1U);
}

TEST(ParticlesGromacs, RejectsDamage) {
  const std::string row = "    1SOL     OW    1   1.000   2.000   3.000\n";
  expect_in(particle_refusal({"a.gro", "t\nmany\n" + row}).message, "line 2: expected the number of atoms");
  expect_in(particle_refusal({"a.gro", "t\n1\n    1SOL     OW    1\n1 1 1\n"}).message,
            "line 3: expected x, y and z with decimal points");
  expect_in(particle_refusal({"a.gro", "t\n1\n" + row}).message, "expected the box after the atoms");
  expect_in(
      particle_refusal({"a.gro", "t\n2\n" + row + "    1SOL     OW    1   1.000   2.x00   3.000\n1 1 1\n"}).message,
      "line 4: expected a number as 'position:1', found '2.x00'");
  expect_in(particle_refusal({"a.gro", "t\n4000000000\n" + row + "1 1 1\n"}).message, "4000000000");
}

TEST(ParticlesProteinDataBank, ReadsModels) {
  const ParticleInput input{"a.pdb", std::string(kProteinDataBank)};
  const particle_io::ParticleInfo info = must_inform(input);
  EXPECT_EQ(info.frames, 2U);
  EXPECT_EQ(info.particles, 3U);
  EXPECT_EQ(info.frame_name, "model 1");
  EXPECT_EQ(info.length_unit, "angstrom");
  EXPECT_EQ(quantities_of(info), (std::vector<std::string>{"id:1 number", "(name:1 text)", "(residue:1 text)",
                                                           "(chain:1 text)", "resid:1 number", "occupancy:1 number",
                                                           "temperature:1 number", "(element:1 text)"}));
  const particle_io::ParticleFile first = must_read_particles(input, all_of_frame(0));
  expect_positions(first.particles, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9.5}});
  expect_attribute(first.particles, "resid", 1, {1, 2, -3});
  const points::ParticleAttribute& id = attribute_named(first.particles, "id");
  EXPECT_EQ(id.values[1], 2.0F);
  EXPECT_TRUE(std::isnan(id.values[2])) << "stars: more atoms than the columns can count";
  EXPECT_TRUE(std::isnan(attribute_named(first.particles, "occupancy").values[2])) << "the line ends before";
  expect_positions(must_read_particles(input, of_frame(1)).particles, {{7, 8, 9.5}});
  EXPECT_EQ(must_inform(input, of_frame(1)).frame_name, "model 2");
  expect_in(particle_refusal(input, of_frame(2)).message, "there is no frame 2");
}

TEST(ParticlesProteinDataBank, ReadsFilesWithoutModels) {
  const std::string row = "ATOM      1  N   ALA A   1       1.000   2.000   3.000  1.00 20.50           N  \n";
  expect_positions(must_read_particles({"a.pdb", row + row}).particles, {{1, 2, 3}, {1, 2, 3}});
  expect_positions(must_read_particles({"a.ent", row + "END\n"}).particles, {{1, 2, 3}});
  EXPECT_EQ(must_inform({"a.pdb", row + "END\n" + row + row + "END\n"}).frames, 2U) << "concatenated files";
  expect_positions(must_read_particles({"a.pdb.gz", gzip(row + "END\n")}).particles, {{1, 2, 3}});
}

TEST(ParticlesProteinDataBank, RejectsDamage) {
  expect_in(particle_refusal({"a.pdb", "HEADER    NOTHING\nEND\n"}).message,
            "expected lines that start with ATOM or HETATM");
  expect_in(particle_refusal({"a.pdb", "ATOM      1  N   ALA A   1       1.000   2.000\n"}).message,
            "line 1: expected x, y and z of an atom in the columns 31 to 54");
  expect_in(particle_refusal({"a.pdb", "ATOM      1  N   ALA A   1       1.000   2.x00   3.000\n"}).message,
            "line 1: expected a number as 'position:1'");
}

}  // namespace
}  // namespace isoextract::test
