// Tests files with several volumes: NPY, NIfTI and NRRD. For every format, volume K must equal a file of that volume
// alone, bit for bit.
#include "support/hints.hpp"
#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

constexpr int kCount = 4;

// Samples of four volumes, all different.
template <class T>
T step_sample(int i, int j, int k, int volume) {
  return sample<T>(100 * volume % 251 + static_cast<int>(ramp<std::uint8_t>(i, j, k)) % 50);
}

// Calls put(i, j, k, t) in storage order.
template <class Put>
void volume_by_volume(const Put& put) {
  for (int t = 0; t < kCount; ++t) {
    for (int k = 0; k < kDims.z; ++k) {
      for (int j = 0; j < kDims.y; ++j) {
        for (int i = 0; i < kDims.x; ++i) put(i, j, k, t);
      }
    }
  }
}

template <class T>
std::string series_bytes(std::endian endian = std::endian::little) {
  std::string bytes;
  volume_by_volume([&](int i, int j, int k, int t) { bytes += pack(step_sample<T>(i, j, k, t), endian); });
  return bytes;
}

// Interleaved volumes, x before y before z.
template <class T>
std::string interleaved_bytes(std::endian endian = std::endian::little) {
  std::string bytes;
  for (int k = 0; k < kDims.z; ++k) {
    for (int j = 0; j < kDims.y; ++j) {
      for (int i = 0; i < kDims.x; ++i) {
        for (int t = 0; t < kCount; ++t) bytes += pack(step_sample<T>(i, j, k, t), endian);
      }
    }
  }
  return bytes;
}

// [t, z, y, x] in Fortran order: the first axis is the fastest.
template <class T>
std::string fortran_bytes(std::endian endian = std::endian::little) {
  std::string bytes;
  for (int i = 0; i < kDims.x; ++i) {
    for (int j = 0; j < kDims.y; ++j) {
      for (int k = 0; k < kDims.z; ++k) {
        for (int t = 0; t < kCount; ++t) bytes += pack(step_sample<T>(i, j, k, t), endian);
      }
    }
  }
  return bytes;
}

template <class T>
void expect_step(const field::ScalarField& field, int volume) {
  const auto& samples = std::get<field::DenseSamples>(field.samples);
  ASSERT_EQ(samples.type, field::sample_type_of<T>());
  ASSERT_EQ(samples.dims, kDims);
  for (int k = 0; k < kDims.z; ++k) {
    for (int j = 0; j < kDims.y; ++j) {
      for (int i = 0; i < kDims.x; ++i) {
        ASSERT_EQ(dense_value<T>(field, i, j, k), (step_sample<T>(i, j, k, volume)))
            << volume << ": " << i << ' ' << j << ' ' << k;
      }
    }
  }
}

volume_io::ReadOptions volume(std::int64_t k) {
  volume_io::ReadOptions options;
  options.volume = k;
  return options;
}

// Reads every volume by its number, without a number, and beyond the last.
template <class T>
void expect_series(const std::filesystem::path& path) {
  for (int t = 0; t < kCount; ++t) expect_step<T>(must_read(path, volume(t)), t);
  const Error none = refusal(path);
  EXPECT_EQ(none.code, ErrorCode::input);
  expect_in(none.message, "because the file has 4 volumes");
  EXPECT_EQ(none.hint, Hint(Remedy::choose, Setting::volume, "from 0 to 3"));
  for (const std::int64_t wrong : {std::int64_t{-1}, std::int64_t{4}, INT64_MAX, INT64_MIN}) {
    const Error error = refusal(path, volume(wrong));
    expect_in(error.message, "there is no volume " + std::to_string(wrong));
    EXPECT_TRUE(test::has_step(error.hint, Remedy::choose, Setting::volume));
    EXPECT_FALSE(volume_io::list_grids(path.string(), volume(wrong), Context()));
  }
  const auto grids = volume_io::list_grids(path.string(), {}, Context());
  ASSERT_TRUE(grids) << grids.error().message;
  ASSERT_EQ(grids->size(), 1U);
  EXPECT_EQ(grids->front().volumes, 4U);
  EXPECT_EQ(grids->front().voxels, 60U);
  EXPECT_EQ(grids->front().box, (field::IndexBox{{0, 0, 0}, {2, 3, 4}}));
  EXPECT_EQ(volume_io::count_volumes(path.string(), volume(99), Context()).value(), 4U);
}

std::string npy(const std::string& descr, const std::string& shape, const std::string& samples, bool fortran = false) {
  std::string text =
      "{'descr': '" + descr + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': " + shape + "}";
  while ((10 + text.size() + 1) % 64 != 0) text += ' ';
  text += '\n';
  return std::string("\x93NUMPY\1\0", 8) + pack(static_cast<std::uint16_t>(text.size())) + text + samples;
}

