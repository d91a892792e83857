#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

// Builds a header field by field, at the offsets of the two standards.
struct NiftiFile {
  int version = 1;
  std::endian endian = std::endian::little;
  std::string bytes;

  explicit NiftiFile(int which = 1, std::endian order = std::endian::little, bool pair = false)
      : version(which), endian(order) {
    bytes.assign(version == 1 ? 352 : 544, '\0');
    put(bytes, 0, version == 1 ? 348 : 540, endian);
    if (version == 1) {
      bytes.replace(344, 4, std::string(pair ? "ni1" : "n+1") + '\0');
    } else {
      bytes.replace(4, 8, std::string(pair ? "ni2" : "n+2") + std::string("\0\r\n\032\n", 5));
    }
    dims({3, 3, 4, 5, 1, 1, 1, 1});
    type(2);
    pixdim({1, 1, 1, 1, 0, 0, 0, 0});
    offset(pair ? 0 : static_cast<double>(bytes.size()));
  }

  NiftiFile& real(std::size_t at1, std::size_t at2, double value) {
    if (version == 1) put(bytes, at1, static_cast<float>(value), endian);
    if (version == 2) put(bytes, at2, value, endian);
    return *this;
  }
  NiftiFile& code(std::size_t at1, std::size_t at2, int value) {
    if (version == 1) put(bytes, at1, static_cast<std::int16_t>(value), endian);
    if (version == 2) put(bytes, at2, value, endian);
    return *this;
  }
  NiftiFile& dims(const std::vector<std::int64_t>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (version == 1) put(bytes, 40 + 2 * i, static_cast<std::int16_t>(values[i]), endian);
      if (version == 2) put(bytes, 16 + 8 * i, values[i], endian);
    }
    return *this;
  }
  NiftiFile& type(int value) {
    put(bytes, version == 1 ? 70 : 12, static_cast<std::int16_t>(value), endian);
    return *this;
  }
  NiftiFile& pixdim(const std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) real(76 + 4 * i, 104 + 8 * i, values[i]);
    return *this;
  }
  NiftiFile& offset(double value) {
    if (version == 1) put(bytes, 108, static_cast<float>(value), endian);
    if (version == 2) put(bytes, 168, static_cast<std::int64_t>(value), endian);
    return *this;
  }
  NiftiFile& scale(double slope, double intercept) { return real(112, 176, slope).real(116, 184, intercept); }
  NiftiFile& sform(const std::vector<double>& rows, int form = 1) {
    for (std::size_t i = 0; i < 12; ++i) real(280 + 4 * i, 400 + 8 * i, rows[i]);
    return code(254, 348, form);
  }
  NiftiFile& qform(const std::vector<double>& quaternion, const std::vector<double>& origin) {
    for (std::size_t i = 0; i < 3; ++i) real(256 + 4 * i, 352 + 8 * i, quaternion[i]);
    for (std::size_t i = 0; i < 3; ++i) real(268 + 4 * i, 376 + 8 * i, origin[i]);
    return code(252, 344, 1);
  }
};

const std::string kSamples = ramp_bytes<std::uint8_t>();

field::ScalarField read_nifti(const std::string& bytes, const std::string& name = "v.nii") {
  const TempFolder folder;
  write_bytes(folder / name, bytes);
  return must_read(folder / name);
}

template <class T>
constexpr int nifti_code() {
  if constexpr (std::is_same_v<T, std::uint8_t>) return 2;
  if constexpr (std::is_same_v<T, std::int16_t>) return 4;
  if constexpr (std::is_same_v<T, std::int32_t>) return 8;
  if constexpr (std::is_same_v<T, float>) return 16;
  if constexpr (std::is_same_v<T, double>) return 64;
  if constexpr (std::is_same_v<T, std::int8_t>) return 256;
  if constexpr (std::is_same_v<T, std::uint16_t>) return 512;
  if constexpr (std::is_same_v<T, std::uint32_t>) return 768;
}

template <class T>
class NiftiReader : public testing::Test {};
using AllTypes =
    testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, float, double>;
