// Tests options for properties that files do not state: the order of axes and the no-data value. Also tests integers
// wider than any sample type.
#include "unit/volume_io/npz_files.hpp"

namespace isoextract::test {
namespace {

volume_io::ReadOptions in_order_of(volume_io::AxisOrder order) {
  volume_io::ReadOptions options;
  options.axis_order = order;
  return options;
}

// a[x, y, z], the last axis fastest.
std::string turned_ramp() {
  std::string bytes;
  for (int i = 0; i < kDims.x; ++i) {
    for (int j = 0; j < kDims.y; ++j) {
      for (int k = 0; k < kDims.z; ++k) bytes += pack(ramp<std::int16_t>(i, j, k));
    }
  }
  return bytes;
}

TEST(AxisOrder, TransposesArraysInBothStorageOrders) {
  const TempFolder folder;
  const auto xyz = in_order_of(volume_io::AxisOrder::xyz);
  const auto zyx = in_order_of(volume_io::AxisOrder::zyx);
  write_bytes(folder / "c.npy", npy_array("<i2", "(3, 4, 5)", turned_ramp()));
  expect_ramp<std::int16_t>(must_read(folder / "c.npy", xyz));
  write_bytes(folder / "f.npy", npy_array("<i2", "(3, 4, 5)", ramp_bytes<std::int16_t>(), true));
  expect_ramp<std::int16_t>(must_read(folder / "f.npy", xyz));
  write_bytes(folder / "z.npy", npy_array("<i2", "(5, 4, 3)", ramp_bytes<std::int16_t>()));
  expect_ramp<std::int16_t>(must_read(folder / "z.npy", zyx));
  expect_ramp<std::int16_t>(must_read(folder / "z.npy"));
  EXPECT_EQ(std::get<field::DenseSamples>(must_read(folder / "z.npy", xyz).samples).dims, glm::ivec3(5, 4, 3));
  for (const bool packed : {false, true}) {
    write_bytes(folder / "v.npz", zip_bytes({zip_part("a.npy", npy_array("<i2", "(3, 4, 5)", turned_ramp()), packed)}));
    expect_ramp<std::int16_t>(must_read(folder / "v.npz", xyz));
  }
}

TEST(AxisOrder, KeepsDimsOfRawFilesInXyzOrder) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", turned_ramp());
  volume_io::ReadOptions options = in_order_of(volume_io::AxisOrder::xyz);
  options.raw = volume_io::RawLayout{kDims, field::SampleType::i16, std::endian::little, 0};
  expect_ramp<std::int16_t>(must_read(folder / "v.raw", options));
}

TEST(AxisOrder, IsRejectedIfTheFileStatesItsAxes) {
  const TempFolder folder;
  write_bytes(folder / "v.nrrd",
              "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 4 5\nencoding: raw\n\n" + ramp_bytes<std::uint8_t>());
  const Error error = refusal(folder / "v.nrrd", in_order_of(volume_io::AxisOrder::xyz));
  EXPECT_EQ(error.code, ErrorCode::usage);
  expect_in(error.message, "this is nrrd");
}

TEST(WideIntegers, BecomeDoublesIfExact) {
  const TempFolder folder;
  constexpr std::int64_t kMost = std::int64_t{1} << 53;
  const std::vector<std::int64_t> values{0, -1, kMost, -kMost, kMost + 2, INT64_MIN, 5, 6};
  for (const std::endian endian : {std::endian::little, std::endian::big}) {
    std::string bytes;
    for (const std::int64_t value : values) bytes += pack(value, endian);
    write_bytes(folder / "v.npy", npy_array(endian == std::endian::big ? ">i8" : "<i8", "(2, 2, 2)", bytes));
    const field::ScalarField field = must_read(folder / "v.npy");
    ASSERT_EQ(field.type(), field::SampleType::f64);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto at = static_cast<int>(i);
      EXPECT_EQ(dense_value<double>(field, at & 1, at >> 1 & 1, at >> 2), static_cast<double>(values[i]));
    }
    EXPECT_EQ(volume_io::list_grids((folder / "v.npy").string(), {}, Context()).value().front().type, "i64");
  }
}

