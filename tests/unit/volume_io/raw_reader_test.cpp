#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

volume_io::ReadOptions raw_options(field::SampleType type, std::endian endian = std::endian::little,
                                   std::uint64_t skip = 0) {
  volume_io::ReadOptions options;
  options.raw = volume_io::RawLayout{kDims, type, endian, skip};
  return options;
}

template <class T>
class RawReader : public testing::Test {};
using AllTypes = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                                field::Half, float, double>;
TYPED_TEST_SUITE(RawReader, AllTypes);

TYPED_TEST(RawReader, ReadsBothByteOrdersAfterAHeader) {
  for (const std::endian endian : {std::endian::little, std::endian::big}) {
    const TempFolder folder;
    write_bytes(folder / "v.raw", "head" + ramp_bytes<TypeParam>(endian));
    expect_ramp<TypeParam>(must_read(folder / "v.raw", raw_options(field::sample_type_of<TypeParam>(), endian, 4)));
  }
}

TEST(RawReaderSize, ReportsExpectedAndFoundSizeAndFittingLayouts) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", ramp_bytes<std::uint16_t>());
  const Error smaller = refusal(folder / "v.raw", raw_options(field::SampleType::f32));
  expect_in(smaller.message, "expected 240 bytes");
  expect_in(smaller.message, "found 120");
  EXPECT_EQ(smaller.hint, Hint(Remedy::try_value, Setting::sample_type, "u16 or i16 or f16 (the size would fit)"));
  const Error larger = refusal(folder / "v.raw", raw_options(field::SampleType::u16, std::endian::little, 2));
  expect_in(larger.message, "expected 122 bytes");
  write_bytes(folder / "v.raw", "12345678" + ramp_bytes<std::uint16_t>());
  EXPECT_EQ(refusal(folder / "v.raw", raw_options(field::SampleType::u16)).hint,
            Hint(Remedy::try_value, Setting::skipped_bytes, "8 (if the file begins with a header of that size)"));
}

TEST(RawReaderSize, ReadsSeveralVolumes) {
  const TempFolder folder;
  const std::string first = ramp_bytes<std::int16_t>();
  std::string second = first;
  second[0] = static_cast<char>(second[0] + 1);
  write_bytes(folder / "v.raw", "head" + first + second);
  volume_io::ReadOptions options = raw_options(field::SampleType::i16, std::endian::little, 4);
  const auto count = volume_io::count_volumes((folder / "v.raw").string(), options, Context());
  ASSERT_TRUE(count) << count.error().message;
  EXPECT_EQ(*count, 2U);
  const Error error = refusal(folder / "v.raw", options);
  expect_in(error.message, "because the file has 2 volumes");
  EXPECT_EQ(error.hint, (Hint{{Remedy::choose, Setting::volume, "from 0 to 1"},
                              {Remedy::try_value, Setting::sample_type, "u32 or i32 or f32 (as one volume)"}}));
  options.volume = 0;
  expect_ramp<std::int16_t>(must_read(folder / "v.raw", options));
  options.volume = 1;
  const double base = dense_value<std::int16_t>(
      must_read(folder / "v.raw", raw_options(field::SampleType::i16, std::endian::little, 4 + first.size())), 0, 0, 0);
  EXPECT_EQ(dense_value<std::int16_t>(must_read(folder / "v.raw", options), 0, 0, 0), base);
  EXPECT_EQ(base, ramp<std::int16_t>(0, 0, 0) + 1);
  options.volume = 2;
  expect_in(refusal(folder / "v.raw", options).message, "there is no volume 2; expected 0 to 1");
  // The axes of each volume in the other order.
  options.volume = 1;
  options.axis_order = volume_io::AxisOrder::xyz;
  EXPECT_EQ(dense_value<std::int16_t>(must_read(folder / "v.raw", options), 0, 0, 0), base);
  options.raw->skip = 5;
  expect_in(refusal(folder / "v.raw", options).message, "or more volumes of 120 bytes each after these, found 244");
}

TEST(RawReaderSize, RejectsHugeSizesBeforeAllocating) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", "12345678");
  volume_io::ReadOptions options = raw_options(field::SampleType::f64);
  options.raw->dims = glm::ivec3(0x7fffffff);
  expect_in(refusal(folder / "v.raw", options).message, "2147483647");
  options = raw_options(field::SampleType::u8, std::endian::little, ~std::uint64_t{0});
  expect_in(refusal(folder / "v.raw", options).message, "found 8");
}

