#include "field/no_data.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/fields.hpp"

namespace isoextract::test {
namespace {

template <class T>
class NoDataOf : public testing::Test {};
using NoDataTypes = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                                   field::Half, float, double>;
TYPED_TEST_SUITE(NoDataOf, NoDataTypes);

double marked_value(const field::ScalarField& field, std::size_t at) {
  const auto& samples = std::get<field::DenseSamples>(field.samples);
  return field::visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
    return static_cast<double>(static_cast<const T*>(samples.data)[at]);
  });
}

TYPED_TEST(NoDataOf, MarksOnlySamplesOfThatValue) {
  field::ScalarField field = dense_field<TypeParam>({4, 3, 2}, [](int i, int, int) { return 10 * i; });
  ASSERT_TRUE(field::mark_no_data(field, 20, Context()));
  for (std::size_t at = 0; at < 24; ++at) {
    const double value = marked_value(field, at);
    if (at % 4 == 2) {
      EXPECT_TRUE(std::isnan(value));
    } else {
      EXPECT_EQ(value, 10.0 * static_cast<double>(at % 4));
    }
  }
  const bool wide = sizeof(TypeParam) == 4 && std::is_integral_v<TypeParam>;
  EXPECT_EQ(field.type(), field::is_floating_sample<TypeParam> ? field::sample_type_of<TypeParam>()
                          : wide                               ? field::SampleType::f64
                                                               : field::SampleType::f32);
}

TYPED_TEST(NoDataOf, KeepsSamplesWithoutThatValue) {
  field::ScalarField field = dense_field<TypeParam>({2, 2, 2}, [](int i, int, int) { return i; });
  const void* data = std::get<field::DenseSamples>(field.samples).data;
  const Context nothing(MemoryBudget(0));
  for (const double value : {20.0, 0.5, -1e300, 1e300}) {
    ASSERT_TRUE(field::mark_no_data(field, value, nothing));
    EXPECT_EQ(std::get<field::DenseSamples>(field.samples).data, data);
  }
  EXPECT_EQ(field.notes.size(), 4U);
}

TEST(NoDataValue, ComparesInSampleTypeOrScaled) {
  field::ScalarField field = dense_field<float>({2, 2, 2}, [](int i, int, int) { return i == 0 ? -9999.9F : 1.0F; });
  ASSERT_TRUE(field::mark_no_data(field, -9999.9, Context()));
  EXPECT_TRUE(std::isnan(marked_value(field, 0)));
  field::ScalarField scaled = dense_field<std::int16_t>({2, 2, 2}, [](int i, int, int) { return i; });
  scaled.scale = {0.1, -1024};
  ASSERT_TRUE(field::mark_no_data(scaled, -1023.9, Context()));
  EXPECT_TRUE(std::isnan(marked_value(scaled, 1)));
  EXPECT_EQ(marked_value(scaled, 0), 0);
}

TEST(NoDataValue, RefusesSparseFields) {
  field::ScalarField field;
  field.source = "a.vdb";
  field.samples = field::SparseSamples();
  const auto marked = field::mark_no_data(field, 0, Context());
  ASSERT_FALSE(marked);
  EXPECT_EQ(marked.error().code, ErrorCode::usage);
}

}  // namespace
}  // namespace isoextract::test
