#include "mesh_io/write/number_text.hpp"

#include <bit>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>

namespace isoextract::test {
namespace {

// Returns the number's text, written into a buffer of just kMaxNumberText bytes.
template <class T>
std::string text_of(T number) {
  std::string room(mesh_io::kMaxNumberText<T>, '#');
  const char* end = mesh_io::put_number(room.data(), number);
  return room.substr(0, static_cast<std::size_t>(end - room.data()));
}

template <class T>
void expect_shortest(T number) {
  char room[64];
  const auto end = std::to_chars(room, room + sizeof room, number).ptr;
  ASSERT_EQ(text_of(number), std::string(room, end));
}

TEST(NumberText, WritesIndices) {
  for (std::uint32_t number = 0; number < 200'000; ++number) expect_shortest(number);
  for (std::uint64_t power = 1; power < 10'000'000'000'000'000'000U; power *= 10) {
    for (const std::uint64_t number : {power - 1, power, power + 1, 3 * power, 7 * power + 5}) {
      expect_shortest(number);
      expect_shortest(static_cast<std::uint32_t>(number));
    }
  }
  expect_shortest(std::numeric_limits<std::uint32_t>::max());
  expect_shortest(std::numeric_limits<std::uint64_t>::max());
}

template <class T>
class NumberTextFloat : public testing::Test {};
using FloatTypes = testing::Types<float, double>;
TYPED_TEST_SUITE(NumberTextFloat, FloatTypes);

TYPED_TEST(NumberTextFloat, WritesWholeNumbersAndTheirNeighbors) {
  constexpr TypeParam kInfinity = std::numeric_limits<TypeParam>::infinity();
  for (int whole = 0; whole < 250'000; ++whole) {
    const auto number = static_cast<TypeParam>(whole);
    for (const TypeParam beside : {number, std::nextafter(number, kInfinity), std::nextafter(number, -kInfinity)}) {
      expect_shortest(beside);
      expect_shortest(-beside);
    }
  }
}

TYPED_TEST(NumberTextFloat, WritesAnyBits) {
  using Limits = std::numeric_limits<TypeParam>;
  for (const TypeParam number :
       {Limits::max(), Limits::min(), Limits::denorm_min(), Limits::infinity(), Limits::quiet_NaN(), TypeParam(-0.0),
        TypeParam(0.5), TypeParam(1e5), TypeParam(4e9)}) {
    expect_shortest(number);
    expect_shortest(-number);
  }
  using Bits = std::conditional_t<std::is_same_v<TypeParam, float>, std::uint32_t, std::uint64_t>;
  std::mt19937_64 random(1);
  for (int i = 0; i < 200'000; ++i) expect_shortest(std::bit_cast<TypeParam>(static_cast<Bits>(random())));
}

}  // namespace
}  // namespace isoextract::test
