#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "volume_io/write/dense_writers.hpp"

namespace isoextract::volume_io {
namespace {

std::string_view vtk_type_name(field::SampleType type) {
  switch (type) {
    case field::SampleType::u8: return "UInt8";
    case field::SampleType::i8: return "Int8";
    case field::SampleType::u16: return "UInt16";
    case field::SampleType::i16: return "Int16";
    case field::SampleType::u32: return "UInt32";
    case field::SampleType::i32: return "Int32";
    case field::SampleType::f32: return "Float32";
    case field::SampleType::f16:
    case field::SampleType::f64: break;
  }
  return "Float64";
}

// Returns the text as an XML attribute's value, in UTF-8 without control characters.
std::string xml_value(std::string_view text) {
  std::string value;
  for (const char c : printable(text)) {
    switch (c) {
      case '&': value += "&amp;"; break;
      case '<': value += "&lt;"; break;
      case '>': value += "&gt;"; break;
      case '"': value += "&quot;"; break;
      default: value += c;
    }
  }
  return value;
}

}  // namespace

bool has_perpendicular_axes(const field::Affine& index_to_world) {
  constexpr double kMostCosine = 1e-6;  // files store axes as decimal numbers, some of them as floats
  const glm::dmat3& axes = index_to_world.linear;
  for (int a = 0; a < 3; ++a) {
    const glm::dvec3& one = axes[a];
    const glm::dvec3& next = axes[(a + 1) % 3];
    if (!(std::abs(glm::dot(one, next)) <= kMostCosine * glm::length(one) * glm::length(next))) return false;
  }
  return true;
}

std::string vti_header(const field::ScalarField& field, const field::DenseSamples& samples) {
  const field::Affine& place = field.index_to_world;
  const glm::ivec3 last = samples.dims - 1;
  const std::string extent = fmt::format("0 {} 0 {} 0 {}", last.x, last.y, last.z);
  glm::dvec3 spacing(0);
  glm::dmat3 axes(1);
  for (int a = 0; a < 3; ++a) {
    spacing[a] = glm::length(place.linear[a]);
    axes[a] = place.linear[a] / spacing[a];
  }
  std::string direction;  // row by row
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      direction += fmt::format("{}{}", direction.empty() ? "" : " ", axes[column][row]);
    }
  }
  const std::string name = field.name.empty() ? "values" : xml_value(field.name);
  std::string header = fmt::format(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"{}\" header_type=\"UInt64\">\n"
      "  <ImageData WholeExtent=\"{}\" Origin=\"{} {} {}\" Spacing=\"{} {} {}\" Direction=\"{}\">\n"
      "    <Piece Extent=\"{}\">\n"
      "      <PointData Scalars=\"{}\">\n"
      "        <DataArray type=\"{}\" Name=\"{}\" format=\"appended\" offset=\"0\"/>\n"
      "      </PointData>\n"
      "      <CellData/>\n"
      "    </Piece>\n"
      "  </ImageData>\n"
      "  <AppendedData encoding=\"raw\">\n   _",
      std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", extent, place.offset.x, place.offset.y,
      place.offset.z, spacing.x, spacing.y, spacing.z, direction, extent, name, vtk_type_name(samples.type), name);
  const std::uint64_t bytes = samples.count() * field::sample_size(samples.type);
  const auto size = std::bit_cast<std::array<char, sizeof(bytes)>>(bytes);
  header.append(size.begin(), size.end());
  return header;
}

}  // namespace isoextract::volume_io
