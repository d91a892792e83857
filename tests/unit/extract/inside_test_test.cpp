#include "extract/inside_test.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace isoextract::extract {
namespace {

// Samples near all limits of the type, and random ones.
template <class T>
std::vector<T> probes() {
  std::vector<T> values;
  using Order = OrderedKey<T>;
  using Key = typename Order::Key;
  std::mt19937_64 engine(1);
  for (int n = 0; n < 2000; ++n) {
    const Key span = static_cast<Key>(Order::kHighest - Order::kLowest);
    const auto offset =
        static_cast<Key>(span == static_cast<Key>(-1) ? engine() : engine() % (std::uint64_t{span} + 1));
    values.push_back(Order::value(static_cast<Key>(Order::kLowest + offset)));
  }
  for (Key d = 0; d < 4; ++d) {
    values.push_back(Order::value(static_cast<Key>(Order::kLowest + d)));
    values.push_back(Order::value(static_cast<Key>(Order::kHighest - d)));
  }
  for (const double v : {-2.0, -1.0, -0.5, -0.0, 0.0, 0.5, 1.0, 2.0, 59.0, 60.0, 61.0, 100.0}) {
    if (std::is_signed_v<T> || v >= 0) values.push_back(static_cast<T>(static_cast<float>(v)));
  }
  return values;
}

template <class T>
class InsideTest : public testing::Test {};
using Types = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                             field::Half, float, double>;
TYPED_TEST_SUITE(InsideTest, Types);

// The threshold agrees with the comparison of converted values, for every kind of iso value and scale.
TYPED_TEST(InsideTest, AgreesWithRule) {
  const std::vector<TypeParam> samples = probes<TypeParam>();
  for (const field::FieldKind kind : {field::FieldKind::density, field::FieldKind::level_set}) {
    for (const field::ValueScale scale : {field::ValueScale{}, field::ValueScale{2.00784, 0},
                                          field::ValueScale{-0.5, 3}, field::ValueScale{1e-3, -7}}) {
      for (const double iso :
           {0.0, -0.0, 60.0, 59.5, -1.0, 0.1, 120.0, 1e7 + 1e-3, 3e38, -1e300, 1e-310, 254.99999999}) {
        const InsideRule rule{kind, iso};
        const auto threshold = find_inside_threshold<TypeParam>(rule, scale);
        for (std::size_t first = 0; first < samples.size(); first += 64) {
          const int count = static_cast<int>(std::min<std::size_t>(64, samples.size() - first));
          std::uint64_t nan = 0;
          const std::uint64_t word =
              threshold ? InsideClassifier<TypeParam>(*threshold)(samples.data() + first, count, nan) : 0;
          for (int b = 0; b < count; ++b) {
            const double value = scale(static_cast<double>(samples[first + static_cast<std::size_t>(b)]));
            ASSERT_EQ((word >> b & 1) != 0, rule(value)) << value << " against " << iso;
          }
          ASSERT_EQ(nan, 0U);
        }
      }
    }
  }
}

TYPED_TEST(InsideTest, CountsNanAndKeepsItOutside) {
  if constexpr (field::is_floating_sample<TypeParam>) {
    for (const field::FieldKind kind : {field::FieldKind::density, field::FieldKind::level_set}) {
      std::vector<TypeParam> samples(64, static_cast<TypeParam>(kind == field::FieldKind::density ? 1.0F : -1.0F));
      const auto nan = static_cast<TypeParam>(std::numeric_limits<float>::quiet_NaN());
      samples[3] = nan;
      samples[63] = static_cast<TypeParam>(-static_cast<float>(nan));
      const auto threshold = find_inside_threshold<TypeParam>({kind, 0.0}, {});
      ASSERT_TRUE(threshold);
      std::uint64_t count = 0;
      const std::uint64_t word = InsideClassifier<TypeParam>(*threshold)(samples.data(), 64, count);
      EXPECT_EQ(count, 2U);
      EXPECT_EQ(word, ~(std::uint64_t{1} << 3 | std::uint64_t{1} << 63));
    }
  }
}

TEST(InsideThreshold, IsEmptyIfNoNumberIsInside) {
  EXPECT_FALSE(find_inside_threshold<std::uint8_t>({field::FieldKind::density, 255}, {}));
  EXPECT_FALSE(find_inside_threshold<std::uint8_t>({field::FieldKind::level_set, 0}, {}));
  EXPECT_TRUE(find_inside_threshold<std::uint8_t>({field::FieldKind::density, 254.9}, {}));
  EXPECT_TRUE(find_inside_threshold<float>({field::FieldKind::density, 1e300}, {})) << "infinity is above";
}

TEST(InsideThreshold, DoesNotRoundWideIntegersOrOffsets) {
  // float cannot hold 16777217.
  const auto wide = find_inside_threshold<std::int32_t>({field::FieldKind::density, 16777216}, {});
  ASSERT_TRUE(wide);
  EXPECT_EQ(wide->threshold, 16777217);
  const auto fine = find_inside_threshold<double>({field::FieldKind::density, 1e7}, {});
  ASSERT_TRUE(fine);
  EXPECT_EQ(fine->threshold, std::nextafter(1e7, 2e7));
}

}  // namespace
}  // namespace isoextract::extract
