// Tests files with several components per sample. For every format and storage order, component C of volume K must
// equal a file of those numbers alone.
#include "support/hints.hpp"
#include "unit/volume_io/npz_files.hpp"

namespace isoextract::test {
namespace {

constexpr int kComponents = 3;
constexpr int kVolumes = 2;

// Returns a different number for each argument.
int number(int i, int j, int k, int volume, int component) {
  return ramp<std::int16_t>(i, j, k) + 1000 * volume + 3000 * component;
}

// Stores samples by their axes, the fastest first: x, y, z, t (volumes) and c (components).
std::string stored(const std::string& axes, std::endian endian = std::endian::little) {
  std::array<int, 5> at{};
  const std::string letters = "xyztc";
  const std::array<int, 5> sizes{kDims.x, kDims.y, kDims.z, kVolumes, kComponents};
  std::string bytes;
  const std::function<void(std::size_t)> put_axis = [&](std::size_t left) {
    if (left == 0) {
      bytes += pack(static_cast<std::int16_t>(number(at[0], at[1], at[2], at[3], at[4])), endian);
      return;
    }
    const std::size_t axis = letters.find(axes[left - 1]);
    for (at[axis] = 0; at[axis] < sizes[axis]; ++at[axis]) put_axis(left - 1);
    at[axis] = 0;
  };
  put_axis(axes.size());
  return bytes;
}

volume_io::ReadOptions component(std::optional<std::int64_t> number) {
  volume_io::ReadOptions options;
  options.component = volume_io::ComponentChoice{number};
  return options;
}

void expect_components(const std::filesystem::path& path, int volumes) {
  for (int volume = 0; volume < volumes; ++volume) {
    std::array<field::ScalarField, kComponents> fields;
    for (int c = 0; c < kComponents; ++c) {
      volume_io::ReadOptions options = component(c);
      if (volumes > 1) options.volume = volume;
      fields[static_cast<std::size_t>(c)] = must_read(path, options);
      const field::ScalarField& field = fields[static_cast<std::size_t>(c)];
      ASSERT_EQ(field.type(), field::SampleType::i16);
      ASSERT_EQ(field.extents(), (field::IndexBox{{0, 0, 0}, kDims - 1}));
      for (int k = 0; k < kDims.z; ++k) {
        for (int j = 0; j < kDims.y; ++j) {
          for (int i = 0; i < kDims.x; ++i) {
            ASSERT_EQ(dense_value<std::int16_t>(field, i, j, k), number(i, j, k, volume, c))
                << volume << ' ' << c << ": " << i << ' ' << j << ' ' << k;
          }
        }
      }
    }
    volume_io::ReadOptions options = component(std::nullopt);
    if (volumes > 1) options.volume = volume;
    const field::ScalarField length = must_read(path, options);
    ASSERT_EQ(length.type(), field::SampleType::f32);
    for (const glm::ivec3& p : {glm::ivec3(0), glm::ivec3(1, 2, 3), kDims - 1}) {
      double sum = 0;
      for (int c = 0; c < kComponents; ++c) sum += std::pow(number(p.x, p.y, p.z, volume, c), 2);
      EXPECT_NEAR(dense_value<float>(length, p.x, p.y, p.z), std::sqrt(sum), 1e-6 * std::sqrt(sum));
    }
  }
  volume_io::ReadOptions first;
  if (volumes > 1) first.volume = 0;
  const Error none = refusal(path, first);
  expect_in(none.message, "expected one number per sample, found 3 components");
  expect_in(test::text_of(none.hint), "from 0 to 2");
  for (const std::int64_t wrong : {std::int64_t{-1}, std::int64_t{3}, INT64_MAX}) {
    first.component = volume_io::ComponentChoice{wrong};
    expect_in(refusal(path, first).message, "there is no component " + std::to_string(wrong));
  }
}

std::string nrrd_of(const std::string& sizes, const std::string& kinds, const std::string& samples) {
  const auto axes = std::count(sizes.begin(), sizes.end(), ' ') + 1;
  return "NRRD0005\ntype: int16\nendian: little\nencoding: raw\ndimension: " + std::to_string(axes) +
         "\nsizes: " + sizes + "\nkinds: " + kinds + "\n\n" + samples;
}

TEST(Components, AreReadFromNrrdWithAnyAxisOrder) {
  const TempFolder folder;
  const std::string domain = "domain domain domain";
  const auto check = [&](const std::string& sizes, const std::string& kinds, const std::string& axes) {
    SCOPED_TRACE(axes);
    write_bytes(folder / "v.nrrd", nrrd_of(sizes, kinds, stored(axes)));
    expect_components(folder / "v.nrrd", axes.size() > 4 ? kVolumes : 1);
  };
  check("3 3 4 5", "vector " + domain, "cxyz");
  check("3 4 5 3", domain + " 3-color", "xyzc");
  check("3 3 4 5 2", "3-vector " + domain + " time", "cxyzt");
  check("2 3 4 5 3", "list " + domain + " vector", "txyzc");
  check("3 2 3 4 5", "vector list " + domain, "ctxyz");
  check("2 3 3 4 5", "list vector " + domain, "tcxyz");
  check("3 4 5 3 2", domain + " vector time", "xyzct");
  check("3 4 5 2 3", domain + " time vector", "xyztc");
}

TEST(Components, AreReadFromNrrdInGzipAndSeparateFiles) {
  const TempFolder folder;
  std::string header = nrrd_of("3 3 4 5", "vector domain domain domain", "");
  header.replace(header.find("raw"), 3, "gzip");
  write_bytes(folder / "v.nrrd", header + gzip(stored("cxyz")));
  expect_components(folder / "v.nrrd", 1);
  const std::string all = stored("xyzc");
  for (int c = 0; c < kComponents; ++c) {
    write_bytes(folder / ("c" + std::to_string(c) + ".raw"), all.substr(static_cast<std::size_t>(120 * c), 120));
  }
  std::string detached = nrrd_of("3 4 5 3", "domain domain domain vector", "");
  detached.insert(detached.size() - 1, "data file: c%d.raw 0 2 1\n");
  write_bytes(folder / "v.nhdr", detached);
  expect_components(folder / "v.nhdr", 1);
}

std::string nifti_of(const std::vector<std::int16_t>& dims, std::int16_t datatype, const std::string& samples,
                     float slope = 0, float intercept = 0) {
  std::string bytes(352, '\0');
  put(bytes, 0, 348);
  for (std::size_t i = 0; i < dims.size(); ++i) put(bytes, 40 + 2 * i, dims[i]);
  put(bytes, 70, datatype);
  for (std::size_t i = 0; i < 8; ++i) put(bytes, 76 + 4 * i, 1.0F);
  put(bytes, 108, 352.0F);
  put(bytes, 112, slope);
  put(bytes, 116, intercept);
  bytes.replace(344, 3, "n+1");
  return bytes + samples;
}

TEST(Components, AreReadFromNiftiAfterTheVolumes) {
  const TempFolder folder;
  write_bytes(folder / "v.nii", nifti_of({5, 3, 4, 5, 1, 3}, 4, stored("xyzc")));
  expect_components(folder / "v.nii", 1);
  write_bytes(folder / "v.nii", nifti_of({5, 3, 4, 5, 2, 3}, 4, stored("xyztc")));
  expect_components(folder / "v.nii", kVolumes);
  write_bytes(folder / "v.nii.gz", gzip(nifti_of({6, 3, 4, 5, 2, 1, 3}, 4, stored("xyztc"))));
  expect_components(folder / "v.nii.gz", kVolumes);
}

TEST(Components, AreReadFromNiftiColorsAndComplexNumbers) {
  const TempFolder folder;
  std::string colors;
  std::string complexes;
  for (int i = 0; i < 60; ++i) {
    for (int c = 0; c < 3; ++c) colors += static_cast<char>(4 * i + c);
    complexes += pack(static_cast<float>(3 * i)) + pack(static_cast<float>(-4 * i));
  }
  // The standard does not scale colors.
  write_bytes(folder / "c.nii", nifti_of({3, 3, 4, 5}, 128, colors, 2, 1));
  const field::ScalarField green = must_read(folder / "c.nii", component(1));
  EXPECT_EQ(dense_value<std::uint8_t>(green, 2, 3, 4), 237);
  EXPECT_TRUE(green.scale.is_identity());
  write_bytes(folder / "z.nii", nifti_of({3, 3, 4, 5}, 32, complexes));
  EXPECT_EQ(dense_value<float>(must_read(folder / "z.nii", component(1)), 2, 3, 4), -236);
  EXPECT_EQ(dense_value<float>(must_read(folder / "z.nii", component(std::nullopt)), 2, 3, 4), 295);
}

TEST(Components, HaveLengthsOfScaledValuesAndKeepNan) {
  const TempFolder folder;
  std::string bytes;
  for (int i = 0; i < 60; ++i) bytes += pack(static_cast<std::int16_t>(i));
  write_bytes(folder / "v.nii", nifti_of({5, 3, 4, 5, 1, 3}, 4, bytes + bytes + bytes, 2, -1));
  const field::ScalarField field = must_read(folder / "v.nii", component(std::nullopt));
  EXPECT_TRUE(field.scale.is_identity());
  EXPECT_FLOAT_EQ(dense_value<float>(field, 0, 0, 0), static_cast<float>(std::sqrt(3.0)));
  EXPECT_FLOAT_EQ(dense_value<float>(field, 1, 1, 0), static_cast<float>(7 * std::sqrt(3.0)));

  const float inf = std::numeric_limits<float>::infinity();
  const auto nan = static_cast<float>(kNaN);
  const std::vector<glm::vec2> vectors{{inf, nan}, {nan, inf}, {3e38F, 3e38F}, {-inf, 1}, {0, 0}, {1, nan}};
  std::string pairs;
  for (const glm::vec2& v : vectors) pairs += pack(v.x) + pack(v.y);
  write_bytes(folder / "v.npy", npy_array("<f4", "(1, 2, 3, 2)", pairs));
  const field::ScalarField length = must_read(folder / "v.npy", component(std::nullopt));
  EXPECT_TRUE(std::isnan(dense_value<float>(length, 0, 0, 0)));
  EXPECT_TRUE(std::isnan(dense_value<float>(length, 1, 0, 0)));
  EXPECT_TRUE(std::isinf(dense_value<float>(length, 2, 0, 0)));  // of integers that float cannot represent
  EXPECT_EQ(dense_value<float>(length, 0, 1, 0), inf);
  EXPECT_EQ(dense_value<float>(length, 1, 1, 0), 0);
  EXPECT_TRUE(std::isnan(dense_value<float>(length, 2, 1, 0)));
}

TEST(Components, AreReadFromNumpyInBothOrders) {
  const TempFolder folder;
  const auto check = [&](const std::string& shape, const std::string& axes, bool fortran, int volumes) {
    SCOPED_TRACE(axes);
    for (const std::endian endian : {std::endian::little, std::endian::big}) {
      write_bytes(folder / "v.npy",
                  npy_array(endian == std::endian::big ? ">i2" : "<i2", shape, stored(axes, endian), fortran));
      for (int volume = 0; volume < volumes; ++volume) {
        for (int c = 0; c < kComponents; ++c) {
          volume_io::ReadOptions options = component(c);
          if (volumes > 1) options.volume = volume;
          const field::ScalarField field = must_read(folder / "v.npy", options);
          for (const glm::ivec3& p : {glm::ivec3(0), glm::ivec3(1, 2, 3), kDims - 1}) {
            EXPECT_EQ(dense_value<std::int16_t>(field, p.x, p.y, p.z), number(p.x, p.y, p.z, volume, c));
          }
        }
      }
    }
  };
  check("(5, 4, 3, 3)", "cxyz", false, 1);
  check("(2, 5, 4, 3, 3)", "cxyzt", false, kVolumes);
  check("(5, 4, 3, 3)", "zyxc", true, 1);
  check("(2, 5, 4, 3, 3)", "tzyxc", true, kVolumes);
}

TEST(Components, RequireAChoiceForNumpy) {
  const TempFolder folder;
  write_bytes(folder / "v.npy", npy_array("|u1", "(6, 6, 6, 3)", std::string(648, 'x')));
  const Error error = refusal(folder / "v.npy");
  expect_in(error.message, "because the file has 6 volumes");
  expect_in(test::text_of(error.hint),
            "0 to 2, or length, if the last axis (length 3) holds the components of a vector");
  write_bytes(folder / "v.npy", npy_array("|u1", "(2, 6, 6, 6, 3)", std::string(1296, 'x')));
  expect_in(test::text_of(refusal(folder / "v.npy").hint), "if the last axis (length 3) holds the components");
  write_bytes(folder / "v.npy", npy_array("|u1", "(6, 6, 6)", std::string(216, 'x')));
  expect_in(refusal(folder / "v.npy", component(1)).message, "expected several components per sample, found one");
  must_read(folder / "v.npy", component(0));
  write_bytes(folder / "v.npy", npy_array("<c16", "(1, 1, 2)", pack(3.0) + pack(4.0) + pack(6.0) + pack(-8.0)));
  expect_in(refusal(folder / "v.npy").message, "found 2 components");
  EXPECT_EQ(dense_value<double>(must_read(folder / "v.npy", component(1)), 1, 0, 0), -8);
  EXPECT_EQ(dense_value<double>(must_read(folder / "v.npy", component(std::nullopt)), 1, 0, 0), 10);
}

TEST(Components, AreListedAndNeedTheMemoryOfOne) {
  const TempFolder folder;
  write_bytes(folder / "v.nii", nifti_of({5, 32, 32, 32, 1, 3}, 4, std::string(196608, 'x')));
  const auto grids = volume_io::list_grids((folder / "v.nii").string(), {}, Context());
  ASSERT_TRUE(grids) << grids.error().message;
  EXPECT_EQ(grids->front().components, 3U);
  EXPECT_EQ(grids->front().voxels, 32768U);
  EXPECT_TRUE(grids->front().scalar);
  // The component is mapped; a length needs 4 bytes per sample.
  EXPECT_TRUE(volume_io::read_volume((folder / "v.nii").string(), component(2), with_memory(100)));
  EXPECT_TRUE(volume_io::read_volume((folder / "v.nii").string(), component(std::nullopt), with_memory(131072)));
  expect_in(refusal(folder / "v.nii", component(std::nullopt), with_memory(131071)).message, "lengths of 32x32x32");
  volume_io::ReadOptions options = component(0);
  EXPECT_EQ(volume_io::read_volume("demo:sphere?size=8", options, Context()).error().code, ErrorCode::usage);
}

}  // namespace
}  // namespace isoextract::test
