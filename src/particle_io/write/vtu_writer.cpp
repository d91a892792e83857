// https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html. Appended arrays each begin with the number
// of their bytes.
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "files/record_stream.hpp"
#include "particle_io/write/structured_writers.hpp"

namespace isoextract::particle_io {
namespace {

constexpr std::uint8_t kVertexCell = 1;  // VTK_VERTEX

// Describes arrays in the order in which they are appended.
class ArrayList {
 public:
  std::string add(std::string_view type, std::string_view name, std::size_t components, std::uint64_t bytes) {
    const std::string line = fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type,
        name, components, offset_);
    offset_ += sizeof(std::uint64_t) + bytes;
    return line;
  }

 private:
  std::uint64_t offset_ = 0;
};

std::string vtu_header(const points::ParticleSet& particles) {
  const std::uint64_t count = particles.size();
  ArrayList arrays;
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\" "
      "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n",
      std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", count, count);
  text += arrays.add("Float64", "Points", 3, count * 3 * sizeof(double));
  text += "</Points>\n<Cells>\n";
  text += arrays.add("Int64", "connectivity", 1, count * sizeof(std::int64_t));
  text += arrays.add("Int64", "offsets", 1, count * sizeof(std::int64_t));
  text += arrays.add("UInt8", "types", 1, count);
  text += "</Cells>\n<PointData>\n";
  for (const points::ParticleAttribute& attribute : particles.attributes) {
    text += arrays.add("Float32", attribute.name, attribute.components, attribute.values.size_bytes());
  }
  return text + "</PointData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
}

Result<void> write_size(files::OutputFile& file, std::uint64_t bytes) {
  const auto raw = std::bit_cast<std::array<char, sizeof bytes>>(bytes);
  return file.write(std::string_view(raw.data(), raw.size()));
}

Result<void> write_array(files::OutputFile& file, std::span<const std::byte> bytes) {
  TRY(write_size(file, bytes.size()));
  return file.write(bytes);
}

// Writes `first`, `first` + 1, ...
Result<void> write_numbers_from(files::OutputFile& file, std::int64_t first, std::size_t count) {
  TRY(write_size(file, count * sizeof(std::int64_t)));
  return files::write_records(file, count, sizeof(std::int64_t), [&](std::size_t begin, std::size_t end, char* out) {
    for (std::size_t i = begin; i < end; ++i, out += sizeof(std::int64_t)) {
      const std::int64_t number = first + static_cast<std::int64_t>(i);
      std::memcpy(out, &number, sizeof number);
    }
    return out;
  });
}

Result<void> write_vertex_cells(files::OutputFile& file, std::size_t count) {
  TRY(write_numbers_from(file, 0, count));
  TRY(write_numbers_from(file, 1, count));
  TRY(write_size(file, count));
  return files::write_records(file, count, 1, [&](std::size_t begin, std::size_t end, char* out) {
    std::memset(out, kVertexCell, end - begin);
    return out + (end - begin);
  });
}

}  // namespace

Result<void> write_vtu(files::OutputFile& file, const points::ParticleSet& particles) {
  TRY(file.write(std::string_view(vtu_header(particles))));
  TRY(write_array(file, std::as_bytes(particles.positions.span())));
  TRY(write_vertex_cells(file, particles.size()));
  for (const points::ParticleAttribute& attribute : particles.attributes) {
    TRY(write_array(file, std::as_bytes(attribute.values.span())));
  }
  return file.write(std::string_view("\n</AppendedData>\n</VTKFile>\n"));
}

}  // namespace isoextract::particle_io
