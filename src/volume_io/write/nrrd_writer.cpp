#include <algorithm>
#include <array>
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

// Returns NRRD's name for a space of a scan, or nothing for a space that NRRD does not know.
std::string_view nrrd_space_name(std::string_view space) {
  if (space == "RAS+ (NIfTI)") return "right-anterior-superior";
  constexpr std::array<std::string_view, 6> kKnown{"right-anterior-superior", "left-anterior-superior",
                                                   "left-posterior-superior", "scanner-xyz",
                                                   "3D-right-handed",         "3D-left-handed"};
  const auto* const found = std::ranges::find(kKnown, space);
  return found != kKnown.end() ? *found : std::string_view();
}

// Returns the text without line breaks, which would end a field, and without quotes.
std::string one_line(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return std::iscntrl(c) != 0 || c == '"'; }, ' ');
  return text;
}

std::string nrrd_vector(const glm::dvec3& v) { return fmt::format("({},{},{})", v.x, v.y, v.z); }

}  // namespace

std::string nrrd_header(const field::ScalarField& field, const field::DenseSamples& samples) {
  const field::Affine& place = field.index_to_world;
  const std::string_view space = nrrd_space_name(field.world_space);
  std::string header =
      fmt::format("NRRD0004\ntype: {}\ndimension: 3\n{}\nsizes: {} {} {}\n", nrrd_type_name(samples.type),
                  space.empty() ? "space dimension: 3" : fmt::format("space: {}", space), samples.dims.x,
                  samples.dims.y, samples.dims.z);
  if (!field.name.empty()) header += fmt::format("content: {}\n", one_line(field.name));
  if (!field.length_unit.empty()) {
    const std::string unit = one_line(field.length_unit);
    header += fmt::format("space units: \"{}\" \"{}\" \"{}\"\n", unit, unit, unit);
  }
  header += fmt::format("space directions: {} {} {}\nspace origin: {}\nendian: {}\nencoding: raw\n\n",
                        nrrd_vector(place.linear[0]), nrrd_vector(place.linear[1]), nrrd_vector(place.linear[2]),
                        nrrd_vector(place.offset), std::endian::native == std::endian::little ? "little" : "big");
  return header;
}

}  // namespace isoextract::volume_io