TYPED_TEST_SUITE(NiftiReader, AllTypes);

TYPED_TEST(NiftiReader, ReadsBothVersionsAndByteOrdersPlainAndGzip) {
  for (const int version : {1, 2}) {
    for (const std::endian endian : {std::endian::little, std::endian::big}) {
      const std::string file =
          NiftiFile(version, endian).type(nifti_code<TypeParam>()).bytes + ramp_bytes<TypeParam>(endian);
      const field::ScalarField plain = read_nifti(file);
      expect_ramp<TypeParam>(plain);
      EXPECT_EQ(plain.format, version == 1 ? "NIfTI-1" : "NIfTI-2");
      expect_ramp<TypeParam>(read_nifti(gzip(file), "v.nii.gz"));
    }
  }
}

TEST(NiftiReaderData, NamesTheVolumeByItsStem) {
  const std::string file = NiftiFile().bytes + kSamples;
  EXPECT_EQ(read_nifti(gzip(file), "brain.nii.gz").name, "brain");
  EXPECT_EQ(read_nifti(file, "brain.nii").name, "brain");
  // Detects the content under any name.
  EXPECT_TRUE(has_note(read_nifti(gzip(file), "brain.raw"), "read as nifti"));
}

TEST(NiftiReaderData, StartsAtVoxOffset) {
  expect_ramp<std::uint8_t>(read_nifti(NiftiFile(1).offset(368).bytes + std::string(16, 'x') + kSamples));
  expect_ramp<std::uint8_t>(read_nifti(NiftiFile(2).offset(560).bytes + std::string(16, 'x') + kSamples));
  expect_ramp<std::uint8_t>(
      read_nifti(gzip(NiftiFile(1).offset(368).bytes + std::string(16, 'x') + kSamples), "v.nii.gz"));
  EXPECT_TRUE(has_note(read_nifti(NiftiFile().bytes + kSamples + "abc"), "3 bytes after the samples"));
}

TEST(NiftiReaderData, KeepsNanAndInfiniteSamples) {
  std::string samples = ramp_bytes<float>();
  put(samples, 4, std::nanf(""));
  put(samples, 8, HUGE_VALF);
  const field::ScalarField field = read_nifti(NiftiFile().type(16).bytes + samples);
  EXPECT_TRUE(std::isnan(dense_value<float>(field, 1, 0, 0)));
  EXPECT_EQ(dense_value<float>(field, 2, 0, 0), HUGE_VALF);
}

TEST(NiftiReaderData, ReadsPairsByEitherName) {
  for (const int version : {1, 2}) {
    for (const auto& [header, image] : std::vector<std::pair<std::string, std::string>>{
             {"v.hdr", "v.img"}, {"v.hdr", "v.img.gz"}, {"v.hdr.gz", "v.img.gz"}, {"v.hdr.gz", "v.img"}}) {
      SCOPED_TRACE(header + " " + image);
      const TempFolder folder;
      const std::string header_bytes = NiftiFile(version, std::endian::big, true).offset(2).bytes;
      const std::string image_bytes = "ab" + kSamples;
      write_bytes(folder / header, header.ends_with(".gz") ? gzip(header_bytes) : header_bytes);
      write_bytes(folder / image, image.ends_with(".gz") ? gzip(image_bytes) : image_bytes);
      expect_ramp<std::uint8_t>(must_read(folder / header));
      expect_ramp<std::uint8_t>(must_read(folder / image));
      std::filesystem::remove(folder / image);
      expect_in(refusal(folder / header).message, "there is no v.img or v.img.gz in its folder");
      write_bytes(folder / image, image_bytes);
      std::filesystem::remove(folder / header);
      EXPECT_FALSE(volume_io::read_volume((folder / image).string(), {}, Context()));
    }
  }
}

TEST(NiftiReaderData, ReadsPairsInUpperCase) {
  const TempFolder folder;
  write_bytes(folder / "V.HDR", NiftiFile(1, std::endian::little, true).bytes);
  write_bytes(folder / "V.IMG", kSamples);
  expect_ramp<std::uint8_t>(must_read(folder / "V.HDR"));
  expect_ramp<std::uint8_t>(must_read(folder / "V.IMG"));
}

