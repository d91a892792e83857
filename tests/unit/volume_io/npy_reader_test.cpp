#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

std::string npy_header(const std::string& dict, int version = 1) {
  std::string text = dict + '\n';
  std::string bytes = "\x93NUMPY";
  bytes += static_cast<char>(version);
  bytes += '\0';
  bytes += version == 1 ? pack(static_cast<std::uint16_t>(text.size())) : pack(static_cast<std::uint32_t>(text.size()));
  return bytes + text;
}

std::string dict(const std::string& descr, const std::string& shape = "(5, 4, 3)", bool fortran = false) {
  return "{'descr': '" + descr + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': " + shape + ", }";
}

const std::string kGood = npy_header(dict("<f4")) + ramp_bytes<float>();

template <class T>
class NpyReader : public testing::Test {};
using AllTypes = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                                field::Half, float, double>;
TYPED_TEST_SUITE(NpyReader, AllTypes);

TYPED_TEST(NpyReader, ReadsBothByteOrders) {
  const char kind = field::is_floating_sample<TypeParam> ? 'f' : (std::is_unsigned_v<TypeParam> ? 'u' : 'i');
  const std::string type = kind + std::to_string(sizeof(TypeParam));
  for (const char order : {'<', '>', '=', '|'}) {
    const std::endian endian = order == '>' ? std::endian::big : std::endian::little;
    const TempFolder folder;
    write_bytes(folder / "v.npy", npy_header(dict(order + type)) + ramp_bytes<TypeParam>(endian));
    const field::ScalarField field = must_read(folder / "v.npy");
    expect_ramp<TypeParam>(field);
    EXPECT_EQ(field.index_to_world, field::Affine());
    EXPECT_EQ(field.format, "NPY");
  }
}

TYPED_TEST(NpyReader, TransposesFortranOrder) {
  // More x planes than are transposed together.
  const glm::ivec3 dims{37, 3, 2};
  std::string bytes;
  for (int i = 0; i < dims.x; ++i) {
    for (int j = 0; j < dims.y; ++j) {
      for (int k = 0; k < dims.z; ++k) bytes += pack(ramp<TypeParam>(i, j, k), std::endian::big);
    }
  }
  const char kind = field::is_floating_sample<TypeParam> ? 'f' : (std::is_unsigned_v<TypeParam> ? 'u' : 'i');
  const TempFolder folder;
  write_bytes(
      folder / "v.npy",
      npy_header(dict(std::string(">") + kind + std::to_string(sizeof(TypeParam)), "(2, 3, 37)", true)) + bytes);
  expect_ramp<TypeParam>(must_read(folder / "v.npy"), dims);
}

TEST(NpyReaderHeader, ReadsAllVersionsAndSpellings) {
  for (const std::string& header :
       {npy_header(dict("<f4"), 1), npy_header(dict("<f4"), 2), npy_header(dict("<f4"), 3),
        npy_header("{\"shape\":(5L,4L,3L),\"descr\":\"<f4\",\"fortran_order\":False}"),
        npy_header("  {  'fortran_order'  :  False ,  'shape' : ( 5 , 4 , 3 , ) , 'descr' : '<f4' }   ")}) {
    const TempFolder folder;
    write_bytes(folder / "v.npy", header + ramp_bytes<float>());
    expect_ramp<float>(must_read(folder / "v.npy"));
  }
}

TEST(NpyReaderHeader, DropsLeadingAxesOfLengthOneWithANote) {
  const TempFolder folder;
  write_bytes(folder / "v.npy", npy_header(dict("<f4", "(1, 1, 5, 4, 3)")) + ramp_bytes<float>());
  const field::ScalarField field = must_read(folder / "v.npy");
  expect_ramp<float>(field);
  EXPECT_TRUE(has_note(field, "2 leading axes"));
}

TEST(NpyReaderHeader, NamesUnsupportedTypes) {
  for (const char* descr : {"<i16", "|b2", "<c4", "<c32", "|O", "<U5", "|S3", "<f16", "<M8[ns]", "f4", ""}) {
    const TempFolder folder;
    write_bytes(folder / "v.npy", npy_header(dict(descr)) + ramp_bytes<double>());
    expect_in(refusal(folder / "v.npy").message, descr);
  }
  const TempFolder folder;
  write_bytes(folder / "v.npy",
              npy_header("{'descr': [('a', '<f4'), ('b', '<f4', (2,))], 'fortran_order': False, 'shape': (5, 4, 3)}"));
  expect_in(refusal(folder / "v.npy").message, "a structure");
}

