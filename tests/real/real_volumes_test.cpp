// Volumes of scanners and solvers, read and extracted whole: the figures of EXPECTED.json (VTK 9.1 FlyingEdges3D on the
// same voxels, index space), and where the headers put them in the world.
#include <fstream>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>
#include <nlohmann/json.hpp>

#include "field/interpolant.hpp"
#include "support/data_folder.hpp"
#include "support/meshes.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract {
namespace {

struct Volume {
  const char* file;
  const char* expected;  // its name in EXPECTED.json
  std::optional<volume_io::RawLayout> raw;
  // index -> world as the header has it, copied by hand
  field::Affine world;
  // FlyingEdges keeps the inside corners of every face apart, which makes more surface in noise than the interpolant
  // has; see AreaIsNearerToTheInterpolants.
  double area_tolerance = 0.005;
};

field::Affine diagonal(const glm::dvec3& spacing, const glm::dvec3& origin) {
  field::Affine map = field::scaling(spacing);
  map.offset = origin;
  return map;
}

const Volume kVolumes[] = {
    {"med/ch2.nii.gz", "med/ch2.nii.gz", {}, diagonal({1, 1, 1}, {-90, -125, -71})},
    {"med/MR.nii.gz",
     "med/MR.nii.gz",
     {},
     diagonal({1, 0.8984370231628418, 0.8984370231628418}, {-388.260009765625, -81.11995697021484, 405.4209899902344}),
     0.015},
    {"med/tooth.nhdr", "med/tooth.nhdr", {}, diagonal({1, 1, 1}, {0, 0, 0})},
    {"med/FLAIR.nrrd",
     "med/FLAIR.nrrd",
     {},
     {glm::dmat3(-0.99359200921208746, 0.04970492721885441, -0.10151029228632795,    //
                 -0.016005020190061219, -0.95093665139041228, -0.30897139733494045,  //
                 -0.11188725988575336, -0.30536684015686016, 0.94563858529983524),
      {64.898239135742202, 110.4311447143555, -27.92553901672364}},
     0.01},
    {"mol/betaGal.npy", "mol/betaGal.npy", {}, diagonal({1, 1, 1}, {0, 0, 0})},
    {"med/HeadMRVolume.raw", "med/HeadMRVolume.mhd",
     volume_io::RawLayout{{48, 62, 42}, field::SampleType::u8, std::endian::little, 0}, diagonal({1, 1, 1}, {0, 0, 0}),
     0.025},
    {"vdb/smoke.vdb",
     "vdb/smoke.vdb",
     {},
     diagonal(glm::dvec3(0.4761904761904745), {-34.04761904761898, -13.095238095238095, -26.42857142857139}),
     0.02},
    {"vdb/sphere.vdb", "vdb/sphere.vdb", {}, diagonal(glm::dvec3(0.05), {0, 0, 0})},
};

void PrintTo(const Volume& volume, std::ostream* out) { *out << volume.file; }

class RealVolume : public testing::TestWithParam<Volume> {
 protected:
  void SetUp() override {
    ISOEXTRACT_NEEDS_DATA(GetParam().file);
    ISOEXTRACT_NEEDS_DATA("EXPECTED.json");
    expected_ = nlohmann::json::parse(std::ifstream(test::data_file("EXPECTED.json"))).at(GetParam().expected);
    volume_io::ReadOptions read;
    read.raw = GetParam().raw;
    auto field = volume_io::read_volume(test::data_file(GetParam().file).string(), read, Context());
    ASSERT_TRUE(field) << field.error().message;
    field_ = std::move(*field);
  }

  [[nodiscard]] extract::ExtractOptions options(extract::Method method) const {
    extract::ExtractOptions o;
    o.method = method;
    o.iso = expected_.at("iso");
    return o;
  }