TEST(NiftiReaderData, RejectsAnImageElsewhere) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "in");
  write_bytes(folder / "out.img", kSamples);
  write_bytes(folder / "in" / "v.hdr", NiftiFile(1, std::endian::little, true).bytes);
  std::filesystem::create_symlink(folder / "out.img", folder / "in" / "v.img");
  expect_in(refusal(folder / "in" / "v.hdr").message, "outside the folder of the header");
}

TEST(NiftiReaderPlace, ReadsSformRows) {
  for (const int version : {1, 2}) {
    for (const std::endian endian : {std::endian::little, std::endian::big}) {
      NiftiFile file(version, endian);
      file.sform({0, -2, 0.5, 10, 3, 0, 0, 20, 0, 0, 4, 30}).qform({0, 0, 0}, {-1, -1, -1});
      const field::ScalarField field = read_nifti(file.bytes + kSamples);
      expect_near(field.index_to_world({0, 0, 0}), {10, 20, 30});
      expect_near(field.index_to_world({1, 2, 3}), {10 - 4 + 1.5, 20 + 3, 30 + 12});
      EXPECT_EQ(field.world_space, "RAS+ (NIfTI)");
      EXPECT_TRUE(field.notes.empty());
    }
  }
}

TEST(NiftiReaderPlace, ReadsQformQuaternionAndSign) {
  const double half = std::sqrt(0.5);
  for (const double qfac : {1.0, -1.0, 0.0}) {
    for (const int version : {1, 2}) {
      // A quarter turn about z: x steps go to +y, y steps to -x; qfac reverses the third axis.
      NiftiFile file(version);
      file.pixdim({qfac, 2, 3, 4, 0, 0, 0, 0}).qform({0, 0, half}, {10, 20, 30});
      const field::ScalarField field = read_nifti(file.bytes + kSamples);
      expect_near(field.index_to_world({1, 0, 0}), {10, 22, 30}, 1e-6);
      expect_near(field.index_to_world({0, 1, 0}), {7, 20, 30}, 1e-6);
      expect_near(field.index_to_world({0, 0, 1}), {10, 20, qfac < 0 ? 26.0 : 34.0}, 1e-6);
    }
  }
}

TEST(NiftiReaderPlace, NotesSpacingsAlone) {
  const field::ScalarField field = read_nifti(NiftiFile().pixdim({1, 2, 3, 4, 0, 0, 0, 0}).bytes + kSamples);
  expect_near(field.index_to_world({1, 1, 1}), {2, 3, 4});
  EXPECT_TRUE(has_note(field, "states spacings but no orientation"));
  // A given spacing replaces the axes; a given origin does not.
  const TempFolder folder;
  write_bytes(folder / "v.nii", NiftiFile().pixdim({1, 2, 3, 4, 0, 0, 0, 0}).bytes + kSamples);
  volume_io::ReadOptions options;
  options.origin = glm::dvec3(1, 1, 1);
  EXPECT_TRUE(has_note(must_read(folder / "v.nii", options), "states spacings but no orientation"));
  options.spacing = glm::dvec3(2, 2, 2);
  EXPECT_TRUE(must_read(folder / "v.nii", options).notes.empty());
}

