// Tests tables, XYZ and LAMMPS dumps, valid and invalid.
#include <chrono>
#include <cmath>
#include <thread>

#include "support/hints.hpp"
#include "unit/particle_io/particle_files.hpp"

namespace isoextract::test {
namespace {

using Positions = std::vector<glm::dvec3>;
const Positions kThree{{1, 2, 3}, {4, 5, 6}, {7, 8, 9.5}};

TEST(ParticlesCsv, ReadsNamesDelimitersAndLineEnds) {
  for (const char* text :
       {"x,y,z\n1,2,3\n4,5,6\n7,8,9.5\n", "x,y,z\r\n1,2,3\r\n4,5,6\r\n7,8,9.5\r\n", "x,y,z\r1,2,3\r4,5,6\r7,8,9.5",
        "\xEF\xBB\xBFX;Y;Z\n1;2;3\n4;5;6\n7;8;9.5", "x\ty\tz\n1\t2\t3\n4\t5\t6\n7\t8\t9.5\n",
        "  x y   z\n 1 2 3 \n4 +5 6\n7 8 0.95e1\n", "x|y|z\n1|2|3\n4|5|6\n7|8|9.5\n",
        "\"x\",\"y\",\"z\"\n\"1\", 2 ,3\n4,5,\"6\"\n7,8,9.5\n",
        "# by hand\n\nx,y,z\n# more\n1,2,3,\n4,5,6,\n\n7,8,9.5,\n", "# x,y,z\n1,2,3\n4,5,6\n7,8,9.5\n",
        "z,id,y,x\n3,0,2,1\n6,0,5,4\n9.5,0,8,7\n", "Points:0,Points:1,Points:2\n1,2,3\n4,5,6\n7,8,9.5\n",
        "id,Position_X,Position_Y,Position_Z\n0,1,2,3\n0,4,5,6\n0,7,8,9.5\n"}) {
    SCOPED_TRACE(text);
    const particle_io::ParticleFile file = must_read_particles({"a.csv", text});
    expect_positions(file.particles, kThree);
    EXPECT_EQ(file.format, "csv");
    EXPECT_TRUE(file.notes.empty());
    EXPECT_TRUE(file.particles.attributes.empty());
  }
}

TEST(ParticlesCsv, ReadsUnitsAttributesAndText) {
  const ParticleInput input{"a.csv",
                            "id,x [mm],y [mm],z [mm],Velocity:0 (m/s),Velocity:1 (m/s),name,vx,vy,vz,id\n"
                            "1,1,2,3,0.5,-1,\"a \"\"b\"\", c\",1,2,3,11\n2,4,5,6,,1e3,d,4,5,6,12\n"};
  const particle_io::ParticleInfo info = must_inform(input);
  EXPECT_EQ(info.particles, 2U);
  EXPECT_EQ(info.length_unit, "mm");
  EXPECT_EQ(quantities_of(info), (std::vector<std::string>{"id:1 number", "Velocity:2 number in m/s", "(name:1 text)",
                                                           "v:3 number", "id[1]:1 number"}));
  const particle_io::ParticleFile all = must_read_particles(input, with_all());
  EXPECT_EQ(all.length_unit, "mm");
  ASSERT_EQ(all.particles.attributes.size(), 4U);
  expect_attribute(all.particles, "v", 3, {1, 2, 3, 4, 5, 6});
  expect_attribute(all.particles, "id[1]", 1, {11, 12});
  EXPECT_TRUE(std::isnan(attribute_named(all.particles, "Velocity").values[2]));  // the field is empty
  EXPECT_TRUE(all.notes.empty());
  ASSERT_EQ(all.particles.words.size(), 1U);
  EXPECT_EQ(all.particles.words.front().name, "name");
  expect_attribute(must_read_particles(input, with_attributes({"vy"})).particles, "vy", 1, {2, 5});
  expect_in(particle_refusal(input, with_attributes({"name"})).message, "expected numbers for 'name', found text");
  const Error missing = particle_refusal(input, with_attributes({"heat"}));
  expect_in(missing.message, "there is no attribute 'heat'");
  expect_in(test::text_of(missing.hint), "id, Velocity, v, id[1]");
}

// The form of Houdini's geometry spreadsheet.
TEST(ParticlesCsv, ReadsBracketedLettersAsComponents) {
  const ParticleInput input{
      "a.csv",
      "id,P[x],P[y],P[z],v[X],v[Y],v[Z],Cd[r],Cd[g],Cd[b],uv[0],uv[1],N [x] [m],N [y] [m],N [z] [m]\n"
      "0,1,2,3,0.5,-1,2,0.1,0.2,0.3,7,8,0,0,1\n1,4,5,6,4,5,6,0.4,0.5,0.6,9,10,0,1,0\n"};
  EXPECT_EQ(quantities_of(must_inform(input)),
            (std::vector<std::string>{"id:1 number", "v:3 number", "Cd:3 number", "uv:2 number", "N:3 number in m"}));
  const particle_io::ParticleFile all = must_read_particles(input, with_all());
  expect_positions(all.particles, {{1, 2, 3}, {4, 5, 6}});
  EXPECT_EQ(all.length_unit, "");
  expect_attribute(all.particles, "v", 3, {0.5F, -1, 2, 4, 5, 6});
  expect_attribute(all.particles, "Cd", 3, {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F});
  expect_attribute(must_read_particles(input, with_attributes({"v[Y]"})).particles, "v[Y]", 1, {-1, 5});
  particle_io::ParticleReadOptions options;
  options.columns = {"v[X]", "v[Y]", "p[z]"};
  expect_positions(must_read_particles(input, options).particles, {{0.5, -1, 3}, {4, 5, 6}});
}

// Headers of other exporters of Houdini's attributes.
TEST(ParticlesCsv, ReadsLettersAfterSeparatorsAsComponents) {
  for (const std::string mark : {".", ":", "_", "-", " "}) {
    std::string header = "P?x,P?y,P?z,Cd?r,Cd?g,Cd?b,Cd?a,v?x,v?y,v?z,bar,bag,bab\n";
    for (std::size_t at = header.find('?'); at != std::string::npos; at = header.find('?')) header.replace(at, 1, mark);
    const ParticleInput input{"a.csv", header + "1,2,3,0.1,0.2,0.3,1,4,5,6,7,8,9\n"};
    EXPECT_EQ(quantities_of(must_inform(input)),
              (std::vector<std::string>{"Cd:4 number", "v:3 number", "bar:1 number", "bag:1 number", "bab:1 number"}));
    expect_positions(must_read_particles(input).particles, {{1, 2, 3}});
  }
  // The error names the column of a position that has no numbers, not a missing column.
  const Error error = particle_refusal({"a.csv", "Px;Py;Pz;m\n1.000,5;2;3;4\n"});
  expect_in(error.message, "line 2: expected a number as 'Px', found '1.000,5'");
}

TEST(ParticlesCsv, ReadsBracketedTextAsUnits) {
  const ParticleInput input{"a.csv",
                            "x [mm],y [mm],z [mm],mass [g],age [a],v[x] [m/s],v[y] [m/s],v[z] [m/s],Cd[r],Cd[g],Cd[b],"
                            "Cd[a],T [K],load[b],px,py,pz\n1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17\n"};
  const particle_io::ParticleInfo info = must_inform(input);
  EXPECT_EQ(info.length_unit, "mm");
  EXPECT_EQ(quantities_of(info),
            (std::vector<std::string>{"mass:1 number in g", "age:1 number in a", "v:3 number in m/s", "Cd:4 number",
                                      "T:1 number in K", "load:1 number in b", "p:3 number"}));
}

// The vector p is a momentum, P a position.
TEST(ParticlesCsv, DistinguishesMomentaFromPositions) {
  expect_in(particle_refusal({"a.csv", "px,py,pz,t\n1,2,3,4\n"}).message, "expected columns x, y and z");
}

TEST(ParticlesCsv, SelectsColumnsByNameAndNumber) {
  const ParticleInput input{"a.csv", "a,b,c,d\n1,2,3,4\n5,6,7,8\n"};
  expect_in(particle_refusal(input).message, "expected columns x, y and z, found 4 columns: a, b, c, d");
  particle_io::ParticleReadOptions options;
  options.columns = {"d", "1", "B"};
  expect_positions(must_read_particles(input, options).particles, {{4, 1, 2}, {8, 5, 6}});
  options.columns = {"a", "b", "5"};
  expect_in(particle_refusal(input, options).message, "there is no column '5'");
}

TEST(ParticlesCsv, ReadsTablesWithoutNames) {
  const particle_io::ParticleFile three = must_read_particles({"a.csv", "1 2 3\n4 5 6\n7 8 9.5\n"});
  expect_positions(three.particles, kThree);
  ASSERT_EQ(three.notes.size(), 1U);
  expect_in(three.notes.front().text, "takes its three columns as x, y and z");
  expect_in(particle_refusal({"a.csv", "1 2 3 4\n4 5 6 7\n"}).message, "expected columns x, y and z, found 4");
  particle_io::ParticleReadOptions options;
  options.columns = {"2", "3", "4"};
  // A row with a number has values, not names.
  expect_positions(must_read_particles({"a.csv", "H,1,2,3\nO,4,5,6\nH,7,8,9.5\n"}, options).particles, kThree);
}

TEST(ParticlesCsv, ReadsAllFormsOfNumbers) {
  const auto read = must_read_particles({"a.csv", "x,y,z\nnan,-inf,1e400\n1e-400,-1e-5000,123456789.123456789\n"});
  EXPECT_TRUE(std::isnan(read.particles.positions[0].x));
  EXPECT_EQ(read.particles.positions[0].y, -HUGE_VAL);
  EXPECT_EQ(read.particles.positions[0].z, HUGE_VAL);
  EXPECT_EQ(read.particles.positions[1].x, 0);
  EXPECT_EQ(read.particles.positions[1].z, 123456789.123456789);
}

TEST(ParticlesCsv, RejectsInvalidTables) {
  const struct {
    std::string text;
    const char* message;
  } bad[]{{"x,y,z\n1,2,3\n4,5\n", "line 3: expected 3 fields (not 2), found '4,5'"},
          {"x,y,z\n1,2,3\n4,5,6,7\n", "line 3: expected 3 fields (not 4)"},
          {"x,y,z\n1,2,3\n4,a5,6\n", "line 3: expected a number as 'y', found 'a5'"},
          {"x;y;z\n1,5;2.5;3\n",
           "line 2: expected a number as 'y', with the same decimal mark as the numbers before, found '2.5'"},
          {"x,y,z\n1,2,3\n4,\"5,6\n", "line 3: expected fields with closing quotes"},
          {"x,y,z\n1,2,3\n4,\"5\"6,7\n", "line 3: expected fields with closing quotes"},
          {"x,y\n1,2\n", "line 1: expected three or more columns"},
          {"hello\n", "line 1: expected three or more columns"},
          {"\n\n# nothing\n", "expected a table, found no rows"},
          {std::string("x,y,z\n1,\0"
                       "2,3\n",
                       12),
           "found '\\x002'"},
          {"x,y,z\n" + std::string(3 << 20, '1'), "expected the end of a line within 1048576 bytes"},
          {"x" + std::string(5000, ',') + "y\n", "expected at most 4096 columns"}};
  for (const auto& [text, message] : bad) {
    SCOPED_TRACE(text.substr(0, 40));
    const Error error = particle_refusal({"a.csv", text});
    EXPECT_EQ(error.code, ErrorCode::input);
    expect_in(error.message, message);
  }
}

TEST(ParticlesCsv, ReadsGzipAndManyLines) {
  std::string text = "x,y,z\n";
  for (int i = 0; i < 60000; ++i) text += fmt::format("{},{},{}\n", i, 2 * i, 0.125 * i);
  for (const ParticleInput& input : {ParticleInput{"a.csv", text}, ParticleInput{"a.csv.gz", gzip(text)}}) {
    const particle_io::ParticleFile file = must_read_particles(input);
    ASSERT_EQ(file.particles.size(), 60000U);
    for (int i = 0; i < 60000; ++i) {
      ASSERT_EQ(file.particles.positions[static_cast<std::size_t>(i)], glm::dvec3(i, 2.0 * i, 0.125 * i));
    }
  }
}

TEST(ParticlesXyz, ReadsPlainFrames) {
  const ParticleInput input{"a.xyz", "3\nwater\nO 1 2 3 0.5\nH 4 5 6 1\nH 7 8 9.5 2\n2\n\n8 1 2 3 4\n8 4 5 6 5\n\n"};
  const Error error = particle_refusal(input);
  expect_in(error.message, "there are 2 frames in the file, from 0 to 1");
  const particle_io::ParticleInfo info = must_inform(input);
  EXPECT_EQ(info.frames, 2U);
  EXPECT_EQ(info.particles, 3U);
  EXPECT_EQ(quantities_of(info), (std::vector<std::string>{"(species:1 text)", "column 5:1 number"}));
  particle_io::ParticleReadOptions first = with_attributes({"column 5"});
  first.frame = 0;
  const particle_io::ParticleFile zero = must_read_particles(input, first);
  expect_positions(zero.particles, kThree);
  expect_attribute(zero.particles, "column 5", 1, {0.5F, 1, 2});
  expect_in(zero.particles.label, "frame 0");
  first = with_all();
  first.frame = 1;
  const particle_io::ParticleFile one = must_read_particles(input, first);
  expect_positions(one.particles, {{1, 2, 3}, {4, 5, 6}});
  expect_attribute(one.particles, "species", 1, {8, 8});
  expect_in(particle_refusal(input, of_frame(2)).message, "there is no frame 2");
  expect_in(particle_refusal(input, of_frame(-1)).message, "there is no frame -1");
  expect_positions(must_read_particles({"a.xyz", "1\n\n1 2 3"}).particles, {{1, 2, 3}});
}

TEST(ParticlesXyz, ReadsExtendedFrames) {
  const ParticleInput input{"a.dat", std::string(kExtendedXyz)};
  const particle_io::ParticleInfo info = must_inform(input);
  EXPECT_EQ(info.format, "xyz");
  EXPECT_EQ(info.frames, 2U);
  EXPECT_EQ(info.frame_name, "time 0.5");
  EXPECT_EQ(quantities_of(info), (std::vector<std::string>{"(species:1 text)", "forces:3 number", "tag:1 number",
                                                           "(fixed:1 true or false)"}));
  particle_io::ParticleReadOptions options = with_attributes({"forces", "tag"});
  options.frame = 0;
  const particle_io::ParticleFile zero = must_read_particles(input, options);
  expect_positions(zero.particles, {{1, 2, 3}, {4, 5, 6}});
  expect_attribute(zero.particles, "forces", 3, {-1, 0, 1, -2, 0, 2});
  expect_attribute(zero.particles, "tag", 1, {7, 8});
  expect_positions(must_read_particles(input, of_frame(1)).particles, {{7, 8, 9.5}});
  expect_positions(must_read_particles({"a.xyz", "1\nProperties=\"pos:R:3\"\n1 2 3\n"}).particles, {{1, 2, 3}});
}

TEST(ParticlesXyz, RejectsInvalidFrames) {
  const struct {
    const char* text;
    const char* message;
  } bad[]{{"hello\n", "line 1: expected the number of atoms alone in a line, found 'hello'"},
          {"-1\n\n", "expected the number of atoms"},
          {"1.5 2 3\n", "expected the number of atoms"},
          {"2\n\nH 1.000 2.000 3.000\n", "expected 2 lines of particles, found 1"},
          {"4000000000\n\nH 1 2 3\n",
           "4000000000 particles or entries need at least 28000000000 bytes; the file has at most 8 after byte"},
          {"18446744073709551615\n\nH 1 2 3\n", "18446744073709551615 particles or entries need at least 2^64 bytes"},
          {"99999999999999999999\n\nH 1 2 3\n", "expected the number of atoms"},
          {"1\n\nH 1 2\n", "line 3: expected a number as 'x', found 'H'"},
          {"1\n\nH 1\n", "line 3: expected x, y and z, with or without the name of an element"},
          {"2\n\nH 1 2 3\nH 1 2 3 4\n", "line 4: expected 4 values of a particle (not 5)"},
          {"1\nProperties=pos:R:0\n1 2 3\n", "a number of columns in Properties"},
          {"1\nProperties=pos:Q:3\n1 2 3\n", "expected R, I, S or L"},
          {"1\nProperties=pos:R:99999999999\n1 2 3\n", "a number of columns in Properties"},
          {"1\nProperties=pos:R\n1 2 3\n", "in Properties"},
          {"1\nProperties=force:R:3\n1 2 3\n", "expected columns x, y and z"},
          {"1", "expected a comment"}};
  for (const auto& [text, message] : bad) {
    SCOPED_TRACE(text);
    expect_in(particle_refusal({"a.xyz", text}).message, message);
  }
}

TEST(ParticlesLammps, ReadsScaledAndUnscaledTimeSteps) {
  const ParticleInput input{"any.name", std::string(kLammpsDump)};
  const particle_io::ParticleInfo info = must_inform(input);
  EXPECT_EQ(info.format, "lammps");
  EXPECT_EQ(info.frames, 2U);
  EXPECT_EQ(info.frame_name, "time step 0");
  EXPECT_EQ(info.length_unit, "angstrom");
  EXPECT_EQ(quantities_of(info),
            (std::vector<std::string>{"id:1 number", "type:1 number", "v:3 number", "(element:1 text)"}));
  particle_io::ParticleReadOptions options = with_attributes({"v"});
  options.frame = 0;
  const particle_io::ParticleFile zero = must_read_particles(input, options);
  expect_positions(zero.particles, {{1, 2, 3}, {4, 5, 6}});
  expect_attribute(zero.particles, "v", 3, {-1, 0, 1, -2, 0, 2});
  EXPECT_EQ(must_inform(input, of_frame(1)).frame_name, "time step 100");
  const particle_io::ParticleFile one = must_read_particles(input, of_frame(1));
  // lo + s * (hi - lo), by hand.
  expect_positions(one.particles, {{4, 5, 10}, {-1, 0, 0}, {14, -10, 1.25}});
  expect_in(one.particles.label, "time step 100");
  EXPECT_EQ(one.length_unit, "angstrom");
  expect_in(particle_refusal(input).message, "there are 2 frames in the file");
  expect_in(particle_refusal(input, of_frame(5)).message, "there is no frame 5");
}

TEST(ParticlesLammps, ReadsTriclinicBoxes) {
  // lx = 4, ly = 5, lz = 6, xy = -1, xz = -2, yz = 0.5 from (10, 20, 30). LAMMPS writes the bounds xlo + min(0, xy, xz,
  // xy + xz) .. xhi + max(...), ylo + min(0, yz) .. yhi + max(0, yz).
  const std::string head = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n1\n";
  const std::string box = "ITEM: BOX BOUNDS xy xz yz pp pp pp\n7 14 -1\n20 25.5 -2\n30 36 0.5\n";
  expect_positions(must_read_particles({"a.dump", head + box + "ITEM: ATOMS xs ys zs\n0.5 0.25 0.75\n"}).particles,
                   {{10 + 0.5 * 4 + 0.25 * -1 + 0.75 * -2, 20 + 0.25 * 5 + 0.75 * 0.5, 30 + 0.75 * 6}});
  expect_positions(must_read_particles({"a.dump", head + box + "ITEM: ATOMS xsu ysu zsu\n1 1 1\n"}).particles,
                   {{10 + 4 - 1 - 2, 20 + 5.5, 36}});
  const std::string general = "ITEM: BOX BOUNDS abc origin pp pp pp\n4 0 0 10\n-1 5 0 20\n-2 0.5 6 30\n";
  expect_positions(must_read_particles({"a.dump", head + general + "ITEM: ATOMS xs ys zs\n0.5 0.25 0.75\n"}).particles,
                   {{10 + 0.5 * 4 + 0.25 * -1 + 0.75 * -2, 20 + 0.25 * 5 + 0.75 * 0.5, 30 + 0.75 * 6}});
  expect_positions(must_read_particles({"a.dump", head + box + "ITEM: ATOMS xu yu zu id\n-1 200 3 1\n"}).particles,
                   {{-1, 200, 3}});
  // Unscaled coordinates take precedence over fractions.
  expect_positions(must_read_particles({"a.dump", head + box + "ITEM: ATOMS xs ys zs x y z\n0 0 0 1 2 3\n"}).particles,
                   {{1, 2, 3}});
}

TEST(ParticlesLammps, ReadsTheBoxOfTheSimulation) {
  const std::string head = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n1\n";
  const std::string atoms = "ITEM: ATOMS x y z vx\n1 2 3 4\n";
  const auto box_of = [&](const std::string& box, std::optional<std::array<std::string, 3>> columns = std::nullopt) {
    particle_io::ParticleReadOptions options;
    options.columns = std::move(columns);
    return must_read_particles({"a.dump", head + box + atoms}, options).particles.box;
  };
  const std::string tilted = "ITEM: BOX BOUNDS xy xz yz pp ff pp\n7 14 -1\n20 25.5 -2\n30 36 0.5\n";
  const std::string general = "ITEM: BOX BOUNDS abc origin pp pm sf\n4 0 0 10\n-1 5 0 20\n-2 0.5 6 30\n";
  const glm::dmat3 edges(4, 0, 0, -1, 5, 0, -2, 0.5, 6);
  EXPECT_EQ(box_of(tilted), (points::SimulationBox{{10, 20, 30}, edges, {true, false, true}}));
  EXPECT_EQ(box_of(general), (points::SimulationBox{{10, 20, 30}, edges, {true, false, false}}));
  const std::string upright = "ITEM: BOX BOUNDS pp pp pp\n2 6\n10 14\n-3 1\n";
  const points::SimulationBox cube{{2, 10, -3}, glm::dmat3(4), {true, true, true}};
  EXPECT_EQ(box_of(upright), cube);
  EXPECT_EQ(box_of(upright, {{"x", "y", "z"}}), cube);
  EXPECT_EQ(box_of(upright, {{"x", "z", "y"}}), std::nullopt);
  EXPECT_EQ(box_of(upright, {{"x", "y", "vx"}}), std::nullopt);
  particle_io::ParticleReadOptions turned;
  turned.columns = {"x", "z", "y"};
  const auto notes_of = [&](const std::string& box) {
    return must_read_particles({"a.dump", head + box + atoms}, turned).notes;
  };
  ASSERT_EQ(notes_of(upright).size(), 1U);
  expect_in(notes_of(upright)[0].text, "the chosen columns are not its x, y and z in this order");
  EXPECT_TRUE(notes_of("ITEM: BOX BOUNDS ff ff ff\n2 6\n10 14\n-3 1\n").empty()) << "such a box has no effect";
  // Old dumps do not say whether the box is periodic.
  EXPECT_EQ(box_of("ITEM: BOX BOUNDS\n2 6\n10 14\n-3 1\n")->periodic, (std::array{false, false, false}));
  for (const char* none : {"2 6\n10 14\n-3 -3\n", "2 6\n10 nan\n-3 1\n", "2 6\n10 1e999\n-3 1\n"}) {
    EXPECT_EQ(box_of(std::string("ITEM: BOX BOUNDS pp pp pp\n") + none), std::nullopt) << none;
  }
}

TEST(ParticlesLammps, ScalesSelectedColumns) {
  const std::string head = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n1\n";
  const std::string upright = head + "ITEM: BOX BOUNDS pp pp pp\n2 6\n10 14\n-3 1\n";
  const std::string tilted = head + "ITEM: BOX BOUNDS xy xz yz pp pp pp\n7 14 -1\n20 25.5 -2\n30 36 0.5\n";
  const auto place = [](const std::string& text, const std::array<std::string, 3>& columns) {
    particle_io::ParticleReadOptions options;
    options.columns = columns;
    const particle_io::ParticleFile file = must_read_particles({"a.dump", text}, options);
    return file.particles.positions[0];
  };
  const std::string scaled = "ITEM: ATOMS id xs ys zs\n1 0.25 0.5 0.75\n";
  EXPECT_EQ(place(upright + scaled, {"zs", "xs", "ys"}), glm::dvec3(0, 3, 12));
  EXPECT_EQ(place(upright + scaled, {"4", "xs", "3"}), glm::dvec3(0, 3, 12));
  EXPECT_EQ(place(upright + scaled, {"xs", "xs", "id"}), glm::dvec3(3, 3, 1));
  EXPECT_EQ(place(upright + "ITEM: ATOMS xs y zs\n0.25 11 0.75\n", {"xs", "y", "zs"}), glm::dvec3(3, 11, 0));
  EXPECT_EQ(place(upright + "ITEM: ATOMS x y z xsu ysu zsu\n1 2 3 2 0.5 0.75\n", {"xsu", "ysu", "zsu"}),
            glm::dvec3(10, 12, 0));
  const glm::dvec3 whole = place(tilted + scaled, {"xs", "ys", "zs"});
  EXPECT_EQ(place(tilted + scaled, {"zs", "xs", "ys"}), glm::dvec3(whole.z, whole.x, whole.y));
  particle_io::ParticleReadOptions mixed;
  mixed.columns = {"xs", "ys", "id"};
  expect_in(particle_refusal({"a.dump", tilted + scaled}, mixed).message,
            "expected fractions of all three edges of the triclinic box as x, y and z, found xs ys id");
}

TEST(ParticlesLammps, RejectsInvalidDumps) {
  const std::string head = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n";
  const struct {
    std::string text;
    const char* message;
  } bad[]{{head + "two\n", "line 4: expected the number of atoms, found 'two'"},
          {head + "-2\n", "expected the number of atoms, found '-2'"},
          {head + "1\nITEM: ATOMS x y\n1 2\n", "expected columns x, y and z, found 2 columns: x, y"},
          {head + "1\nITEM: ATOMS xs ys zs\n1 2 3\n", "expected 'ITEM: BOX BOUNDS'"},
          {head + "1\nITEM: ATOMS\n", "expected the names of columns"},
          {head + "2\nITEM: ATOMS x y z\n1.00 2.00 3.00\n", "found 1 before the end of the file"},
          {head + "4294967296\nITEM: ATOMS x y z\n1 2 3\n",
           "4294967296 particles or entries need at least 21474836480 bytes"},
          {head + "1\nITEM: BOX BOUNDS pp pp pp\n0 a\n", "expected a number among the bounds of the box, found 'a'"},
          {"ITEM: TIMESTEP\n7\nITEM: ATOMS x y z\n1 2 3\n", "expected 'ITEM: NUMBER OF ATOMS'"},
          {"ITEM: TIMESTEP\n", "expected a time step, found the end of the file"},
          {head + "1\nITEM: ATOMS x y z\n1 2 3\n4 5 6\n", "expected a line 'ITEM: ...'"}};
  for (const auto& [text, message] : bad) {
    SCOPED_TRACE(text);
    expect_in(particle_refusal({"a.dump", text}).message, message);
  }
}

// Returns the bytes read to read all frames of a file, one call per frame.
std::uint64_t bytes_for_all_frames(const std::string& name, const std::vector<std::string>& frames) {
  const TempFolder folder;
  std::string text;
  for (const std::string& frame : frames) text += frame;
  write_bytes(folder / name, text);
  // Waits until a later write gives another time; the clock's ticks are coarse.
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  std::uint64_t bytes = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Context context;
    const auto read = particle_io::read_particles(folder / name, of_frame(static_cast<std::int64_t>(k)), context);
    if (!read) throw std::runtime_error(read.error().message);
    EXPECT_EQ(read->particles.positions[1].x, static_cast<double>(k)) << name;
    EXPECT_EQ(read->length_unit, name.ends_with("xyz") ? "" : "angstrom");
    bytes += context.counters().bytes_read;
  }
  const auto beyond =
      particle_io::read_particles(folder / name, of_frame(static_cast<std::int64_t>(frames.size())), Context());
  if (beyond) throw std::runtime_error("read beyond the last frame");
  expect_in(test::text_of(beyond.error().hint), fmt::format("there are {} frames in the file", frames.size()));
  return bytes;
}

TEST(ParticlesText, ReadsAllFramesInLinearTime) {
  const auto frames_of = [](bool lammps, int count) {
    std::vector<std::string> frames;
    for (int k = 0; k < count; ++k) {
      std::string frame = lammps ? fmt::format("{}ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n60\nITEM: ATOMS x y z\n",
                                               k == 0 ? "ITEM: UNITS\nmetal\n" : "", k)
                                 : "60\nframe\n";
      for (int a = 0; a < 60; ++a) frame += fmt::format("{} {} {}\n", k, a, 0.25 * a);
      frames.push_back(frame);
    }
    return frames;
  };
  for (const bool lammps : {false, true}) {
    const std::string name = lammps ? "a.lammpstrj" : "a.xyz";
    const std::uint64_t once = bytes_for_all_frames(name, frames_of(lammps, 200));
    const std::uint64_t twice = bytes_for_all_frames(name, frames_of(lammps, 400));
    EXPECT_LT(twice, 5 * once / 2) << name << ": " << once << ", " << twice;
  }
}

TEST(ParticlesText, ForgetsFramesOfAChangedFile) {
  const TempFolder folder;
  const std::string path = folder / "a.xyz";
  const auto write = [&](const std::string& text) {
    write_bytes(path, text);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  };
  const auto x_of = [&](std::int64_t frame) {
    const auto read = particle_io::read_particles(path, of_frame(frame), Context());
    if (!read) throw std::runtime_error(read.error().message);
    return read->particles.positions[0].x;
  };
  write("1\na\n10 0 0\n1\nb\n20 0 0\n1\nc\n30 0 0\n");
  EXPECT_EQ(x_of(2), 30);
  EXPECT_EQ(x_of(1), 20);
  // The same size with frames of other lengths.
  write("1\naaa\n1 0 0\n1\n\n220 0 0\n1\nc\n3 0 0\n");
  EXPECT_EQ(x_of(1), 220);
  EXPECT_EQ(x_of(2), 3);
  EXPECT_EQ(x_of(0), 1);
}

}  // namespace
}  // namespace isoextract::test