TEST(RawReaderSize, RejectsDimsBelowOne) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", "12345678");
  volume_io::ReadOptions options = raw_options(field::SampleType::u8);
  options.raw->dims = {2, -4, -1};
  const auto field = volume_io::read_volume((folder / "v.raw").string(), options, Context());
  ASSERT_FALSE(field);
  EXPECT_EQ(field.error().code, ErrorCode::usage);
}

TEST(RawReaderSize, RespectsTheMemoryLimit) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", ramp_bytes<float>(std::endian::big));
  const volume_io::ReadOptions options = raw_options(field::SampleType::f32, std::endian::big);
  const Error error = refusal(folder / "v.raw", options, with_memory(239));
  EXPECT_EQ(error.code, ErrorCode::out_of_memory);
  EXPECT_EQ(error.hint, Hint(Remedy::raise, Setting::memory_limit));
  expect_ramp<float>(must_read(folder / "v.raw", options, with_memory(240)));
}

TEST(RawReaderSize, ReservesMemoryWhileTheSamplesLive) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", ramp_bytes<float>(std::endian::big));
  const volume_io::ReadOptions options = raw_options(field::SampleType::f32, std::endian::big);
  const Context context = with_memory(300);
  {
    const field::ScalarField field = must_read(folder / "v.raw", options, context);
    EXPECT_EQ(context.memory().reserved(), 240U);
    EXPECT_EQ(refusal(folder / "v.raw", options, context).hint, Hint(Remedy::raise, Setting::memory_limit));
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
  must_read(folder / "v.raw", options, context);
}

TEST(RawReaderSize, CanBeCancelled) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", ramp_bytes<float>(std::endian::big));
  const Context context;
  context.cancel();
  const auto field = volume_io::read_volume((folder / "v.raw").string(),
                                            raw_options(field::SampleType::f32, std::endian::big), context);
  ASSERT_FALSE(field);
  EXPECT_EQ(field.error().code, ErrorCode::cancelled);
}

TEST(RawReaderSize, ReportsProgressInBytes) {
  // Larger than the blocks that are read at a time, and not a multiple of them.
  const glm::ivec3 dims{200, 210, 220};
  const TempFolder folder;
  write_bytes(folder / "v.raw", ramp_bytes<std::int16_t>(std::endian::big, dims));
  const Context context;
  const Progress& progress = context.progress();
  volume_io::ReadOptions options = raw_options(field::SampleType::i16, std::endian::big);
  options.raw->dims = dims;
  expect_ramp<std::int16_t>(must_read(folder / "v.raw", options, context), dims);
  EXPECT_STREQ(progress.stage(), "reading");
  EXPECT_EQ(progress.total(), 200U * 210U * 220U * 2U);
  EXPECT_EQ(progress.done(), progress.total());
}

TEST(RawReaderPlace, AppliesSpacingAndOrigin) {
  const TempFolder folder;
  write_bytes(folder / "head.raw", ramp_bytes<std::uint8_t>());
  volume_io::ReadOptions options = raw_options(field::SampleType::u8);
  const field::ScalarField plain = must_read(folder / "head.raw", options);
  EXPECT_EQ(plain.index_to_world, field::Affine());
  EXPECT_EQ(plain.name, "head");
  EXPECT_EQ(plain.source, (folder / "head.raw").string());
  EXPECT_EQ(plain.kind, field::FieldKind::density);
  options.spacing = glm::dvec3(0.5, 2, 3);
  options.origin = glm::dvec3(-1, 10, 100);
  options.kind = field::FieldKind::level_set;
  const field::ScalarField placed = must_read(folder / "head.raw", options);
  expect_near(placed.index_to_world({2, 1, 4}), {0, 12, 112});
  EXPECT_EQ(placed.kind, field::FieldKind::level_set);
}

TEST(RawReaderPlace, RejectsSpacingsThatAreNotPositive) {
  const TempFolder folder;
  write_bytes(folder / "v.raw", ramp_bytes<std::uint8_t>());
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    volume_io::ReadOptions options = raw_options(field::SampleType::u8);
    options.spacing = glm::dvec3(1, bad, 1);
    const auto field = volume_io::read_volume((folder / "v.raw").string(), options, Context());
    ASSERT_FALSE(field);
    EXPECT_EQ(field.error().code, ErrorCode::usage);
  }
}

}  // namespace
}  // namespace isoextract::test