std::string nifti(const std::vector<std::int16_t>& dims, std::int16_t datatype, const std::string& samples) {
  std::string bytes(352, '\0');
  put(bytes, 0, 348);
  for (std::size_t i = 0; i < dims.size(); ++i) put(bytes, 40 + 2 * i, dims[i]);
  put(bytes, 70, datatype);
  for (std::size_t i = 0; i < 8; ++i) put(bytes, 76 + 4 * i, 1.0F);
  put(bytes, 108, 352.0F);
  bytes.replace(344, 3, "n+1");
  return bytes + samples;
}

std::string nrrd(const std::string& type, const std::string& fields, const std::string& samples) {
  return "NRRD0005\ntype: " + type + "\n" + fields + (samples.empty() ? "" : "\n" + samples);
}

constexpr const char* kSlowest = "dimension: 4\nsizes: 3 4 5 4\nkinds: domain domain domain time\n";
constexpr const char* kFastest = "dimension: 4\nsizes: 4 3 4 5\nkinds: list domain domain domain\n";
constexpr const char* kRawLittle = "encoding: raw\nendian: little\n";

template <class T>
class SeriesOf : public testing::Test {
 protected:
  TempFolder folder;
};
using SomeTypes = testing::Types<std::uint8_t, std::int16_t, float, double>;
TYPED_TEST_SUITE(SeriesOf, SomeTypes);

TYPED_TEST(SeriesOf, ReadsNpyInBothOrders) {
  for (const std::endian endian : {std::endian::little, std::endian::big}) {
    std::string type = endian == std::endian::big ? ">" : "<";
    type += std::is_same_v<TypeParam, std::uint8_t> ? 'u' : std::is_integral_v<TypeParam> ? 'i' : 'f';
    type += std::to_string(sizeof(TypeParam));
    write_bytes(this->folder / "c.npy", npy(type, "(4, 5, 4, 3)", series_bytes<TypeParam>(endian)));
    expect_series<TypeParam>(this->folder / "c.npy");
    write_bytes(this->folder / "f.npy", npy(type, "(4, 5, 4, 3)", fortran_bytes<TypeParam>(endian), true));
    expect_series<TypeParam>(this->folder / "f.npy");
  }
}

TYPED_TEST(SeriesOf, ReadsNrrdWithSlowestAndFastestSeries) {
  const std::string type = sizeof(TypeParam) == 1   ? "uint8"
                           : sizeof(TypeParam) == 2 ? "int16"
                           : sizeof(TypeParam) == 4 ? "float"
                                                    : "double";
  for (const std::endian endian : {std::endian::little, std::endian::big}) {
    const std::string order = endian == std::endian::big ? "endian: big\n" : "endian: little\n";
    for (const bool fastest : {false, true}) {
      const std::string samples = fastest ? interleaved_bytes<TypeParam>(endian) : series_bytes<TypeParam>(endian);
      const std::string fields = (fastest ? kFastest : kSlowest) + order;
      write_bytes(this->folder / "v.nrrd", nrrd(type, fields + "encoding: raw\n", samples));
      expect_series<TypeParam>(this->folder / "v.nrrd");
      write_bytes(this->folder / "z.nrrd", nrrd(type, fields + "encoding: gzip\n", gzip(samples)));
      expect_series<TypeParam>(this->folder / "z.nrrd");
    }
  }
}

TEST(Series, ReadsNifti) {
  const TempFolder folder;
  const std::string file = nifti({4, 3, 4, 5, 4, 1, 1, 1}, 4, series_bytes<std::int16_t>());
  write_bytes(folder / "v.nii", file);
  expect_series<std::int16_t>(folder / "v.nii");
  write_bytes(folder / "v.nii.gz", gzip(file));
  expect_series<std::int16_t>(folder / "v.nii.gz");
}

// More than one block, so that lanes continue correctly in the next block.
TEST(Series, ReadsLanesOfManyVolumes) {
  const TempFolder folder;
  constexpr int kVolumes = 301;
  constexpr glm::ivec3 kSize{50, 47, 31};
  std::string bytes;
  bytes.reserve(static_cast<std::size_t>(kVolumes) * 50 * 47 * 31 * 2);
  const auto value = [](int n, int t) { return static_cast<std::uint16_t>(n * 7 + t * 11); };
  for (int n = 0; n < kSize.x * kSize.y * kSize.z; ++n) {
    for (int t = 0; t < kVolumes; ++t) bytes += pack(value(n, t));
  }
  const std::string fields =
      "dimension: 4\nsizes: 301 50 47 31\nkinds: list domain domain domain\nendian: little\nencoding: ";
  write_bytes(folder / "raw.nrrd", nrrd("uint16", fields + "raw\n", bytes));
  write_bytes(folder / "packed.nrrd", nrrd("uint16", fields + "gzip\n", gzip(bytes)));
  for (const char* name : {"raw.nrrd", "packed.nrrd"}) {
    for (const int t : {0, 1, 150, 300}) {
      const field::ScalarField field = must_read(folder / name, volume(t));
      const auto* found = static_cast<const std::uint16_t*>(std::get<field::DenseSamples>(field.samples).data);
      for (int n = 0; n < kSize.x * kSize.y * kSize.z; ++n) ASSERT_EQ(found[n], value(n, t)) << name << ' ' << t;
    }
  }
}