  nlohmann::json expected_;
  field::ScalarField field_;
};

INSTANTIATE_TEST_SUITE_P(All, RealVolume, testing::ValuesIn(kVolumes), [](const auto& parameter) {
  std::string name = parameter.param.file;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
});

TEST_P(RealVolume, AgreesWithFlyingEdges) {
  const mesh::Mesh mesh = test::extract(field_, options(extract::Method::mc)).mesh;
  test::expect_sound(
      mesh, !expected_.at("border").get<bool>() || std::holds_alternative<field::SparseSamples>(field_.samples));
  const double area = expected_.at("area");
  EXPECT_NEAR(mesh::measure_size(mesh).area, area, GetParam().area_tolerance * area);
  // The figures count from the first voxel of the dense box they were made from: the active box and one voxel around.
  glm::dvec3 first(0);
  if (std::holds_alternative<field::SparseSamples>(field_.samples)) first = glm::dvec3(field_.extents().min - 1);
  const mesh::Bounds bounds = mesh::measure_bounds(mesh);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(bounds.min[axis] - first[axis], expected_.at("bounds").at(axis).get<double>(), 0.02);
    EXPECT_NEAR(bounds.max[axis] - first[axis], expected_.at("bounds").at(3 + axis).get<double>(), 0.02);
  }
}

// Where the areas differ: sampled twice as finely, the interpolant's surface has an area nearer to ours.
TEST_P(RealVolume, AreaIsNearerToTheInterpolants) {
  if (GetParam().area_tolerance <= 0.005) return;
  const field::IndexBox box = std::holds_alternative<field::SparseSamples>(field_.samples)
                                  ? field::IndexBox{field_.extents().min - 1, field_.extents().max + 1}
                                  : field_.extents();
  const glm::ivec3 dims = 2 * (box.max - box.min) + 1;
  auto values = std::make_shared<std::vector<float>>(
      static_cast<std::size_t>(dims.x) * static_cast<std::size_t>(dims.y) * static_cast<std::size_t>(dims.z));
  const field::Interpolant interpolant(field_, field::Interpolation::trilinear);
  tbb::parallel_for(0, dims.z, [&](int k) {
    field::Interpolant::Cursor cursor(interpolant);
    float* out = values->data() +
                 static_cast<std::size_t>(k) * static_cast<std::size_t>(dims.y) * static_cast<std::size_t>(dims.x);
    for (int j = 0; j < dims.y; ++j) {
      for (int i = 0; i < dims.x; ++i) {
        *out++ = static_cast<float>(cursor(glm::dvec3(box.min) + glm::dvec3(i, j, k) / 2.0).value);
      }
    }
  });
  field::ScalarField finer;
  finer.kind = field_.kind;
  const void* data = values->data();
  finer.samples = field::DenseSamples{field::SampleType::f32, dims, std::move(values), data};
  const double fine_area = mesh::measure_size(test::extract(finer, options(extract::Method::mc)).mesh).area / 4;
  const double area = mesh::measure_size(test::extract(field_, options(extract::Method::mc)).mesh).area;
  EXPECT_LT(std::abs(area - fine_area), std::abs(expected_.at("area").get<double>() - fine_area));
}

TEST_P(RealVolume, IsClosedWhenCapped) {
  for (const extract::Method method : {extract::Method::mc, extract::Method::mt}) {
    extract::ExtractOptions capped = options(method);
    capped.cap = true;
    const mesh::Mesh mesh = test::extract(field_, capped).mesh;
    test::expect_sound(mesh, true);
    EXPECT_GT(mesh::measure_size(mesh).volume, 0);
  }
}

TEST_P(RealVolume, LiesWhereItsHeaderSays) {
  const mesh::Mesh index = test::extract(field_, options(extract::Method::mc)).mesh;
  extract::ExtractOptions in_world = options(extract::Method::mc);
  in_world.output_from_index = field_.index_to_world;
  const mesh::Mesh world = test::extract(field_, in_world).mesh;
  ASSERT_EQ(index.positions.size(), world.positions.size());
  const double voxel = glm::length(GetParam().world.linear[0]);
  for (std::size_t v = 0; v < index.positions.size(); v += 97) {
    EXPECT_LT(glm::length(world.position(v) - GetParam().world(index.position(v))), 1e-3 * voxel);
  }
  test::expect_sound(world, false);
}

}  // namespace
}  // namespace isoextract
