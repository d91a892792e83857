// Tests shared behavior of the formats: detection, and options that do not apply.
#include <sys/stat.h>
#include <unistd.h>

#include "support/hints.hpp"
#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

const std::string kNrrd =
    "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 4 5\nencoding: raw\n\n" + ramp_bytes<std::uint8_t>();

ErrorCode kind_of_refusal(const std::string& input, const volume_io::ReadOptions& options) {
  const auto field = volume_io::read_volume(input, options, Context());
  if (field) throw std::runtime_error(input + " was read");
  const auto grids = volume_io::list_grids(input, options, Context());
  EXPECT_FALSE(grids) << "list_grids must refuse what read_volume refuses";
  return field.error().code;
}

TEST(VolumeReader, ListsEveryFormatOnce) {
  std::vector<std::string> formats;
  for (const volume_io::VolumeFormat* format : volume_io::volume_formats()) {
    formats.push_back(format->about().id);
    EXPECT_EQ(volume_io::find_volume_format(format->about().id), format);
  }
  EXPECT_EQ(formats, (std::vector<std::string>{"vdb", "nrrd", "nifti", "npy", "npz", "raw", "dat", "demo"}));
  EXPECT_EQ(volume_io::find_volume_format("obj"), nullptr);
}

TEST(VolumeReader, PrefersContentToExtension) {
  const TempFolder folder;
  for (const char* name : {"v.vdb", "v.npy", "v.raw", "v.nii.gz", "v.txt", "noextension"}) {
    write_bytes(folder / name, kNrrd);
    const field::ScalarField field = must_read(folder / name);
    expect_ramp<std::uint8_t>(field);
    const bool misnamed = std::string(name) != "v.txt" && std::string(name) != "noextension";
    EXPECT_EQ(has_note(field, "read as nrrd by its content, although it is named " + std::string(name)), misnamed);
  }
  write_bytes(folder / "v.NRRD", kNrrd);
  EXPECT_FALSE(has_note(must_read(folder / "v.NRRD"), "although"));
}

TEST(VolumeReader, ListsFormatsForUnknownContent) {
  const TempFolder folder;
  write_bytes(folder / "v.txt", "x,y,z\n1,2,3\n");
  const Error error = refusal(folder / "v.txt");
  EXPECT_EQ(error.code, ErrorCode::input);
  expect_in(error.message, "not a volume format that isoextract reads; it starts with 'x,y,z\\n1,2,3\\n'");
  for (const char* format : {"vdb", "nrrd", "nifti", "npy", "raw", ".nhdr"})
    expect_in(test::text_of(error.hint), format);
  write_bytes(folder / "v.gz", gzip("x,y,z\n1,2,3\n"));
  expect_in(refusal(folder / "v.gz").message, "not a volume format");
}

TEST(VolumeReader, NamesThePlugInThatUnpacksFiles) {
  const TempFolder folder;
  write_bytes(folder / "v.gz", gzip(kNrrd));
  const Error error = refusal(folder / "v.gz");  // the tests have no plug-ins beside them
  EXPECT_EQ(error.code, ErrorCode::unavailable);
  expect_in(error.message, "isoextract-unpack-archive.so");
}

TEST(VolumeReader, NamesTheFormatForUnfittingContent) {
  const TempFolder folder;
  for (const auto& [name, format] : std::vector<std::pair<std::string, std::string>>{{"v.vdb", "not a VDB file"},
                                                                                     {"v.nhdr", "not a NRRD file"},
                                                                                     {"v.nii", "not a NIfTI file"},
                                                                                     {"v.nii.gz", "not a NIfTI file"},
                                                                                     {"v.hdr", "not a NIfTI file"},
                                                                                     {"v.npy", "not a NumPy file"}}) {
    write_bytes(folder / name, "some text that is no volume\n");
    const Error error = refusal(folder / name);
    EXPECT_EQ(error.code, ErrorCode::input);
    expect_in(error.message, format);
    expect_in(error.message, "found 'some text that i...'");
  }
}

TEST(VolumeReader, RequiresALayoutForRawFiles) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", "12345678");
  const Error error = refusal(folder / "v.raw");
  EXPECT_EQ(error.code, ErrorCode::usage);
  EXPECT_EQ(error.hint, Hint(Remedy::give, Setting::raw_layout));
}

TEST(VolumeReader, ReadsUnknownFilesAsRawWithALayout) {
  const TempFolder folder;
  volume_io::ReadOptions options;
  options.raw = volume_io::RawLayout{kDims, field::SampleType::u8, std::endian::little, 0};
  for (const char* name : {"v.raw", "v.bin", "v", "v.nrrd"}) {
    write_bytes(folder / name, ramp_bytes<std::uint8_t>());
    expect_ramp<std::uint8_t>(must_read(folder / name, options));
  }
}