TEST(NpyReaderHeader, RejectsMalformedFiles) {
  const std::string huge_v2 = std::string("\x93NUMPY\2\0", 8) + pack(std::uint32_t{0xffffffff}) + "{}";
  std::string many_axes = "(";
  for (int i = 0; i < 1000; ++i) many_axes += "1,";
  expect_all_refused(
      "v.npy",
      {{"empty file", "", "empty"},
       {"text", "this is some text\n", "expected '\\x93NUMPY'"},
       {"magic only", kGood.substr(0, 6), "version"},
       {"no length", kGood.substr(0, 9), "header"},
       {"cut header", kGood.substr(0, 40), "longer than 1048588 bytes: it ends at byte"},
       {"no samples", kGood.substr(0, kGood.size() - 240), "expected 240 bytes"},
       {"cut samples", kGood.substr(0, kGood.size() - 1), "found 239"},
       {"extra byte", kGood + 'x', "found 1 more"},
       {"version 0", npy_header(dict("<f4"), 0), "version 1, 2 or 3, found 0"},
       {"version 4", npy_header(dict("<f4"), 4), "version 1, 2 or 3, found 4"},
       {"huge header", huge_v2, "longer than 1048588 bytes: it ends at byte"},
       {"no dictionary", npy_header("hello"), "expected a header"},
       {"open dictionary", npy_header("{'descr': '<f4'"), "expected a header"},
       {"open string", npy_header("{'descr': '<f4, 'fortran_order': False, 'shape': (5, 4, 3)}"), "expected a header"},
       {"no shape", npy_header("{'descr': '<f4', 'fortran_order': False}"), "expected a header"},
       {"key twice", npy_header("{'descr': '<f4', 'descr': '<f4', 'fortran_order': False, 'shape': (5, 4, 3)}"),
        "expected a header"},
       {"unknown key", npy_header("{'descr': '<f4', 'x': False, 'fortran_order': False, 'shape': (5, 4, 3)}"),
        "expected a header"},
       {"code", npy_header("{'descr': __import__('os'), 'fortran_order': False, 'shape': (5, 4, 3)}"),
        "expected a header"},
       {"open list", npy_header("{'descr': [[[[[['fortran_order': False, 'shape': (5, 4, 3)}"), "expected a header"},
       {"negative size", npy_header(dict("<f4", "(-5, 4, 3)")), "expected a header"},
       {"size over 64 bits", npy_header(dict("<f4", "(99999999999999999999, 4, 3)")), "expected a header"},
       {"many axes", npy_header(dict("<f4", many_axes + ")")), "expected a header"},
       {"zero size", npy_header(dict("<f4", "(5, 0, 3)")), "3x0x5"},
       {"huge size", npy_header(dict("<f4", "(1099511627776, 4, 3)")), "1099511627776"},
       {"huge volume", npy_header(dict("<f4", "(2000000000, 2000000000, 2)")), "found 2x2000000000x2000000000"},
       {"large volume", npy_header(dict("<f4", "(65536, 65536, 1024)")), "found 0"},
       {"image", npy_header(dict("<f4", "(5, 4)")), "3 axes"},
       {"vector", npy_header(dict("<f4", "(60,)")), "3 axes"},
       {"number", npy_header(dict("<f4", "()")), "3 axes"},
       {"five axes", npy_header(dict("<f4", "(2, 5, 4, 3, 1)")), "3 axes"}});
}

TEST(NpyReaderHeader, SurvivesTruncationsAndFlippedBits) {
  const TempFolder folder;
  for (std::size_t length = 1; length < kGood.size(); ++length) {
    write_bytes(folder / "v.npy", kGood.substr(0, length));
    refusal(folder / "v.npy");
  }
  for (std::size_t bit = 0; bit < 8 * (kGood.size() - 240); ++bit) {
    std::string bytes = kGood;
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
    write_bytes(folder / "v.npy", bytes);
    static_cast<void>(volume_io::read_volume((folder / "v.npy").string(), {}, Context()));
  }
}

}  // namespace
}  // namespace isoextract::test
