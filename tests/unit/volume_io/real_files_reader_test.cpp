// Tests volumes of other programs against the data folder's own description.
#include "support/data_folder.hpp"
#include "support/hints.hpp"
#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

field::ScalarField read_data(const std::string& name, const volume_io::ReadOptions& options = {}) {
  return must_read(data_file(name), options);
}

struct Range {
  double min = HUGE_VAL;
  double max = -HUGE_VAL;
};

Range scaled_range(const field::ScalarField& field) {
  const auto& samples = std::get<field::DenseSamples>(field.samples);
  Range range;
  visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
    const auto* values = static_cast<const T*>(samples.data);
    const auto [low, high] = std::minmax_element(values, values + samples.count());
    range = {field.scale(static_cast<double>(*low)), field.scale(static_cast<double>(*high))};
  });
  return range;
}

glm::ivec3 dims_of(const field::ScalarField& field) { return std::get<field::DenseSamples>(field.samples).dims; }

TEST(RealFiles, ReadSformOfCh2) {
  ISOEXTRACT_NEEDS_DATA("med/ch2.nii.gz");
  const field::ScalarField field = read_data("med/ch2.nii.gz");
  EXPECT_EQ(dims_of(field), glm::ivec3(181, 217, 181));
  EXPECT_EQ(field.type(), field::SampleType::u8);
  EXPECT_EQ(scaled_range(field).min, 0);
  EXPECT_EQ(scaled_range(field).max, 254);
  EXPECT_NEAR(std::abs(field.index_to_world.determinant()), 1, 1e-9);
}

TEST(RealFiles, ApplyScaleOfMr) {
  ISOEXTRACT_NEEDS_DATA("med/MR.nii.gz");
  const field::ScalarField field = read_data("med/MR.nii.gz");
  EXPECT_EQ(dims_of(field), glm::ivec3(160, 232, 160));
  EXPECT_NEAR(field.scale.slope, 2.00784, 1e-5);
  EXPECT_NEAR(scaled_range(field).min, 0, 1e-9);
  EXPECT_NEAR(scaled_range(field).max, 512, 1e-3);
  EXPECT_NEAR(glm::length(field.index_to_world.linear[1]), 0.898, 1e-3);
}

TEST(RealFiles, ReadObliqueFlair) {
  ISOEXTRACT_NEEDS_DATA("med/FLAIR.nrrd");
  const field::ScalarField field = read_data("med/FLAIR.nrrd");
  EXPECT_EQ(dims_of(field), glm::ivec3(124, 160, 140));
  EXPECT_EQ(scaled_range(field).max, 255);
  EXPECT_EQ(field.world_space, "left-posterior-superior");
  // The header's numbers: origin + 10 * first direction + 20 * second direction.
  expect_near(field.index_to_world({10, 20, 0}), {64.898239135742202 - 9.9359200921208746 - 0.32010040380122438,
                                                  110.4311447143555 + 0.4970492721885441 - 19.018733027825004,
                                                  -27.92553901672364 - 1.0151029228632795 - 6.179427946698809});
}

TEST(RealFiles, ReadDetachedBigEndianTooth) {
  ISOEXTRACT_NEEDS_DATA("med/tooth.nhdr");
  const field::ScalarField field = read_data("med/tooth.nhdr");
  EXPECT_EQ(dims_of(field), glm::ivec3(103, 94, 161));
  EXPECT_EQ(field.type(), field::SampleType::u16);
  EXPECT_EQ(scaled_range(field).min, 0);
  EXPECT_EQ(scaled_range(field).max, 1300);
}

TEST(RealFiles, ReadRawHead) {
  ISOEXTRACT_NEEDS_DATA("med/HeadMRVolume.raw");
  volume_io::ReadOptions options;
  options.raw = volume_io::RawLayout{{48, 62, 42}, field::SampleType::u8, std::endian::little, 0};
  options.spacing = glm::dvec3(4);
  const field::ScalarField field = read_data("med/HeadMRVolume.raw", options);
  EXPECT_EQ(scaled_range(field).min, 0);
  EXPECT_EQ(scaled_range(field).max, 255);
  EXPECT_FALSE(volume_io::read_volume(data_file("med/HeadMRVolume.raw").string(), {}, Context()));
}

TEST(RealFiles, ReadNpyBetaGal) {
  ISOEXTRACT_NEEDS_DATA("mol/betaGal.npy");
  const field::ScalarField field = read_data("mol/betaGal.npy");
  EXPECT_EQ(dims_of(field), glm::ivec3(100, 100, 100));
  EXPECT_NEAR(scaled_range(field).min, -0.0530, 5e-5);
  EXPECT_NEAR(scaled_range(field).max, 0.1970, 5e-5);
}

