// Tests that samples are mapped if their layout in the file fits and read otherwise, with equal results.
#include <fstream>

#include <sys/resource.h>
#include <unistd.h>

#include "field/sample_layers.hpp"
#include "files/mapped_file.hpp"
#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

const field::DenseSamples& dense(const field::ScalarField& field) {
  return std::get<field::DenseSamples>(field.samples);
}

volume_io::ReadOptions raw_options(field::SampleType type, std::uint64_t skip = 0,
                                   std::endian endian = std::endian::native) {
  volume_io::ReadOptions options;
  options.raw = volume_io::RawLayout{kDims, type, endian, skip};
  return options;
}

std::string npy(const std::string& descr, const std::string& samples, bool fortran = false) {
  std::string text =
      "{'descr': '" + descr + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': (5, 4, 3), }";
  text.resize(128 - 10 - 1, ' ');  // NumPy's padding
  text += '\n';
  return std::string("\x93NUMPY\x01\0", 8) + pack(static_cast<std::uint16_t>(text.size())) + text + samples;
}

// Returns a file whose samples start at a multiple of 64, or `off` bytes after one.
std::string nrrd(const std::string& fields, const std::string& samples, std::size_t off = 0) {
  std::string header = "NRRD0005\ntype: float\ndimension: 3\nsizes: 3 4 5\n" + fields + "# ";
  header.resize(256 + off - 2, '-');
  return header + "\n\n" + samples;
}

std::string nifti(const std::string& samples) {
  std::string bytes(352, '\0');
  put(bytes, 0, 348);
  bytes.replace(344, 4, std::string("n+1") + '\0');
  put(bytes, 40, std::int16_t{3});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(bytes, 42 + 2 * axis, static_cast<std::int16_t>(kDims[static_cast<int>(axis)]));
  }
  put(bytes, 70, std::int16_t{16});  // float
  for (std::size_t i = 0; i < 4; ++i) put(bytes, 76 + 4 * i, 1.0F);
  put(bytes, 108, 352.0F);
  return bytes + samples;
}

template <class T>
class MappedSamples : public testing::Test {};
using AllTypes = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                                field::Half, float, double>;
TYPED_TEST_SUITE(MappedSamples, AllTypes);

TYPED_TEST(MappedSamples, MapEveryTypeAfterAnAlignedHeader) {
  const TempFolder folder;
  for (const std::size_t skip : {0, 8, 4096, 5000}) {
    write_bytes(folder / "v.raw", std::string(skip, 'x') + ramp_bytes<TypeParam>(std::endian::native));
    const field::ScalarField field = must_read(folder / "v.raw", raw_options(field::sample_type_of<TypeParam>(), skip));
    EXPECT_TRUE(dense(field).file_backed) << skip;
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(dense(field).data) % sizeof(TypeParam), 0U);
    expect_ramp<TypeParam>(field);
  }
}

TYPED_TEST(MappedSamples, AreReadIfMisalignedOrSwapped) {
  const TempFolder folder;
  const bool one_byte = sizeof(TypeParam) == 1;
  write_bytes(folder / "v.raw", "x" + ramp_bytes<TypeParam>(std::endian::native));
  const field::ScalarField odd = must_read(folder / "v.raw", raw_options(field::sample_type_of<TypeParam>(), 1));
  EXPECT_EQ(dense(odd).file_backed, one_byte);
  expect_ramp<TypeParam>(odd);
  write_bytes(folder / "v.raw", ramp_bytes<TypeParam>(std::endian::big));
  const field::ScalarField swapped =
      must_read(folder / "v.raw", raw_options(field::sample_type_of<TypeParam>(), 0, std::endian::big));
  EXPECT_EQ(dense(swapped).file_backed, one_byte);
  expect_ramp<TypeParam>(swapped);
}

TEST(MappedFormats, MapUncompressedSamplesInOneBlock) {
  const TempFolder folder;
  const std::string samples = ramp_bytes<float>();
  const std::string little = "encoding: raw\nendian: little\n";
  write_bytes(folder / "a.npy", npy("<f4", samples));
  write_bytes(folder / "b.nrrd", nrrd(little, samples));
  write_bytes(folder / "c.nhdr", nrrd(little + "byte skip: 4\ndata file: c.bin\n", ""));
  write_bytes(folder / "c.bin", "head" + samples);
  write_bytes(folder / "d.nii", nifti(samples));
  for (const char* name : {"a.npy", "b.nrrd", "c.nhdr", "d.nii"}) {
    SCOPED_TRACE(name);
    const field::ScalarField field = must_read(folder / name);
    EXPECT_TRUE(dense(field).file_backed);
    expect_ramp<float>(field);
    const auto files = volume_io::list_input_files((folder / name).string(), {}, Context());
    ASSERT_TRUE(files);
    EXPECT_EQ(files->front(), folder / name);
    EXPECT_TRUE(std::filesystem::equivalent(files->back(), folder / (std::string(name) == "c.nhdr" ? "c.bin" : name)));
  }
}