TEST(Series, ReadsSeveralOrPartialVolumesPerFile) {
  const TempFolder folder;
  const std::string samples = series_bytes<std::uint8_t>();
  for (int part = 0; part < 4; ++part) {
    write_bytes(folder / ("one" + std::to_string(part)), samples.substr(static_cast<std::size_t>(60 * part), 60));
  }
  for (int part = 0; part < 2; ++part) {
    write_bytes(folder / ("two" + std::to_string(part)), samples.substr(static_cast<std::size_t>(120 * part), 120));
  }
  for (int part = 0; part < 20; ++part) {
    write_bytes(folder / ("slice" + std::to_string(part)), samples.substr(static_cast<std::size_t>(12 * part), 12));
  }
  const std::string fields = std::string(kSlowest) + "encoding: raw\n";
  write_bytes(folder / "one.nhdr", nrrd("uint8", fields + "data file: one%d 0 3 1\n", ""));
  expect_series<std::uint8_t>(folder / "one.nhdr");
  write_bytes(folder / "two.nhdr", nrrd("uint8", fields + "data file: two%d 0 1 1 4\n", ""));
  expect_series<std::uint8_t>(folder / "two.nhdr");
  write_bytes(folder / "slices.nhdr", nrrd("uint8", fields + "data file: slice%d 0 19 1 2\n", ""));
  expect_series<std::uint8_t>(folder / "slices.nhdr");
}

// Maps one volume; does not read the others.
TEST(Series, ReadsOnlyTheBytesOfItsVolume) {
  const TempFolder folder;
  write_bytes(folder / "v.npy", npy("<f4", "(4, 5, 4, 3)", series_bytes<float>()));
  const Context context = with_memory(100);
  const field::ScalarField field = must_read(folder / "v.npy", volume(2), context);
  EXPECT_TRUE(std::get<field::DenseSamples>(field.samples).file_backed);
  EXPECT_LT(context.counters().bytes_read.load(), 60 * sizeof(float) + 2048);
  expect_step<float>(field, 2);
}

TEST(Series, DecompressesNoFurtherThanItsVolume) {
  const TempFolder folder;
  std::string packed = gzip(series_bytes<std::uint8_t>().substr(0, 120));
  packed += gzip(series_bytes<std::uint8_t>().substr(120)).substr(0, 20);  // truncated in the third volume
  write_bytes(folder / "v.nrrd", nrrd("uint8", std::string(kSlowest) + "encoding: gzip\n", packed));
  expect_step<std::uint8_t>(must_read(folder / "v.nrrd", volume(0)), 0);
  EXPECT_EQ(refusal(folder / "v.nrrd", volume(3)).code, ErrorCode::input);
}

TEST(Series, NeedsTheMemoryOfOneVolume) {
  const TempFolder folder;
  const std::string file = nifti({4, 3, 4, 5, 4, 1, 1, 1}, 2, series_bytes<std::uint8_t>());
  write_bytes(folder / "v.nii.gz", gzip(file));
  const Context context = with_memory(60);
  const field::ScalarField field = must_read(folder / "v.nii.gz", volume(3), context);
  EXPECT_EQ(context.memory().reserved(), 60U);
  expect_step<std::uint8_t>(field, 3);
}

TEST(Series, NumbersASingleVolumeZero) {
  const TempFolder folder;
  const std::string one = ramp_bytes<std::uint8_t>();
  write_bytes(folder / "3.npy", npy("|u1", "(5, 4, 3)", one));
  write_bytes(folder / "4.npy", npy("|u1", "(1, 5, 4, 3)", one));
  write_bytes(folder / "v.nii", nifti({4, 3, 4, 5, 1, 1, 1, 1}, 2, one));
  write_bytes(folder / "v.nrrd", nrrd("uint8", "dimension: 3\nsizes: 3 4 5\nencoding: raw\n", one));
  for (const char* name : {"3.npy", "4.npy", "v.nii", "v.nrrd"}) {
    expect_ramp<std::uint8_t>(must_read(folder / name));
    expect_ramp<std::uint8_t>(must_read(folder / name, volume(0)));
    const Error error = refusal(folder / name, volume(1));
    expect_in(error.message, "there is no volume 1");
    EXPECT_EQ(error.hint, Hint(Remedy::leave_out, Setting::volume, "there is one volume in the file"));
    EXPECT_EQ(volume_io::count_volumes((folder / name).string(), {}, Context()).value(), 1U);
  }
}

