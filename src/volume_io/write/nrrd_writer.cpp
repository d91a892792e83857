#include <algorithm>
#include <bit>
#include <cctype>

#include <fmt/format.h>

#include "volume_io/write/dense_writers.hpp"

namespace isoextract::volume_io {
namespace {

std::string_view nrrd_type_name(field::SampleType type) {
  switch (type) {
    case field::SampleType::u8: return "uint8";
    case field::SampleType::i8: return "int8";
    case field::SampleType::u16: return "uint16";
    case field::SampleType::i16: return "int16";
    case field::SampleType::u32: return "uint32";
    case field::SampleType::i32: return "int32";
    case field::SampleType::f32: return "float";
    case field::SampleType::f16:
    case field::SampleType::f64: break;
  }
  return "double";
}

std::string vector_text(const glm::dvec3& v) { return fmt::format("({},{},{})", v.x, v.y, v.z); }

}  // namespace

std::string nrrd_header(const field::ScalarField& field, const field::DenseSamples& samples) {
  const field::Affine& place = field.index_to_world;
  // A line break would end the field.
  std::string name = field.name;
  std::ranges::replace_if(
      name, [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  std::string header = fmt::format("NRRD0004\ntype: {}\ndimension: 3\nspace dimension: 3\nsizes: {} {} {}\n",
                                   nrrd_type_name(samples.type), samples.dims.x, samples.dims.y, samples.dims.z);
  if (!name.empty()) header += fmt::format("content: {}\n", name);
  header += fmt::format("space directions: {} {} {}\nspace origin: {}\nendian: {}\nencoding: raw\n\n",
                        vector_text(place.linear[0]), vector_text(place.linear[1]), vector_text(place.linear[2]),
                        vector_text(place.offset), std::endian::native == std::endian::little ? "little" : "big");
  return header;
}

}  // namespace isoextract::volume_io
