// Tests that reading returns what was written.
#include "particle_io/particle_writer.hpp"

#include <cstring>
#include <limits>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "base/hash.hpp"
#include "support/temp_folder.hpp"
#include "unit/particle_io/particle_files.hpp"

namespace isoextract::particle_io {
namespace {

using test::TempFolder;

double random_number(std::uint64_t n) { return static_cast<double>(splitmix64(n)) / 1e17 - 90; }

points::ParticleSet some_particles(std::size_t count) {
  points::ParticleSet set{.label = "some", .positions = Buffer<glm::dvec3>(count), .attributes = {}, .memory = {}};
  set.attributes.push_back({"velocity", 3, Buffer<float>(3 * count)});
  set.attributes.push_back({"age", 1, Buffer<float>(count)});
  set.attributes.push_back({"pair", 2, Buffer<float>(2 * count)});
  for (std::size_t i = 0; i < count; ++i) {
    set.positions[i] = glm::dvec3(random_number(3 * i), random_number(3 * i + 1), random_number(3 * i + 2));
  }
  std::uint64_t n = 3 * count;
  for (auto& attribute : set.attributes) {
    for (float& value : attribute.values) value = static_cast<float>(random_number(n++));
  }
  if (count > 0) {
    set.positions[0] = glm::dvec3(-2.2250738585072014e-308, 1e300, -0.0);
    set.attributes[0].values[0] = -1.17549435e-38F;
    set.attributes[1].values[0] = std::numeric_limits<float>::max();
  }
  return set;
}

std::string extension_of(ParticleFileFormat format) { return std::string(word_of(format)); }

class ParticleWriter : public testing::TestWithParam<ParticleFileFormat> {
 protected:
  [[nodiscard]] std::filesystem::path path() const { return folder_ / ("some." + extension_of(GetParam())); }