TEST(MappedFormats, ReadSamplesThatNeedConversion) {
  const TempFolder folder;
  const std::string samples = ramp_bytes<float>();
  const std::string little = "encoding: raw\nendian: little\n";
  std::string turned;
  for (int i = 0; i < kDims.x; ++i) {
    for (int j = 0; j < kDims.y; ++j) {
      for (int k = 0; k < kDims.z; ++k) turned += pack(ramp<float>(i, j, k));
    }
  }
  write_bytes(folder / "turned.npy", npy("<f4", turned, true));
  write_bytes(folder / "swapped.npy", npy(">f4", ramp_bytes<float>(std::endian::big)));
  write_bytes(folder / "odd.nrrd", nrrd(little, samples, 2));
  write_bytes(folder / "packed.nrrd", nrrd("encoding: gzip\nendian: little\n", gzip(samples)));
  write_bytes(folder / "packed.nii.gz", gzip(nifti(samples)));
  write_bytes(folder / "pieces.nhdr", nrrd(little + "data file: piece%d.bin 1 5 1\n", ""));
  const std::size_t slice = samples.size() / 5;
  for (std::size_t i = 0; i < 5; ++i) {
    write_bytes(folder / ("piece" + std::to_string(i + 1) + ".bin"), samples.substr(i * slice, slice));
  }
  for (const char* name : {"turned.npy", "swapped.npy", "odd.nrrd", "packed.nrrd", "packed.nii.gz", "pieces.nhdr"}) {
    SCOPED_TRACE(name);
    const field::ScalarField field = must_read(folder / name);
    EXPECT_FALSE(dense(field).file_backed);
    expect_ramp<float>(field);
  }
}

TEST(MappedFormats, CountAsReadOnceAndAsProgress) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", ramp_bytes<float>());
  const Context context;
  volume_io::ReadOptions options = raw_options(field::SampleType::f32);
  options.format = "raw";
  const field::ScalarField field = must_read(folder / "v.raw", options, context);
  EXPECT_TRUE(dense(field).file_backed);
  EXPECT_GE(context.counters().bytes_read, 240U);
  EXPECT_LT(context.counters().bytes_read, 480U + 240U);  // detection reads the first bytes
  EXPECT_STREQ(context.progress().stage(), "reading");
  EXPECT_EQ(context.progress().total(), 240U);
  EXPECT_EQ(context.progress().done(), 240U);
}

TEST(MappedFormats, NeedNoReservedMemory) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", ramp_bytes<float>());
  expect_ramp<float>(must_read(folder / "v.raw", raw_options(field::SampleType::f32), with_memory(0)));
}

TEST(MappedFormats, SurviveRemovalOrReplacementOfTheFile) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", ramp_bytes<float>());
  const field::ScalarField field = must_read(folder / "v.raw", raw_options(field::SampleType::f32));
  write_bytes(folder / "new.raw", "short");
  std::filesystem::rename(folder / "new.raw", folder / "v.raw");
  expect_ramp<float>(field);
}

TEST(MappedFormats, ReportLossOfTruncatedFiles) {
  const TempFolder folder;
  const glm::ivec3 dims{64, 64, 64};  // 64 pages
  write_bytes(folder / "v.raw", ramp_bytes<std::uint8_t>(std::endian::native, dims));
  volume_io::ReadOptions options = raw_options(field::SampleType::u8);
  options.raw->dims = dims;
  const field::ScalarField field = must_read(folder / "v.raw", options);
  EXPECT_TRUE(volume_io::check_mapping_intact(field));
  std::filesystem::resize_file(folder / "v.raw", 4096);
  EXPECT_EQ(dense_value<std::uint8_t>(field, 1, 0, 0), ramp<std::uint8_t>(1, 0, 0));
  EXPECT_TRUE(volume_io::check_mapping_intact(field));
  EXPECT_EQ(dense_value<std::uint8_t>(field, 1, 1, 63), 0);
  const auto whole = volume_io::check_mapping_intact(field);
  ASSERT_FALSE(whole);
  EXPECT_EQ(whole.error().code, ErrorCode::input);
  expect_in(whole.error().message, "became shorter");
}

