// Tests particle plug-ins: VTK's if it was built, and the messages without it.
#include <cstdlib>

#include "particle_io/detail/plugin_particles.hpp"
#include "support/data_folder.hpp"
#include "unit/particle_io/particle_files.hpp"

namespace isoextract::test {
namespace {

using particle_io::ParticleFormat;

const ParticleFormat& vtk_format() {
  static const auto formats = particle_io::find_particle_plugins({"/nowhere", std::filesystem::path(BUILT_PLUGINS)});
  return *formats.front();
}

Result<particle_io::ParticleFile> read_vtk(const std::filesystem::path& path,
                                           const particle_io::ParticleReadOptions& options = {},
                                           const Context& context = Context()) {
  try {
    return vtk_format().read(particle_io::must(files::InputFile::open(path, context)), options);
  } catch (const particle_io::InvalidParticleFile& damaged) {
    return fail(ErrorCode::input, damaged.what(), damaged.hint);
  } catch (const particle_io::Refused& refused) {
    return tl::unexpected(refused.error);
  }
}

#define NEEDS_VTK() \
  if (!BUILT_VTK) GTEST_SKIP() << "VTK was not found when this was built"

constexpr std::string_view kLegacy =
    "# vtk DataFile Version 3.0\nby hand\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 double\n1 2 3 4 5 6 7 8 9.5\n"
    "CELLS 3 6\n1 0\n1 1\n1 2\nCELL_TYPES 3\n1\n1\n1\nPOINT_DATA 3\nSCALARS id int 1\nLOOKUP_TABLE default\n70 71 72\n"
    "VECTORS velocity float\n-0 0.5 0.25 -3 0.5 3.25 -6 0.5 6.25\n";

constexpr std::string_view kXml =
    R"(<?xml version="1.0"?><VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData>)"
    R"(<Piece NumberOfPoints="2" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="0">)"
    R"(<PointData><DataArray type="Float32" Name="heat" format="ascii">7 8</DataArray>)"
    R"(<DataArray type="String" Name="word" format="ascii">97 0 98 0</DataArray></PointData>)"
    R"(<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">1 2 3 4 5 6</DataArray></Points>)"
    R"(</Piece></PolyData></VTKFile>)";

TEST(ParticlesPlugin, RecognizesFilesWithoutThePlugin) {
  const TempFolder folder;
  write_bytes(folder / "a.vtk", std::string(kLegacy));
  write_bytes(folder / "b.vtp", std::string(kXml));
  write_bytes(folder / "c.vti", R"(<VTKFile type="ImageData">)");
  const auto missing = particle_io::find_particle_plugins({folder.path()});
  ASSERT_EQ(missing.size(), 2U);
  EXPECT_EQ(missing.front()->about().id, "vtk");
  try {
    static_cast<void>(
        missing.front()->read(particle_io::must(files::InputFile::open(folder / "a.vtk", Context())), {}));
    FAIL();
  } catch (const particle_io::Refused& refused) {
    EXPECT_EQ(refused.error.code, ErrorCode::unavailable);
    expect_in(refused.error.message, "a.vtk: the format vtk needs the plug-in isoextract-particles-vtk.so");
  }
  const auto kind = [&](const std::string& name) {
    const auto found = particle_io::detect_particles((folder / name).string(), {}, Context());
    return found && *found ? (*found)->id : "none";
  };
  EXPECT_EQ(kind("a.vtk"), "vtk");
  EXPECT_EQ(kind("b.vtp"), "vtk");
  EXPECT_EQ(kind("c.vti"), "none");
}

TEST(ParticlesPlugin, FindsTables) {
  const TempFolder folder;
  write_bytes(folder / "isoextract-particles-abc.txt", "title: particles of abc\nextensions: .abc .abcd\n");
  const auto formats = particle_io::find_particle_plugins({folder.path()});
  ASSERT_EQ(formats.size(), 3U);
  EXPECT_EQ(formats[2]->about().id, "abc");
  EXPECT_EQ(formats[2]->about().extensions, (std::vector<std::string>{".abc", ".abcd"}));
}

TEST(ParticlesVtk, ReadsLegacyAndXml) {
  NEEDS_VTK();
  const TempFolder folder;
  write_bytes(folder / "a.vtk", std::string(kLegacy));
  write_bytes(folder / "b.vtp", std::string(kXml));
  const Context context;
  {
    const auto legacy = read_vtk(folder / "a.vtk", with_all(), context);
    ASSERT_TRUE(legacy) << legacy.error().message;
    expect_positions(legacy->particles, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9.5}});
    expect_attribute(legacy->particles, "id", 1, {70, 71, 72});
    expect_attribute(legacy->particles, "velocity", 3, {0, 0.5F, 0.25F, -3, 0.5F, 3.25F, -6, 0.5F, 6.25F});
    EXPECT_EQ(context.memory().reserved(), 3U * (24 + 4 + 12));
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
  particle_io::ParticleReadOptions places;
  places.attributes = {"position"};
  const auto with_places = read_vtk(folder / "a.vtk", places);
  ASSERT_TRUE(with_places) << with_places.error().message;
  expect_attribute(with_places->particles, "position", 3, {1, 2, 3, 4, 5, 6, 7, 8, 9.5F});
  const auto xml = read_vtk(folder / "b.vtp", with_all());
  ASSERT_TRUE(xml) << xml.error().message;
  expect_positions(xml->particles, {{1, 2, 3}, {4, 5, 6}});
  expect_attribute(xml->particles, "heat", 1, {7, 8});
  ASSERT_EQ(xml->notes.size(), 1U);
  expect_in(xml->notes.front().text, "'word'");
}