TEST(RealFiles, ReadRotatedDirectionsOfTotalDensity) {
  ISOEXTRACT_NEEDS_DATA("mol/m4_TotalDensity.nrrd");
  const field::ScalarField field = read_data("mol/m4_TotalDensity.nrrd");
  EXPECT_EQ(dims_of(field), glm::ivec3(25, 22, 31));
  EXPECT_NEAR(scaled_range(field).max, 0.4928, 5e-5);
  EXPECT_EQ(field.world_space, "");
  expect_near(field.index_to_world({0, 0, 2}), {-11.492699 + 1.031148, -4.616844 - 0.469696, -0.903385 - 0.041268});
}

TEST(RealFiles, RejectElevation) {
  ISOEXTRACT_NEEDS_DATA("terrain/jacksboro_elevation.npy");
  expect_in(refusal(data_file("terrain/jacksboro_elevation.npy")).message, "shape (344, 403)");
}

TEST(RealFiles, RejectParticles) {
  ISOEXTRACT_NEEDS_DATA("particles/octocat_32614_particles.bgeo");
  expect_in(refusal(data_file("particles/octocat_32614_particles.bgeo")).message, "not a volume format");
}

TEST(RealFiles, ReadHalfFogVolumeOfSmoke) {
  ISOEXTRACT_NEEDS_DATA("vdb/smoke.vdb");
  const field::ScalarField field = read_data("vdb/smoke.vdb");
  const auto& samples = std::get<field::SparseSamples>(field.samples);
  EXPECT_EQ(field.name, "density");
  EXPECT_EQ(samples.type, field::SampleType::f32);
  EXPECT_EQ(samples.active_voxels, 1049275U);
  EXPECT_EQ(samples.active_box.dims(), glm::i64vec3(111, 222, 112));
  EXPECT_EQ(samples.background, 0);
  EXPECT_EQ(field.kind, field::FieldKind::density);
  EXPECT_NEAR(glm::length(field.index_to_world.linear[0]), 0.476, 1e-3);
  float high = 0;
  for (const field::SparseBlock& block : samples.blocks) {
    const auto* values = static_cast<const float*>(block.values);
    high = std::max(high, *std::max_element(values, values + 512));
  }
  EXPECT_NEAR(high, 5.71, 0.01);
}

TEST(RealFiles, ReadLevelSetOfSphere) {
  ISOEXTRACT_NEEDS_DATA("vdb/sphere.vdb");
  const field::ScalarField field = read_data("vdb/sphere.vdb");
  const auto& samples = std::get<field::SparseSamples>(field.samples);
  EXPECT_EQ(field.name, "ls_sphere");
  EXPECT_EQ(field.kind, field::FieldKind::level_set);
  EXPECT_EQ(samples.active_voxels, 270638U);
  EXPECT_EQ(samples.active_box.dims(), glm::i64vec3(125));
  EXPECT_NEAR(samples.background, 0.15, 1e-4);
  EXPECT_NEAR(field.index_to_world.linear[0][0], 0.05, 1e-6);
  EXPECT_FALSE(samples.tiles.empty()) << "the inside is inactive tiles of -0.15";
}

TEST(RealFiles, ListGridsAndReadDensityOfGasSequence) {
  for (const char* frame : {"0002", "0004", "0006", "0008", "0010"}) {
    const std::string name = std::string("vdb/c42_gas_seq/fluid_data_") + frame + ".vdb";
    ISOEXTRACT_NEEDS_DATA(name);
    const auto grids = volume_io::list_grids(data_file(name).string(), {}, Context());
    ASSERT_TRUE(grids);
    EXPECT_EQ(grids->size(), 24U);
    for (const volume_io::GridInfo& grid : *grids) {
      EXPECT_EQ(grid.scalar, grid.type == "float" || grid.type == "int32") << grid.name << ' ' << grid.type;
      // Every scalar grid can be read, also empty ones.
      volume_io::ReadOptions options;
      options.grid = grid.name;
      if (!grid.scalar) continue;
      const field::ScalarField field = read_data(name, options);
      EXPECT_EQ(std::get<field::SparseSamples>(field.samples).active_voxels, grid.voxels) << grid.name;
      EXPECT_EQ(field.extents(), grid.box) << grid.name;
    }
    const Error error = refusal(data_file(name));
    EXPECT_EQ(error.code, ErrorCode::input);
    expect_in(test::text_of(error.hint), "\n  density");
    expect_in(test::text_of(error.hint), "empty");
    expect_in(test::text_of(error.hint), "not scalar");
  }
}

}  // namespace
}  // namespace isoextract::test