// Limits the address space of the process to what it has now and `more` bytes.
class AddressSpaceLimit {
 public:
  explicit AddressSpaceLimit(std::uint64_t more) {
    ::getrlimit(RLIMIT_AS, &before_);
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlimit limit{pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + more, before_.rlim_max};
    ::setrlimit(RLIMIT_AS, &limit);
  }
  AddressSpaceLimit(const AddressSpaceLimit&) = delete;
  AddressSpaceLimit& operator=(const AddressSpaceLimit&) = delete;
  ~AddressSpaceLimit() { ::setrlimit(RLIMIT_AS, &before_); }

 private:
  rlimit before_{};
};

TEST(MappedLayers, AreThoseOfTheFile) {
  const TempFolder folder;
  const glm::ivec3 dims{1024, 1024, 256};
  const std::size_t header = 100;
  write_bytes(folder / "v.raw", std::string(header, 'h'));
  std::filesystem::resize_file(folder / "v.raw", header + (std::uint64_t{1} << 28U));
  {
    std::fstream file(folder / "v.raw", std::ios::in | std::ios::out | std::ios::binary);
    for (int z = 0; z < dims.z; ++z) {
      file.seekp(static_cast<std::streamoff>(header) + (static_cast<std::streamoff>(z) << 20) + 77);
      file.put(static_cast<char>(z));
    }
  }
  volume_io::ReadOptions options = raw_options(field::SampleType::u8, header);
  options.raw->dims = dims;
  options.by_layers = true;
  // Without a limit, the reader maps the whole file.
  EXPECT_EQ(dense(must_read(folder / "v.raw", options)).layers, nullptr);
  const AddressSpaceLimit limit(std::uint64_t{1} << 27U);
  options.by_layers = false;
  EXPECT_FALSE(volume_io::read_volume((folder / "v.raw").string(), options, with_memory(0)));
  options.by_layers = true;
  const Context context;
  const field::ScalarField field = must_read(folder / "v.raw", options, context);
  ASSERT_NE(dense(field).layers, nullptr);
  EXPECT_EQ(dense(field).data, nullptr);
  EXPECT_FALSE(dense(field).file_backed);
  EXPECT_LT(context.counters().bytes_read, (std::uint64_t{1} << 28U) + 4096U);
  ASSERT_FALSE(field.notes.empty());
  EXPECT_EQ(field.notes.back().id, NoteId::samples_in_windows);
  {
    const auto window = dense(field).layers->open(3);
    ASSERT_TRUE(window);
    for (const int begin : {0, 253, 100}) {
      const auto shown = (*window)->move_to(begin, begin + 3);
      ASSERT_TRUE(shown);
      for (int z = 0; z < 3; ++z) {
        EXPECT_EQ(static_cast<const std::uint8_t*>(*shown)[(z << 20) + 77], begin + z);
        EXPECT_EQ(static_cast<const std::uint8_t*>(*shown)[(z << 20) + 78], 0);
      }
    }
    EXPECT_TRUE(volume_io::check_mapping_intact(field));
    const auto too_many = dense(field).layers->open(200);
    ASSERT_FALSE(too_many);
    EXPECT_EQ(too_many.error().code, ErrorCode::out_of_memory);
    expect_in(too_many.error().message, "v.raw: mapping 200 layers of samples (200 MiB) failed: the address space of");
    std::filesystem::resize_file(folder / "v.raw", 10000);
    const auto cut = (*window)->move_to(1, 2);
    ASSERT_TRUE(cut);
    EXPECT_EQ(static_cast<const std::uint8_t*>(*cut)[77], 0);
  }
  const auto whole = volume_io::check_mapping_intact(field);
  ASSERT_FALSE(whole);
  expect_in(whole.error().message, "became shorter");
}

TEST(MappedFile, MapsOnlyRangesWithinTheFile) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", std::string(5000, 'a') + "b");
  const auto file = files::InputFile::open(folder / "v.raw", Context());
  ASSERT_TRUE(file);
  const auto last = files::MappedFile::map(*file, 5000, 1);
  ASSERT_TRUE(last);
  EXPECT_EQ(*last->data(), std::byte{'b'});
  EXPECT_TRUE(files::MappedFile::map(*file, 0, 5001));
  EXPECT_FALSE(files::MappedFile::map(*file, 0, 5002));
  EXPECT_FALSE(files::MappedFile::map(*file, 5001, 1));
  EXPECT_FALSE(files::MappedFile::map(*file, 1, ~std::uint64_t{0}));
  EXPECT_FALSE(files::MappedFile::map(*file, 0, 0));
}

}  // namespace
}  // namespace isoextract::test
