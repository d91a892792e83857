// Tests written fields: read back, and byte by byte for formats of other programs.
#include "volume_io/volume_writer.hpp"

#include <fstream>
#include <iterator>
#include <sstream>

#include <fmt/format.h>

#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

using volume_io::VolumeFileFormat;

template <class T>
field::ScalarField ramp_field(glm::ivec3 dims = kDims) {
  auto bytes = std::make_shared<std::string>(ramp_bytes<T>(std::endian::native, dims));
  field::DenseSamples samples;
  samples.type = field::sample_type_of<T>();
  samples.dims = dims;
  samples.data = bytes->data();
  samples.owner = bytes;
  field::ScalarField field;
  field.name = "ramp";
  field.index_to_world = {glm::dmat3(0.5, 0.1, 0, 0, 0.25, 0, 0, 0, 2), glm::dvec3(1e6, -3, 1.0 / 3)};
  field.samples = std::move(samples);
  return field;
}

std::string bytes_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return std::move(bytes).str();
}

template <class T>
void expect_ramp(const field::ScalarField& read) {
  const auto& samples = std::get<field::DenseSamples>(read.samples);
  ASSERT_EQ(samples.type, field::sample_type_of<T>());
  ASSERT_EQ(samples.dims, kDims);
  EXPECT_EQ(std::string(static_cast<const char*>(samples.data), samples.count() * sizeof(T)),
            ramp_bytes<T>(std::endian::native));
}

TEST(VolumeWriter, RoundTrips) {
  const TempFolder folder;
  const auto try_type = [&]<class T>(T /*of*/) {
    const field::ScalarField field = ramp_field<T>();
    const auto nrrd = volume_io::write_volume(folder / "a.nrrd", {&field, 1}, VolumeFileFormat::nrrd, Context());
    ASSERT_TRUE(nrrd) << nrrd.error().message;
    EXPECT_EQ(*nrrd, std::filesystem::file_size(folder / "a.nrrd"));
    const field::ScalarField read = must_read(folder / "a.nrrd");
    expect_ramp<T>(read);
    EXPECT_EQ(read.index_to_world, field.index_to_world) << "to the last bit";
    ASSERT_TRUE(volume_io::write_volume(folder / "a.npy", {&field, 1}, VolumeFileFormat::npy, Context()));
    expect_ramp<T>(must_read(folder / "a.npy"));
    ASSERT_TRUE(volume_io::write_volume(folder / "a.raw", {&field, 1}, VolumeFileFormat::raw, Context()));
    EXPECT_EQ(bytes_of_file(folder / "a.raw"), ramp_bytes<T>(std::endian::native));
  };
  try_type(std::uint8_t{});
  try_type(std::int16_t{});
  try_type(std::uint32_t{});
  try_type(float{});
  try_type(double{});
}

TEST(VolumeWriter, WritesOneLayerAsTwoAxes) {
  const TempFolder folder;
  const field::ScalarField field = ramp_field<double>({3, 4, 1});
  ASSERT_TRUE(volume_io::write_volume(folder / "a.npy", {&field, 1}, VolumeFileFormat::npy, Context()));
  const std::string bytes = bytes_of_file(folder / "a.npy");
  ASSERT_EQ(bytes.size(), 128U + 12 * 8);
  EXPECT_EQ(bytes.substr(0, 10), std::string("\x93NUMPY\1\0\x76\0", 10));
  EXPECT_EQ(bytes.substr(10, 59), "{'descr': '<f8', 'fortran_order': False, 'shape': (4, 3), }");
  EXPECT_EQ(bytes[127], '\n');
}