TEST(ParticlesVtk, RejectsInvalidFiles) {
  NEEDS_VTK();
  const TempFolder folder;
  const auto refusal_of = [&](const std::string& name, std::string text, const std::string& from,
                              const std::string& to) {
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    write_bytes(folder / name, text);
    const auto read = read_vtk(folder / name);
    if (read) throw std::runtime_error(name + " was read");
    return read.error().message;
  };
  const std::string legacy(kLegacy);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  expect_in(refusal_of("a.vtk", legacy, "POINTS 3", "POINTS 4000000000"),
            "expected at most as many points as fit into the file");
  expect_in(refusal_of("b.vtk", legacy.substr(0, 95), "", ""), "VTK cannot read the file");
  expect_in(refusal_of("c.vtk", legacy, "CELLS 3 6\n1 0\n1 1\n1 2\nCELL_TYPES 3\n1\n1\n1\n",
                       "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n"),
            "found a grid with 1 cells that are not points");
  expect_in(refusal_of("d.vtp", std::string(kXml), "</PolyData>", ""), "VTK cannot read the file");
  expect_in(refusal_of("e.vtp", std::string(kXml).substr(0, 200), "", ""), "VTK cannot read the file");
  EXPECT_EQ(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), "");
}

TEST(ParticlesVtk, ReadsDoubleDamBreakAndBunny) {
  NEEDS_VTK();
  ISOEXTRACT_NEEDS_DATA("particles/double_dam_break_frame_26_4732_particles.vtk");
  const auto dam = read_vtk(data_file("particles/double_dam_break_frame_26_4732_particles.vtk"), with_all());
  ASSERT_TRUE(dam) << dam.error().message;
  ASSERT_EQ(dam->particles.size(), 4732U);
  EXPECT_EQ(attribute_named(dam->particles, "id").values[0], 2379);
  EXPECT_EQ(attribute_named(dam->particles, "velocity").values[1], -1.556548F);
  glm::dvec3 low(1e9);
  for (const glm::dvec3& p : dam->particles.positions) low = glm::min(low, p);
  EXPECT_EQ(low, glm::dvec3(-1.5152689218521118, -0.015251494012773037, -1.5150896310806274));
  const auto bunny = read_vtk(data_file("particles/bunny_frame_14_7705_particles.vtk"));
  ASSERT_TRUE(bunny) << bunny.error().message;
  EXPECT_EQ(bunny->particles.size(), 7706U);
}

}  // namespace
}  // namespace isoextract::test
