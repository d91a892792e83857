// STL (3D Systems, 1989), binary and text: triangles without connectivity.
#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "mesh_io/detail/placement_entry.hpp"
#include "mesh_io/detail/stl_layout.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {
namespace {

constexpr std::size_t kPreambleBytes = kStlHeaderBytes + sizeof(std::uint32_t);
constexpr std::size_t kRecordBytes = 4 * sizeof(glm::vec3) + sizeof(std::uint16_t);

// Welds the corners. `normals` has one entry per triangle if normals were requested.
FileSurface weld(const std::vector<glm::vec3>& corners, std::vector<glm::vec3> normals, const MeshSource& source,
                 std::string_view format) {
  require_vertex_count(corners.size());
  FileSurface surface;
  surface.format = format;
  weld_corners(corners, surface, source.memory);
  if (!source.with_normals) return surface;
  source.memory.make_room(surface.normals.numbers, normals.size());
  for (std::uint32_t t = 0; t < normals.size(); ++t) surface.normals.numbers.emplace_back(t);
  surface.normals.values = std::move(normals);
  return surface;
}

std::uint32_t announced_triangles(std::span<const std::byte> content) {
  std::uint32_t count = 0;
  std::memcpy(&count, content.data() + kPreambleBytes - sizeof count, sizeof count);
  return count;
}

constexpr std::uint64_t binary_size(std::uint64_t triangles) { return kPreambleBytes + kRecordBytes * triangles; }

// Compares without regard to case, since some programs write capitals.
bool is_word(std::string_view word, std::string_view lower_case) {
  return std::ranges::equal(word, lower_case,
                            [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

bool starts_as_text(std::string_view text) {
  constexpr std::string_view kStart = "solid";
  TextScanner scanner(without_byte_order_mark(text.substr(0, kPreambleBytes)));
  return is_word(scanner.next_word_across_lines().substr(0, kStart.size()), kStart);
}

FileSurface read_binary(const MeshSource& source) {
  const std::size_t count = announced_triangles(source.content);
  std::vector<glm::vec3> corners;
  source.memory.make_room(corners, 3 * count);
  corners.resize(3 * count);
  std::vector<glm::vec3> normals;
  if (source.with_normals) {
    source.memory.make_room(normals, count);
    normals.resize(count);
  }
  for (std::size_t t = 0; t < count; ++t) {
    const std::byte* record = source.content.data() + kPreambleBytes + t * kRecordBytes;
    std::memcpy(&corners[3 * t], record + sizeof(glm::vec3), 3 * sizeof(glm::vec3));
    if (source.with_normals) std::memcpy(&normals[t], record, sizeof(glm::vec3));
  }
  FileSurface surface = weld(corners, std::move(normals), source, "STL, binary");
  const std::string_view header = source.text().substr(0, kStlHeaderBytes);
  surface.is_by_isoextract = is_signature(header);
  const std::string entry = fmt::format(" {} ", kPlacementEntry);
  if (const std::size_t at = header.find(entry); at != std::string_view::npos) {
    surface.placement = header.substr(at + entry.size());
    surface.placement.resize(std::min(surface.placement.find('\0'), surface.placement.size()));
  }
  if (const std::uint64_t more = source.content.size() - binary_size(count); more > 0) {
    surface.notes.push_back(
        {NoteId::extra_bytes, fmt::format("the reader skips {} bytes after the last triangle", more)});
  }
  return surface;
}

FileSurface read_text(const MeshSource& source) {
  TextScanner scanner(without_byte_order_mark(source.text()));
  std::vector<glm::vec3> corners;
  std::vector<glm::vec3> normals;
  glm::vec3 normal(0.0F);  // of the current facet
  std::size_t closed = 0;  // number of corners in finished facets
  bool ended = false;
  constexpr std::array<std::string_view, 3> kEnds{"endloop", "endfacet", "endsolid"};
  while (scanner.next_line()) {
    const std::string_view keyword = scanner.word();
    const auto* end = std::ranges::find_if(kEnds, [&](std::string_view word) { return is_word(keyword, word); });
    if (is_word(keyword, "vertex")) {
      glm::vec3 p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<float>(scanner.number(scanner.word()));
      source.memory.make_room(corners, 1);
      corners.push_back(p);
      if (source.with_normals && corners.size() % 3 == 0) {
        source.memory.make_room(normals, 1);
        normals.push_back(normal);
      }
      ended = false;
    } else if (source.with_normals && is_word(keyword, "facet")) {
      scanner.word();  // "normal"
      for (int axis = 0; axis < 3; ++axis) normal[axis] = static_cast<float>(scanner.number(scanner.word()));
    } else if (end != kEnds.end()) {
      const std::size_t count = corners.size() - closed;
      if (count != 3 && (count != 0 || *end == "endloop")) {
        scanner.expected(fmt::format("3 corners before '{}'", *end), std::to_string(count));
      }
      closed = corners.size();
      ended = ended || *end == "endsolid";
    }
  }
  if (!ended) scanner.expected("'endsolid'", "the end of the file");
  return weld(corners, std::move(normals), source, "STL, text");
}

}  // namespace

// Decides by the file's size whether it is binary, because headers of some binary files begin with "solid" as text
// files do. A binary file longer than its triangles is recognized by a zero byte before its second triangle.
//
// Ignores bytes after the last triangle, with a note. If they could be whole triangles, the file is refused: its header
// has a wrong count, as from programs that never fill it in.
FileSurface read_stl(const MeshSource& source) {
  const std::size_t size = source.content.size();
  const bool has_header = size >= kPreambleBytes;
  const std::uint64_t count = has_header ? announced_triangles(source.content) : 0;
  const std::uint64_t wanted = binary_size(count);
  if (has_header && wanted == size) return read_binary(source);
  const bool has_zeros = source.text().substr(0, binary_size(1)).find('\0') != std::string_view::npos;
  const bool too_long = has_header && wanted < size;
  if (starts_as_text(source.text()) && !(too_long && has_zeros)) return read_text(source);
  if (!has_header) {
    throw DamagedMesh(
        fmt::format("expected at least the {} bytes of a binary STL's header, found {}", kPreambleBytes, size));
  }
  const bool more_triangles = too_long && (size - wanted) % kRecordBytes == 0;
  if (too_long && count > 0 && !more_triangles) return read_binary(source);
  throw DamagedMesh(fmt::format(
      "expected {} bytes for the {} triangles that its header announces, found {} bytes{}", wanted, count, size,
      more_triangles ? fmt::format(", the size of {} triangles", (size - kPreambleBytes) / kRecordBytes) : ""));
}

}  // namespace isoextract::mesh_io
