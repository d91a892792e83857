#include "convert/conversion_job.hpp"
#include "convert/json_values.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

namespace isoextract::convert {
namespace {

// Returns a job that writes meshes and in which every member differs from its default.
ConversionJob full_job() {
  ConversionJob job;
  job.source.input = "dir/in \xc3\xa4.raw";
  job.source.read.format = "raw";
  job.source.read.grid = "density[1]";
  job.source.more_grids = {"flame", "heat"};
  job.source.mesh = true;
  job.source.read.volume = 7;
  job.source.read.raw = volume_io::RawLayout{{3, 4, 5}, field::SampleType::i16, std::endian::big, 512, 3, true};
  job.source.read.spacing = glm::dvec3(0.1, 1e-300, 3);
  job.source.read.origin = glm::dvec3(-1, 2, 0.30000000000000004);
  job.source.read.kind = field::FieldKind::level_set;
  job.source.read.component = volume_io::ComponentChoice{};
  job.source.read.axis_order = volume_io::AxisOrder::xyz;
  job.source.read.level = 2;
  job.source.read.resamples = true;
  job.source.read.no_data = -9999.5;
  job.source.particles = {.expected = true,
                          .method = points::Method::anisotropic,
                          .radius = 0.025,
                          .sequence_radius = 0.0625,
                          .element_radii = points::ElementRadii::covalent,
                          .cell_size = 0.5,
                          .sequence_spacing = 0.0125,
                          .smoothing_length = 1.2,
                          .weight = 0.3,
                          .deposit = points::Deposit::nearest,
                          .non_finite = points::NonFiniteParticles::skip,
                          .columns = std::array<std::string, 3>{"x", "2", "z"},
                          .select = "type == 2",
                          .stride = 3,
                          .simulation_box = {.bounds = field::Box{glm::dvec3(1, 2, 3), glm::dvec3(4, 5, 6)},
                                             .periodic = std::array{true, false, true},
                                             .unwrap = true}};
  job.source.attributes = {{.name = "heat",
                            .from = "b.vdb[temperature]",
                            .written = false,
                            .optional = true,
                            .kind = AttributeKind::vector,
                            .spacing = glm::dvec3(1, 2, 3),
                            .origin = glm::dvec3(4, 5, 6),
                            .no_data = -1.5,
                            .volume = 2,
                            .component = volume_io::ComponentChoice{1}},
                           {"v", "velocity", false}};
  job.source.filters = {{volume_io::LevelSetFilter::median, 2}, {volume_io::LevelSetFilter::mean, 1}};
  job.source.blurs = {{BlurKind::median, 2, false}, {BlurKind::gaussian, 0.5, true}};
  job.source.resolution = glm::ivec3(10, 20, 30);
  job.source.voxel_size = glm::dvec3(0.5, 1, 2e-3);
  job.source.away_from_zero = true;
  job.source.kernel = field::ResampleKernel::bspline;
  job.source.clip = {{{1, -2, 0.5}, 1e-3}, {{0, 0, 1}, -7}};
  job.source.roi = field::Box{{-1, -2, -3}, {1, 2, 3}};
  job.source.roi_snap = true;
  job.source.placement = {Space::index, UpAxis::y, true, true, 0.001, "mm", "cm", AnatomicalSpace::lps, true};
  job.surface = {extract::Method::mt,
                 extract::NanPolicy::hole,
                 true,
                 extract::VoxelFaces::plain,
                 3,
                 5,
                 12,
                 extract::HeightOptions{.solid = true, .base = -2.5}};
  job.normals = Normals::flat;
  job.color = ColorChoice{"heat", edit::Colormap::turbo, std::array{-1.5, 2.25}};
  job.label_names = LabelTableFile{"lut.txt", "0123"};
  job.opacity = {0.25, 1};
  job.source.masks = {"liver.nii.gz", "spleen.nii.gz"};
  job.edits.repair = RepairChoice{12};
  job.edits.pieces = {MinComponentSize{edit::ComponentMeasure::area, 2.5, true}, true, 3, true};
  job.edits.smooth = SmoothChoice{7, edit::SmoothMethod::sinc, 0.25};
  job.edits.hollow = HollowChoice{2.5, "mm"};
  job.edits.simplify = SimplifyChoice{SimplifyBound{0.1, true}, TriangleCount{2.5, true}};
  job.edits.touching = Touching::apart;
  job.edits.require = {check::Requirement::closed, check::Requirement::no_self_intersections};
  job.error = field::Interpolation::tricubic;
  job.verify = true;
  job.backend = {Backend::automatic, {gl::CudaIndex{2}, 1U << 20U}};
  job.empty = EmptyPolicy::write;
  job.file = MeshFileOptions{mesh_io::MeshFormat::stl, true, {mesh_io::Compression::draco, true, 12, true}};
  job.outputs = {{"a.stl", {0.1}, "flame"},
                 {"-",
                  {1.0 / 3, -5, IsoChoice::suggested(), IsoChoice::percentile(*field::Percent::parse("99.9")),
                   IsoChoice::label(-7), IsoChoice::all_labels()}}};
  return job;
}

// Every member of full_job() differs from its default, so the comparison finds a member that the JSON omits or repeats.
TEST(ConversionJob, ListsEveryMemberInJson) {
  const Json full = json_of(full_job());
  const Json plain = json_of(ConversionJob{});
  EXPECT_EQ(full.size(), 71U);
  for (const auto& [name, value] : full.items()) {
    // ListsMembersOfEveryFileKind
    const bool is_of_another_kind = name == "field_file" || name == "picture_file" || name == "particle_file";
    EXPECT_EQ(value == plain[name], is_of_another_kind) << name;
  }
  EXPECT_EQ(
      full["particles"].dump(),
      R"({"expected":true,"method":"anisotropic","radius":0.025,"sequence_radius":0.0625,"element_radii":"covalent","cell_size":0.5,)"
      R"("sequence_spacing":0.0125,)"
      R"("smoothing_length":1.2,"weight":0.3,"deposit":"nearest","not_finite":"skip","columns":["x","2","z"],)"
      R"("select":"type == 2","stride":3,)"
      R"("simulation_box":{"bounds":{"min":[1.0,2.0,3.0],"max":[4.0,5.0,6.0]},"periodic":[true,false,true],"unwrap":true}})");
  EXPECT_EQ(full["attributes"][0].dump(),
            R"({"name":"heat","from":"b.vdb[temperature]","written":false,"optional":true,"kind":"vector",)"
            R"("spacing":[1.0,2.0,3.0],"origin":[4.0,5.0,6.0],"no_data":-1.5,"volume":2,"component":1})");
  EXPECT_EQ(full["color"].dump(), R"({"attribute":"heat","map":"turbo","range":[-1.5,2.25]})");
  EXPECT_EQ(full["label_names"].dump(), R"({"path":"lut.txt","hash":"0123"})");
  EXPECT_EQ(full["filters"][0].dump(), R"({"filter":"median","width":2})");
  EXPECT_EQ(full["outputs"][0].dump(), R"({"path":"a.stl","iso":[0.1],"grid":"flame"})");
  EXPECT_EQ(full["pieces"].dump(),
            R"({"least":{"measure":"area","amount":2.5,"in_world_units":true},"fill_cavities":true,"largest":3,)"
            R"("split":true})");
  EXPECT_EQ(full["smooth"].dump(), R"({"passes":7,"method":"sinc","pass_band":0.25})");
  EXPECT_EQ(full["simplify"].dump(),
            R"({"within":{"distance":0.1,"in_world_units":true},"triangles":{"amount":2.5,"in_percent":true}})");
  EXPECT_EQ(full["raw"].dump(),
            R"({"dims":[3,4,5],"dtype":"i16","endian":"big","skip":512,"components":3,"planar":true})");
  EXPECT_EQ(full["clip"][0].dump(), R"({"normal":[1.0,-2.0,0.5],"offset":0.001})");
  EXPECT_EQ(full["blurs"][1].dump(), R"({"kind":"gaussian","width":0.5,"in_world_units":true})");
  EXPECT_TRUE(plain["smooth"].is_null());
}

// The members of the job's kind of file are set; those of other kinds have their defaults.
TEST(ConversionJob, ListsMembersOfEveryFileKind) {
  ConversionJob job;
  std::set<std::string> hashes{hash_of(job)};
  const PictureFileOptions picture{320, 200, {12.5, -40, 3.0}, std::numbers::pi / 2, {0, 0.25, 0.5, 1}};
  for (const FileOptions& file :
       {FileOptions(FieldFileOptions{true}), FileOptions(FieldFileOptions()), FileOptions(ParticleFileOptions()),
        FileOptions(ParticleFileOptions{particle_io::ParticleFileFormat::vtu}), FileOptions(PictureFileOptions()),
        FileOptions(picture)}) {
    job.file = file;
    EXPECT_TRUE(hashes.insert(hash_of(job)).second);
    EXPECT_EQ(json_of(job)["format"], "glb");
  }
  EXPECT_EQ(json_of(job)["picture_file"].dump(),
            R"({"width":320,"height":200,"azimuth":12.5,"elevation":-40.0,"distance":3.0,"look_at":null,)"
            R"("field_of_view":90.0,"background_color":[0.0,0.25,0.5,1.0]})");
  EXPECT_EQ(json_of(job)["field_file"], nullptr);
  EXPECT_EQ(json_of(job)["particle_file"], nullptr);
  job.file = ParticleFileOptions{particle_io::ParticleFileFormat::vtu};
  EXPECT_EQ(json_of(job)["particle_file"].dump(), R"({"format":"vtu"})");
}

TEST(ConversionJob, WritesIsoValuesAsNumbersOrWords) {
  EXPECT_EQ(json_of(full_job())["outputs"][1]["iso"].dump(),
            R"([0.3333333333333333,-5.0,"auto","p99.9","label -7","all labels"])");
  std::set<std::string> hashes;
  for (const IsoChoice& iso :
       {IsoChoice(), IsoChoice(99), IsoChoice::suggested(), IsoChoice::percentile(field::Percent(99)),
        IsoChoice::percentile(field::Percent(0)), IsoChoice::label(99), IsoChoice::label(0), IsoChoice::all_labels()}) {
    ConversionJob job;
    job.outputs = {{"a.ply", {iso}}};
    EXPECT_TRUE(hashes.insert(hash_of(job)).second) << text_of(iso);
  }
}

TEST(ConversionJob, HashesEqualJobsAlike) {
  EXPECT_EQ(hash_of(full_job()), hash_of(full_job()));
  EXPECT_EQ(hash_of(full_job()).size(), 32U);
  ConversionJob not_utf8;
  not_utf8.source.input = "a\xff.raw";
  ConversionJob another;
  another.source.input = "a\xfe.raw";
  EXPECT_NE(hash_of(not_utf8), hash_of(another));
}

}  // namespace
}  // namespace isoextract::convert
