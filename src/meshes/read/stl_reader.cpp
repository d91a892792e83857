// STL (3D Systems, 1989), binary and text: triangles without connectivity.
#include <cstring>

#include <fmt/format.h>

#include "meshes/read/mesh_format_readers.hpp"

namespace isoextract::meshes {
namespace {

constexpr std::size_t kPreambleBytes = 80 + sizeof(std::uint32_t);
constexpr std::size_t kRecordBytes = 4 * sizeof(glm::vec3) + sizeof(std::uint16_t);

FileSurface weld(const std::vector<glm::vec3>& corners, const MeshSource& source, std::string_view format) {
  require_vertex_count(corners.size());
  FileSurface surface;
  surface.format = format;
  weld_corners(corners, surface, source.memory);
  return surface;
}

// The file's size says whether it is binary: text begins with "solid", but so do the headers of some binary files.
std::uint64_t binary_size(std::span<const std::byte> content) {
  std::uint32_t count = 0;
  std::memcpy(&count, content.data() + kPreambleBytes - sizeof count, sizeof count);
  return kPreambleBytes + kRecordBytes * std::uint64_t{count};
}

FileSurface read_binary(const MeshSource& source) {
  const std::size_t count = (source.content.size() - kPreambleBytes) / kRecordBytes;
  std::vector<glm::vec3> corners;
  source.memory.make_room(corners, 3 * count);
  corners.resize(3 * count);
  for (std::size_t t = 0; t < count; ++t) {
    const std::byte* record = source.content.data() + kPreambleBytes + t * kRecordBytes;
    std::memcpy(&corners[3 * t], record + sizeof(glm::vec3), 3 * sizeof(glm::vec3));
  }
  return weld(corners, source, "STL, binary");
}

FileSurface read_text(const MeshSource& source) {
  TextScanner scanner(source.text());
  std::vector<glm::vec3> corners;
  std::size_t closed = 0;  // corners whose facet has ended
  bool ended = false;
  while (scanner.next_line()) {
    const std::string_view keyword = scanner.word();
    if (keyword == "vertex") {
      glm::vec3 p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<float>(scanner.number(scanner.word()));
      source.memory.make_room(corners, 1);
      corners.push_back(p);
      ended = false;
    } else if (keyword == "endloop" || keyword == "endfacet" || keyword == "endsolid") {
      const std::size_t count = corners.size() - closed;
      if (count != 3 && (count != 0 || keyword == "endloop")) {
        scanner.expected(fmt::format("3 corners before '{}'", keyword), std::to_string(count));
      }
      closed = corners.size();
      ended = ended || keyword == "endsolid";
    }
  }
  if (!ended) scanner.expected("'endsolid'", "the end of the file");
  return weld(corners, source, "STL, text");
}

}  // namespace

FileSurface read_stl(const MeshSource& source) {
  const std::size_t size = source.content.size();
  const bool has_header = size >= kPreambleBytes;
  if (has_header && binary_size(source.content) == size) return read_binary(source);
  if (source.text().starts_with("solid")) return read_text(source);
  if (!has_header) {
    throw DamagedMesh(
        fmt::format("expected at least the {} bytes of a binary STL's header, found {}", kPreambleBytes, size));
  }
  const std::uint64_t wanted = binary_size(source.content);
  throw DamagedMesh(fmt::format("expected {} bytes for the {} triangles that its header announces, found {}", wanted,
                                (wanted - kPreambleBytes) / kRecordBytes, size));
}

}  // namespace isoextract::meshes