TEST(Series, RejectsAChoiceForFormatsWithoutVolumes) {
  const auto field = volume_io::read_volume("demo:sphere?size=8", volume(0), Context());
  ASSERT_FALSE(field);
  EXPECT_EQ(field.error().code, ErrorCode::usage);
  EXPECT_EQ(field.error().hint, Hint(Remedy::leave_out, Setting::volume, "this format has no numbered volumes"));
  EXPECT_EQ(volume_io::count_volumes("demo:sphere?size=8", {}, Context()).value(), 1U);
  EXPECT_FALSE(volume_io::count_volumes("missing.npy", {}, Context()));
}

TEST(Series, RejectsWrongSizesBeforeAllocating) {
  const TempFolder folder;
  const std::string some = ramp_bytes<std::uint8_t>();
  const Context context = with_memory(1000);
  const auto refused = [&](const std::string& name, const std::string& bytes, const std::string& message) {
    SCOPED_TRACE(name);
    write_bytes(folder / name, bytes);
    const Error error = refusal(folder / name, volume(0), context);
    EXPECT_EQ(error.code, ErrorCode::input);
    expect_in(error.message, message);
    EXPECT_EQ(context.memory().reserved(), 0U);
  };
  refused("short.nii", nifti({4, 3, 4, 5, 32767, 1, 1, 1}, 2, some), "in each of 32767 volumes");
  refused("negative.nii", nifti({4, 3, 4, 5, -1, 1, 1, 1}, 2, some), "dim[4] = -1");
  refused("none.nii", nifti({4, 3, 4, 5, 0, 1, 1, 1}, 2, some), "dim[4] = 0");
  refused("five.nii", nifti({5, 3, 4, 5, 1, 2, 1, 1}, 2, some + some), "found 2 components");
  refused("packed.nii.gz", gzip(nifti({4, 3, 4, 5, 32767, 1, 1, 1}, 2, some)), "cannot decompress");
  refused("over.npy", npy("<f8", "(18446744073709551615, 5, 4, 3)", some), "volumes of 3x4x5 f64 samples");
  refused("wraps.npy", npy("<f8", "(4611686018427387904, 4, 4, 4)", some), "volumes of 4x4x4 f64 samples");
  refused("none.npy", npy("|u1", "(0, 5, 4, 3)", some), "found 0");
  refused("cut.npy", npy("|u1", "(4, 5, 4, 3)", some), "in each of 4 volumes");
  refused("long.npy", npy("|u1", "(4, 5, 4, 3)", series_bytes<std::uint8_t>() + "x"), "found 1 more");
  refused("five.npy", npy("|u1", "(2, 2, 5, 4, 3)", series_bytes<std::uint8_t>()), "found shape (2, 2, 5, 4, 3)");
  refused("lanes.npy", npy("|u1", "(99999999, 5, 4, 3)", some, true), "in each of 99999999 volumes");
  refused("over.nrrd",
          nrrd("double",
               "dimension: 4\nsizes: 3 4 5 4611686018427387904\nkinds: domain domain domain "
               "list\nendian: little\nencoding: raw\n",
               some),
          "over.nrrd");
}

TEST(Series, RejectsNrrdAxesThatAreNotSeries) {
  const TempFolder folder;
  const std::string samples = series_bytes<std::uint8_t>();
  const auto refused = [&](const std::string& fields, const std::string& message) {
    write_bytes(folder / "v.nrrd", nrrd("uint8", fields + "encoding: raw\n", samples));
    expect_in(refusal(folder / "v.nrrd", volume(0)).message, message);
  };
  refused("dimension: 4\nsizes: 3 4 5 4\nkinds: domain domain domain vector\n", "found 4 components");
  refused("dimension: 4\nsizes: 4 3 4 5\nkinds: RGBA-color domain domain domain\n", "found 4 components");
  refused("dimension: 5\nsizes: 2 3 4 5 2\nkinds: list domain domain domain time\n", "axis 4 (2 values, kind time)");
  refused("dimension: 4\nsizes: 3 4 4 5\nkinds: domain list domain domain\n", "between them");
  refused("dimension: 3\nsizes: 12 5 4\nkinds: domain domain time\n", "expected three spatial axes, found 2");
}

}  // namespace
}  // namespace isoextract::test