  TempFolder folder_;
};

TEST_P(ParticleWriter, RoundTrips) {
  for (const std::size_t count : {1U, 2U, 40000U}) {
    const points::ParticleSet set = some_particles(count);
    const auto bytes = write_particles(path(), set, GetParam());
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_EQ(*bytes, std::filesystem::file_size(path()));
    ParticleReadOptions options;
    options.all_attributes = true;
    const auto read = read_particles(path().string(), options, Context());
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->format, extension_of(GetParam()));
    ASSERT_EQ(read->particles.size(), count);
    EXPECT_EQ(std::memcmp(read->particles.positions.data(), set.positions.data(), set.positions.size_bytes()), 0);
    ASSERT_EQ(read->particles.attributes.size(), set.attributes.size());
    for (std::size_t k = 0; k < set.attributes.size(); ++k) {
      const auto& found = read->particles.attributes[k];
      EXPECT_EQ(found.name, set.attributes[k].name);
      EXPECT_EQ(found.components, set.attributes[k].components);
      ASSERT_EQ(found.values.size(), set.attributes[k].values.size());
      EXPECT_EQ(std::memcmp(found.values.data(), set.attributes[k].values.data(), found.values.size_bytes()), 0)
          << found.name;
    }
  }
}

TEST_P(ParticleWriter, WritesTheSameBytesForAnyNumberOfThreads) {
  const points::ParticleSet set = some_particles(60000);
  std::vector<std::string> files;
  for (const std::size_t threads : {1, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    ASSERT_TRUE(write_particles(path(), set, GetParam()));
    files.push_back(test::read_bytes(path()));
  }
  EXPECT_TRUE(files[0] == files[1]);
}

TEST_P(ParticleWriter, WritesEmptySets) {
  ASSERT_TRUE(write_particles(path(), some_particles(0), GetParam()));
  const std::string bytes = test::read_bytes(path());
  EXPECT_FALSE(bytes.empty());
  const bool is_ply = GetParam() == ParticleFileFormat::ply;
  EXPECT_EQ(bytes.find("element vertex 0\n") != std::string::npos, is_ply);
}

TEST_P(ParticleWriter, RejectsAmbiguousNames) {
  for (const char* name : {"", "two words", "x", "Position", "age", "AGE", "it's", "a:b",
                           "a_name_that_is_longer_than_all_that_are_real"}) {
    points::ParticleSet set = some_particles(3);
    set.attributes.push_back({name, 1, Buffer<float>(3)});
    const auto written = write_particles(path(), set, GetParam());
    ASSERT_FALSE(written) << name;
    EXPECT_EQ(written.error().code, ErrorCode::output);
    EXPECT_TRUE(folder_.names().empty());
  }
}

TEST_P(ParticleWriter, ReportsWriteErrors) {
  const auto written = write_particles(folder_ / "none/some.ply", some_particles(3), GetParam());
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::output);
  EXPECT_NE(written.error().message.find("none/some.ply"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Formats, ParticleWriter,
                         testing::Values(ParticleFileFormat::ply, ParticleFileFormat::npy, ParticleFileFormat::xyz,
                                         ParticleFileFormat::bgeo),
                         [](const auto& tested) { return extension_of(tested.param); });

// The vtk plug-in and VTK's own reader read them back in tests/cli/particle_files_test.py.
TEST(ParticleFileFormats, UnstructuredGridsAppendRawArrays) {
  const TempFolder folder;
  const points::ParticleSet set = some_particles(3);
  ASSERT_TRUE(write_particles(folder / "a.vtu", set, ParticleFileFormat::vtu));
  const std::string bytes = test::read_bytes(folder / "a.vtu");
  EXPECT_NE(bytes.find("<Piece NumberOfPoints=\"3\" NumberOfCells=\"3\">"), std::string::npos);
  EXPECT_NE(bytes.find("Name=\"velocity\" NumberOfComponents=\"3\" format=\"appended\" offset=\"155\""),
            std::string::npos);
  std::string expected = test::pack(std::uint64_t{72});
  for (const glm::dvec3& p : set.positions) expected += test::pack(p.x) + test::pack(p.y) + test::pack(p.z);
  expected += test::pack(std::uint64_t{24});
  for (const std::int64_t i : {0, 1, 2}) expected += test::pack(i);
  expected += test::pack(std::uint64_t{24});
  for (const std::int64_t i : {1, 2, 3}) expected += test::pack(i);
  expected += test::pack(std::uint64_t{3}) + "\1\1\1" + test::pack(std::uint64_t{36});
  const std::size_t start = bytes.find("\n_") + 2;
  EXPECT_EQ(bytes.substr(start, expected.size()), expected);
}

TEST(ParticleFileFormats, HoudiniGeometryKeepsKinds) {
  const TempFolder folder;
  points::ParticleSet set = some_particles(2000);  // more than a page
  set.attributes[0].kind = AttributeKind::vector;
  ASSERT_TRUE(write_particles(folder / "a.bgeo", set, ParticleFileFormat::bgeo));
  ParticleReadOptions options;
  options.all_attributes = true;
  const auto read = read_particles((folder / "a.bgeo").string(), options, Context());
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->particles.attributes[0].kind, AttributeKind::vector);
  EXPECT_EQ(read->particles.attributes[1].kind, std::nullopt);
  EXPECT_EQ(read->particles.positions[1999], set.positions[1999]);
}

points::ParticleSet particles_with_words(std::size_t count) {
  points::ParticleSet set = some_particles(count);
  points::ParticleWords species{"species", {"O", "Na+", "H"}, Buffer<std::uint32_t>(count)};
  for (std::size_t i = 0; i < count; ++i) species.indices[i] = static_cast<std::uint32_t>(i * i % 3);
  set.words.push_back(std::move(species));
  return set;
}

TEST(ParticleFileFormats, KeepWords) {
  const TempFolder folder;
  const points::ParticleSet set = particles_with_words(3000);
  for (const ParticleFileFormat format : {ParticleFileFormat::bgeo, ParticleFileFormat::xyz}) {
    EXPECT_TRUE(stores_words(format));
    const std::filesystem::path path = folder / ("a." + extension_of(format));
    ASSERT_TRUE(write_particles(path, set, format));
    ParticleReadOptions options;
    options.all_attributes = true;
    const auto read = read_particles(path.string(), options, Context());
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->particles.attributes.size(), 3U);
    EXPECT_EQ(std::memcmp(read->particles.positions.data(), set.positions.data(), set.positions.size_bytes()), 0);
    ASSERT_EQ(read->particles.words.size(), 1U);
    const points::ParticleWords& words = read->particles.words.front();
    EXPECT_EQ(words.name, "species");
    for (std::size_t i = 0; i < set.size(); ++i) {
      ASSERT_EQ(words.words[words.indices[i]], set.words[0].words[set.words[0].indices[i]]) << i;
    }
    // A condition reads them, too.
    ParticleReadOptions chosen;
    chosen.condition = {{{"element", "species"}, true, ""}};
    EXPECT_EQ(read_particles(path.string(), chosen, Context())->particles.words.size(), 1U);
  }
}

TEST(ParticleFileFormats, KeepTheBoxInXyz) {
  const TempFolder folder;
  points::ParticleSet set = some_particles(5);
  set.box = points::SimulationBox{{0.1, -2, 1e-30}, {3, 0, 0, 0.1, 4, 0, -1.0 / 3, 0.7, 5}, {true, false, true}};
  ASSERT_TRUE(write_particles(folder / "a.xyz", set, ParticleFileFormat::xyz));
  EXPECT_EQ(read_particles((folder / "a.xyz").string(), {}, Context())->particles.box, set.box);
}

TEST(ParticleFileFormats, FitParticlesToTheirNamesAndWords) {
  const TempFolder folder;
  points::ParticleSet set = particles_with_words(4);
  set.words.push_back({"two words", {"a b", "c"}, Buffer<std::uint32_t>(4)});
  set.words.push_back({"many", {}, {}, true});
  std::ranges::fill(set.words[1].indices, 1);
  for (const char* name : {"c_stress[1]", "P", "Age", "a_name_that_is_longer_than_all_that_are_real", "", "x"}) {
    set.attributes.push_back({name, 1, Buffer<float>(4)});
    std::ranges::fill(set.attributes.back().values, 7.0F);
  }
  const Notes notes = fit_to_file(set, ParticleFileFormat::xyz);
  std::vector<std::string> names;
  for (const auto& attribute : set.attributes) names.push_back(attribute.name);
  EXPECT_EQ(names, (std::vector<std::string>{"velocity", "age", "pair", "c_stress_1_", "P_2", "Age_2",
                                             "a_name_that_is_longer_than_all_that_", "attribute", "x_2"}));
  ASSERT_EQ(set.words.size(), 1U);
  EXPECT_EQ(notes.size(), 8U);
  EXPECT_EQ(std::ranges::count(notes, NoteId::data_left_out, &Note::id), 2);
  EXPECT_TRUE(write_particles(folder / "a.xyz", set, ParticleFileFormat::xyz));
  EXPECT_EQ(fit_to_file(set, ParticleFileFormat::xyz).size(), 0U);
  EXPECT_EQ(fit_to_file(set, ParticleFileFormat::vtu).size(), 1U);  // no words there
  EXPECT_TRUE(set.words.empty());
}

TEST(ParticleFileFormats, RejectDamagedIndicesOfWords) {
  const TempFolder folder;
  ASSERT_TRUE(write_particles(folder / "a.bgeo", particles_with_words(4), ParticleFileFormat::bgeo));
  const std::string bytes = test::read_bytes(folder / "a.bgeo");
  std::string indices;
  for (const std::int32_t index : {0, 1, 1, 0}) indices += test::pack(index);
  const std::size_t at = bytes.find(indices);
  ASSERT_NE(at, std::string::npos);
  for (const std::int32_t index : {3, -2, 1 << 30}) {
    std::string damaged = bytes;
    damaged.replace(at, 4, test::pack(index));
    test::write_bytes(folder / "b.bgeo", damaged);
    ParticleReadOptions options;
    options.all_attributes = true;
    const auto read = read_particles((folder / "b.bgeo").string(), options, Context());
    ASSERT_FALSE(read) << index;
    EXPECT_NE(read.error().message.find("expected a text index below 3, or -1 for none, found "), std::string::npos)
        << read.error().message;
  }
}

TEST(ParticleFileFormats, AreChosenByExtension) {
  EXPECT_EQ(particle_file_format_by_path("a/b_0001.ply"), ParticleFileFormat::ply);
  EXPECT_EQ(particle_file_format_by_path("B.NPY"), ParticleFileFormat::npy);
  EXPECT_EQ(particle_file_format_by_path("c.xyz"), ParticleFileFormat::xyz);
  EXPECT_EQ(particle_file_format_by_path("d.vdb"), std::nullopt);
  EXPECT_EQ(particle_file_format_by_path("ply"), std::nullopt);
}

}  // namespace
}  // namespace isoextract::particle_io