// Our readers and VTK's agree on the byte layout; tests/cli/field_formats_test.py asks VTK.
TEST(VolumeWriter, WritesImageDataOfVtk) {
  const TempFolder folder;
  field::ScalarField field = ramp_field<std::int16_t>();
  field.name = "a<\"b\">&";
  field.index_to_world = {glm::dmat3(0, 0.5, 0, -0.25, 0, 0, 0, 0, 2), glm::dvec3(1, -3, 0.125)};
  const auto written = volume_io::write_volume(folder / "a.vti", {&field, 1}, VolumeFileFormat::vti, Context());
  ASSERT_TRUE(written) << written.error().message;
  const std::string bytes = bytes_of_file(folder / "a.vti");
  EXPECT_EQ(*written, bytes.size());
  const std::string extent = fmt::format("0 {} 0 {} 0 {}", kDims.x - 1, kDims.y - 1, kDims.z - 1);
  for (const std::string& part :
       {fmt::format("WholeExtent=\"{}\" Origin=\"1 -3 0.125\" Spacing=\"0.5 0.25 2\" Direction=\"0 -1 0 1 0 0 0 0 1\"",
                    extent),
        fmt::format("<Piece Extent=\"{}\">", extent),
        std::string("type=\"Int16\" Name=\"a&lt;&quot;b&quot;&gt;&amp;\""), std::string("header_type=\"UInt64\"")}) {
    EXPECT_NE(bytes.find(part), std::string::npos) << part;
  }
  const std::string samples = ramp_bytes<std::int16_t>(std::endian::native);
  const std::size_t start = bytes.find("   _") + 4;
  std::uint64_t size = 0;
  bytes.copy(reinterpret_cast<char*>(&size), sizeof size, start);
  EXPECT_EQ(size, samples.size());
  EXPECT_EQ(bytes.substr(start + sizeof size, samples.size()), samples);
  EXPECT_EQ(bytes.substr(start + sizeof size + samples.size()), "\n  </AppendedData>\n</VTKFile>\n");
}

TEST(VolumeWriter, KeepsTheSpaceOfScans) {
  const TempFolder folder;
  field::ScalarField field = ramp_field<float>();
  field.length_unit = "mm";
  for (const auto& [space, read] :
       {std::pair("RAS+ (NIfTI)", "right-anterior-superior"),
        std::pair("left-posterior-superior", "left-posterior-superior"), std::pair("some other space", "")}) {
    field.world_space = space;
    ASSERT_TRUE(volume_io::write_volume(folder / "a.nrrd", {&field, 1}, VolumeFileFormat::nrrd, Context()));
    const field::ScalarField again = must_read(folder / "a.nrrd");
    EXPECT_EQ(again.world_space, read);
    EXPECT_EQ(again.length_unit, "mm");
    EXPECT_EQ(again.index_to_world, field.index_to_world);
  }
}

TEST(VolumeWriter, ChoosesFormatsByExtension) {
  EXPECT_EQ(volume_io::volume_file_format_by_path("a/b.NPY"), VolumeFileFormat::npy);
  EXPECT_EQ(volume_io::volume_file_format_by_path("b.vdb"), VolumeFileFormat::vdb);
  EXPECT_EQ(volume_io::volume_file_format_by_path("b.nii"), std::nullopt);
  EXPECT_EQ(volume_io::volume_file_format_by_path("npy"), std::nullopt);
}

TEST(VolumeWriter, RejectsUnsupportedFields) {
  const TempFolder folder;
  const auto refused = [&](std::span<const field::ScalarField> fields, VolumeFileFormat format) {
    const auto written = volume_io::write_volume(folder / "a.out", fields, format, Context());
    EXPECT_FALSE(std::filesystem::exists(folder / "a.out"));
    return written ? std::string() : written.error().message;
  };
  const std::vector<field::ScalarField> two(2, ramp_field<float>());
  EXPECT_NE(refused(two, VolumeFileFormat::npy).find("npy files cannot store 2 fields"), std::string::npos);
  field::ScalarField field = ramp_field<float>();
  field.scale.slope = 2;
  EXPECT_NE(refused({&field, 1}, VolumeFileFormat::raw).find("a value scale"), std::string::npos);
  field = {};
  field.samples = field::SparseSamples{};
  EXPECT_NE(refused({&field, 1}, VolumeFileFormat::nrrd).find("sparse fields"), std::string::npos);
  field = ramp_field<float>();
  std::get<field::DenseSamples>(field.samples).type = field::SampleType::f16;
  EXPECT_NE(refused({&field, 1}, VolumeFileFormat::nrrd).find("16-bit floats"), std::string::npos);
  EXPECT_NE(refused({&field, 1}, VolumeFileFormat::vti).find("16-bit floats"), std::string::npos);
  EXPECT_NE(refused({two.data(), 1}, VolumeFileFormat::vti).find("axes that are not perpendicular"), std::string::npos);
  const auto nowhere =
      volume_io::write_volume(folder / "none" / "a.raw", {&field, 1}, VolumeFileFormat::raw, Context());
  EXPECT_EQ(nowhere.error().code, ErrorCode::output);
}

}  // namespace
}  // namespace isoextract::test