TEST(VolumeReader, RejectsOptionsOfOtherFormats) {
  const TempFolder folder;
  const std::string nrrd = (folder / "v.nrrd").string();
  write_bytes(nrrd, kNrrd);
  volume_io::ReadOptions with_layout;
  with_layout.raw = volume_io::RawLayout{kDims, field::SampleType::u8, std::endian::little, 0};
  volume_io::ReadOptions with_grid;
  with_grid.grid = "density";
  EXPECT_EQ(kind_of_refusal(nrrd, with_layout), ErrorCode::usage);
  EXPECT_EQ(kind_of_refusal(nrrd, with_grid), ErrorCode::usage);
  EXPECT_EQ(kind_of_refusal("demo:sphere?size=4", with_layout), ErrorCode::usage);
  EXPECT_EQ(kind_of_refusal("demo:sphere?size=4", with_grid), ErrorCode::usage);
  volume_io::ReadOptions as_demo;
  as_demo.format = "demo";
  EXPECT_EQ(kind_of_refusal(nrrd, as_demo), ErrorCode::usage);
  volume_io::ReadOptions unknown;
  unknown.format = "obj";
  EXPECT_EQ(kind_of_refusal(nrrd, unknown), ErrorCode::usage);
}

TEST(VolumeReader, FollowsTheGivenFormat) {
  const TempFolder folder;
  write_bytes(folder / "v.nrrd", kNrrd);
  volume_io::ReadOptions options;
  options.format = "raw";
  options.raw =
      volume_io::RawLayout{{static_cast<int>(kNrrd.size()), 1, 1}, field::SampleType::u8, std::endian::little, 0};
  EXPECT_EQ(dense_value<std::uint8_t>(must_read(folder / "v.nrrd", options), 1, 0, 0), 'R');
  options.raw.reset();
  for (const char* format : {"vdb", "nifti", "npy"}) {
    options.format = format;
    EXPECT_EQ(refusal(folder / "v.nrrd", options).code, ErrorCode::input);
  }
}

TEST(VolumeReader, RejectsPathsThatAreNotFiles) {
  const TempFolder folder;
  expect_in(refusal(folder / "missing.vdb").message, "No such file");
  std::filesystem::create_directory(folder / "folder.vdb");
  expect_in(refusal(folder / "folder.vdb").message, "found a folder that is none");
  for (const char* name : {"v.vdb", "v.nrrd", "v.nhdr", "v.nii", "v.nii.gz", "v.hdr", "v.npy", "v.raw", "v"}) {
    write_bytes(folder / name, "");
    expect_in(refusal(folder / name).message, "is empty");
  }
  ASSERT_EQ(::mkfifo((folder / "pipe.raw").c_str(), 0600), 0);
  expect_in(refusal(folder / "pipe.raw").message, "pipe or device");
  write_bytes(folder / "secret.npy", "x");
  std::filesystem::permissions(folder / "secret.npy", std::filesystem::perms::none);
  if (::geteuid() != 0) expect_in(refusal(folder / "secret.npy").message, "Permission denied");
}

TEST(VolumeReader, RejectsOneByteFiles) {
  const TempFolder folder;
  for (const char* name : {"v.vdb", "v.nrrd", "v.nii", "v.nii.gz", "v.hdr", "v.img", "v.npy", "v.raw", "v"}) {
    write_bytes(folder / name, "\x1f");
    EXPECT_FALSE(volume_io::read_volume((folder / name).string(), {}, Context())) << name;
  }
}

TEST(VolumeReader, ListsDenseVolumesWithoutReadingThem) {
  const TempFolder folder;
  // The header suffices.
  write_bytes(folder / "vol.nrrd", kNrrd);
  const auto grids = volume_io::list_grids((folder / "vol.nrrd").string(), {}, Context());
  ASSERT_TRUE(grids);
  ASSERT_EQ(grids->size(), 1U);
  const volume_io::GridInfo& grid = grids->front();
  EXPECT_EQ(grid.name, "vol");
  EXPECT_EQ(grid.type, "u8");
  EXPECT_TRUE(grid.scalar);
  EXPECT_FALSE(grid.kind);
  EXPECT_EQ(grid.box, (field::IndexBox{{0, 0, 0}, {2, 3, 4}}));
  EXPECT_EQ(grid.voxels, 60U);
}

TEST(VolumeReader, ReadsDemoFields) {
  volume_io::ReadOptions options;
  options.spacing = glm::dvec3(2, 2, 2);
  options.origin = glm::dvec3(1, 2, 3);
  const field::ScalarField field = must_read("demo:sphere?size=8", options);
  EXPECT_EQ(field.source, "demo:sphere?size=8");
  expect_near(field.index_to_world({1, 1, 1}), {3, 4, 5});
  const auto grids = volume_io::list_grids("demo:sphere?size=8", {}, Context());
  ASSERT_TRUE(grids);
  EXPECT_EQ(grids->front().voxels, 512U);
  EXPECT_EQ(kind_of_refusal("demo:nothing", {}), ErrorCode::usage);
}

}  // namespace
}  // namespace isoextract::test