TEST(NiftiReaderPlace, RequiresASpacingForInvalidFrames) {
  const double nan = std::nan("");
  for (const std::string& header :
       {NiftiFile().sform({nan, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}).bytes,
        NiftiFile().sform({1, 0, 0, HUGE_VAL, 0, 1, 0, 0, 0, 0, 1, 0}).bytes,
        NiftiFile(2).sform({1, 2, 0, 0, 2, 4, 0, 0, 0, 0, 1, 0}).bytes,
        NiftiFile().sform({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}).bytes, NiftiFile().pixdim({1, 0, 1, 1}).bytes,
        NiftiFile().pixdim({1, 1, nan, 1}).bytes, NiftiFile().pixdim({1, 1, 1, -1}).qform({0, 0, 0}, {0, 0, 0}).bytes,
        NiftiFile().qform({nan, 0, 0}, {0, 0, 0}).bytes, NiftiFile(2).qform({0, 0, 0}, {0, nan, 0}).bytes}) {
    const TempFolder folder;
    write_bytes(folder / "v.nii", header + kSamples);
    const Error error = refusal(folder / "v.nii");
    EXPECT_EQ(error.code, ErrorCode::input);
    EXPECT_EQ(error.hint, Hint(Remedy::give, Setting::spacing_and_origin));
    volume_io::ReadOptions options;
    options.spacing = glm::dvec3(2, 2, 2);
    options.origin = glm::dvec3(0, 0, 0);
    expect_near(must_read(folder / "v.nii", options).index_to_world({1, 1, 1}), {2, 2, 2});
  }
}

TEST(NiftiReaderScale, AppliesSlopeAndIntercept) {
  const auto scale = [](double slope, double intercept) {
    return read_nifti(NiftiFile(2).scale(slope, intercept).bytes + kSamples).scale;
  };
  EXPECT_EQ(scale(2, -3)(10), 17);
  EXPECT_TRUE(scale(0, 5).is_identity());
  EXPECT_TRUE(scale(1, 0).is_identity());
  EXPECT_EQ(scale(1, 5)(10), 15);
  const double nan = std::nan("");
  const field::ScalarField no_slope = read_nifti(NiftiFile().scale(nan, nan).bytes + kSamples);
  EXPECT_TRUE(no_slope.scale.is_identity());
  EXPECT_TRUE(has_note(no_slope, "scl_slope"));
  const field::ScalarField no_intercept = read_nifti(NiftiFile().scale(2, nan).bytes + kSamples);
  EXPECT_EQ(no_intercept.scale(10), 20);
  EXPECT_TRUE(has_note(no_intercept, "scl_inter"));
}

TEST(NiftiReaderBad, NamesUnsupportedTypesAndShapes) {
  const std::string samples(2000, 'x');
  const auto typed = [&](int type) { return NiftiFile().type(type).bytes + samples; };
  expect_all_refused(
      "v.nii", {{"binary", typed(1), "datatype 1"},
                {"none", typed(0), "datatype 0"},
                {"unknown", typed(77), "datatype 77"},
                {"complex", typed(32), "found 2 components"},
                {"color", typed(128), "found 3 components"},
                {"color and alpha", typed(2304), "found 4 components"},
                {"vectors of colors", NiftiFile().dims({5, 3, 4, 5, 1, 2}).type(128).bytes + samples, "RGB24"},
                {"more of them than numbers", NiftiFile(2).dims({7, 3, 4, 5, 1, 1L << 40, 1L << 40, 2}).bytes + samples,
                 "volumes of"},
                {"complex128", typed(1792), "found 2 components"},
                {"long double", typed(1536), "FLOAT128"},
                {"series", NiftiFile().dims({4, 3, 4, 5, 7}).bytes + samples, "because the file has 7 volumes"},
                {"vectors", NiftiFile(2).dims({5, 3, 4, 5, 1, 3}).bytes + samples, "found 3 components"},
                {"image", NiftiFile().dims({2, 3, 4}).bytes + samples, "expected 3 to 7 axes (dim[0]), found 2"}});
  expect_ramp<std::uint8_t>(read_nifti(NiftiFile().dims({4, 3, 4, 5, 1}).bytes + kSamples));
}