TEST(WideIntegers, AreRejectedIfInexactUnlessNoData) {
  const TempFolder folder;
  const auto file = [&](const std::string& descr, std::uint64_t odd) {
    std::string bytes;
    for (std::uint64_t i = 0; i < 8; ++i) bytes += pack(i == 6 ? odd : i);
    write_bytes(folder / "v.npy", npy_array(descr, "(2, 2, 2)", bytes));
    return folder / "v.npy";
  };
  constexpr std::uint64_t kOdd = (std::uint64_t{1} << 53) + 1;
  expect_in(refusal(file("<i8", kOdd)).message, "found 9007199254740993 at sample (0, 1, 1)");
  expect_in(refusal(file("<u8", kOdd)).message, "found 9007199254740993 at sample (0, 1, 1)");
  expect_in(refusal(file("<u8", UINT64_MAX)).message, "found 18446744073709551615");
  expect_in(refusal(file("<i8", INT64_MAX)).message, "found 9223372036854775807");
  EXPECT_EQ(dense_value<double>(must_read(file("<u8", std::uint64_t{1} << 63)), 0, 1, 1), 0x1p63);
  volume_io::ReadOptions options;
  options.no_data = 9223372036854775807.0;
  const field::ScalarField field = must_read(file("<i8", INT64_MAX), options);
  EXPECT_TRUE(std::isnan(dense_value<double>(field, 0, 1, 1)));
  EXPECT_EQ(dense_value<double>(field, 1, 1, 1), 7);
}

TEST(WideIntegers, NeedNoAdditionalMemory) {
  const TempFolder folder;
  std::string bytes;
  for (std::int64_t i = 0; i < 1 << 15; ++i) bytes += pack(i);
  write_bytes(folder / "v.npy", npy_array("<i8", "(32, 32, 32)", bytes));
  EXPECT_EQ(dense_value<double>(must_read(folder / "v.npy", {}, with_memory(bytes.size())), 31, 31, 31), 32767);
  expect_in(refusal(folder / "v.npy", {}, with_memory(bytes.size() - 1)).message, "32x32x32");
}

TEST(WideIntegers, AreReadFromNrrdAndNifti) {
  const TempFolder folder;
  std::string bytes;
  for (std::int64_t i = 0; i < 60; ++i) bytes += pack(i - 30, std::endian::big);
  const std::string header = "NRRD0004\ntype: int64\nendian: big\ndimension: 3\nsizes: 3 4 5\nencoding: ";
  write_bytes(folder / "raw.nrrd", header + "raw\n\n" + bytes);
  write_bytes(folder / "gz.nrrd", header + "gzip\n\n" + gzip(bytes));
  for (const char* name : {"raw.nrrd", "gz.nrrd"}) {
    const field::ScalarField field = must_read(folder / name);
    EXPECT_EQ(dense_value<double>(field, 0, 0, 0), -30);
    EXPECT_EQ(dense_value<double>(field, 2, 3, 4), 29);
  }
}

TEST(BooleanArrays, BecomeZeroAndOne) {
  const TempFolder folder;
  write_bytes(folder / "v.npy", npy_array("|b1", "(2, 1, 2)", std::string("\0\1\1\0", 4)));
  const field::ScalarField field = must_read(folder / "v.npy");
  EXPECT_EQ(field.type(), field::SampleType::u8);
  EXPECT_EQ(dense_value<std::uint8_t>(field, 1, 0, 0), 1);
  EXPECT_EQ(dense_value<std::uint8_t>(field, 1, 0, 1), 0);
}

TEST(NoData, BecomesNanInEveryFormat) {
  const TempFolder folder;
  volume_io::ReadOptions options;
  options.no_data = ramp<std::int16_t>(1, 2, 3);
  write_bytes(folder / "v.npy", npy_array("<i2", "(5, 4, 3)", ramp_bytes<std::int16_t>()));
  const field::ScalarField field = must_read(folder / "v.npy", options);
  ASSERT_EQ(field.type(), field::SampleType::f32);
  EXPECT_TRUE(std::isnan(dense_value<float>(field, 1, 2, 3)));
  EXPECT_EQ(dense_value<float>(field, 2, 2, 3), ramp<float>(2, 2, 3));
  EXPECT_TRUE(has_note(field, "1 of 60 samples have the no-data value 88 and become NaN"));
  EXPECT_EQ(refusal(folder / "v.npy", options, with_memory(239)).code, ErrorCode::out_of_memory);
  EXPECT_FALSE(volume_io::read_volume("demo:sphere?size=8", options, Context()).value().notes.empty());
}

}  // namespace
}  // namespace isoextract::test