TEST(NiftiReaderBad, RejectsMalformedFiles) {
  const std::string header = NiftiFile().bytes;
  const std::string header2 = NiftiFile(2).bytes;
  std::string analyze = header;
  analyze.replace(344, 4, std::string(4, '\0'));
  std::string odd_size = header;
  put(odd_size, 0, 347);
  const auto sized = [&](const std::vector<std::int64_t>& dims, int version = 1) {
    return NiftiFile(version).dims(dims).bytes + kSamples;
  };
  expect_all_refused(
      "v.nii", {{"empty file", "", "empty"},
                {"text", "this is some text\n", "not a NIfTI file"},
                {"cut header", header.substr(0, 347), "not a NIfTI file"},
                {"cut header 2", header2.substr(0, 539), "not a NIfTI file"},
                {"no magic", analyze + kSamples, "not a NIfTI file"},
                {"other size of header", odd_size + kSamples, "not a NIfTI file"},
                {"no samples", header, "found 0"},
                {"cut samples", header + kSamples.substr(1), "found 59"},
                {"no axes", sized({0, 3, 4, 5}), "dim[0]"},
                {"negative axes", sized({-1, 3, 4, 5}), "dim[0]"},
                {"eight axes", sized({8, 3, 4, 5}), "dim[0]"},
                {"zero size", sized({3, 3, 0, 5}), "dim[2] = 0"},
                {"negative size", sized({3, 3, 4, -5}), "dim[3] = -5"},
                {"negative size 2", sized({3, -3, 4, 5}, 2), "dim[1] = -3"},
                {"zero volumes", sized({4, 3, 4, 5, 0}), "dim[4] = 0"},
                {"large volume", sized({3, 32767, 32767, 32767}), "from byte 352 on, found 60"},
                {"huge size", sized({3, std::int64_t{1} << 40, 4, 5}, 2), "1099511627776x4x5"},
                {"huge volume", sized({3, 2000000000, 2000000000, 2000000000}, 2), "2000000000x2000000000x2000000000"},
                {"offset in the header", NiftiFile().offset(348).bytes + kSamples, "vox_offset 348"},
                {"no offset", NiftiFile(2).offset(0).bytes + kSamples, "vox_offset 0"},
                {"negative offset", NiftiFile().offset(-352).bytes + kSamples, "vox_offset -352"},
                {"offset between bytes", NiftiFile().offset(352.5).bytes + kSamples, "vox_offset 352.5"},
                {"offset not a number", NiftiFile().offset(std::nan("")).bytes + kSamples, "vox_offset nan"},
                {"infinite offset", NiftiFile().offset(HUGE_VAL).bytes + kSamples, "vox_offset inf"},
                {"offset behind the end", NiftiFile().offset(1e15).bytes + kSamples, "found 0"}});
}

TEST(NiftiReaderBad, RejectsDamagedGzip) {
  const std::string packed = gzip(NiftiFile().bytes + kSamples);
  std::string bad_checksum = packed;
  bad_checksum[bad_checksum.size() - 6] = static_cast<char>(bad_checksum[bad_checksum.size() - 6] ^ 1);
  expect_all_refused(
      "v.nii.gz", {{"text", "this is not gzip data", "not a NIfTI file"},
                   {"header of gzip only", packed.substr(0, 12), "not a NIfTI file"},
                   {"cut", packed.substr(0, packed.size() - 3), "damaged or cut off"},
                   {"checksum", bad_checksum, "damaged or cut off"},
                   {"too short", gzip(NiftiFile().bytes + kSamples.substr(1)), "holds 411 bytes, expected 412"},
                   {"bomb", gzip(NiftiFile(2).dims({3, 60000, 60000, 60000}).bytes), "cannot decompress"},
                   {"offset behind the end", gzip(NiftiFile(2).offset(1e15).bytes + kSamples), "cannot decompress"}});
}

TEST(NiftiReaderBad, SurvivesTruncationsAndFlippedBitsSilently) {
  testing::internal::CaptureStderr();
  for (const int version : {1, 2}) {
    const std::string good = NiftiFile(version).sform({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}).bytes + kSamples;
    const TempFolder folder;
    for (std::size_t length = 1; length < good.size(); length += 7) {
      write_bytes(folder / "v.nii", good.substr(0, length));
      refusal(folder / "v.nii");
    }
    for (std::size_t bit = 0; bit < 8 * (good.size() - kSamples.size()); bit += 3) {
      std::string bytes = good;
      bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
      write_bytes(folder / "v.nii", bytes);
      static_cast<void>(volume_io::read_volume((folder / "v.nii").string(), {}, Context()));
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace isoextract::test
