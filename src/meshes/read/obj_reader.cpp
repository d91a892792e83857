// Wavefront OBJ: the vertices and faces; what shades them is passed over.
#include <array>
#include <limits>

#include <fmt/format.h>

#include "meshes/read/mesh_format_readers.hpp"

namespace isoextract::meshes {
namespace {

// "7", "7/1", "7//3" or "7/1/3": the first number, from 1 on, or from -1 backwards from the last vertex so far.
std::uint32_t vertex_index(const TextScanner& scanner, std::string_view corner, std::size_t vertices) {
  const std::int64_t number = scanner.whole_number(corner.substr(0, corner.find('/')));
  const auto count = static_cast<std::int64_t>(vertices);
  const std::int64_t index = number > 0 ? number - 1 : count + number;
  // Whether there is such a vertex is known at the end; a file may name vertices before it has them.
  if (number == 0 || index < 0 || index > std::numeric_limits<std::uint32_t>::max()) {
    scanner.expected(fmt::format("the number of a vertex, of {} so far", vertices), corner);
  }
  return static_cast<std::uint32_t>(index);
}

}  // namespace

FileSurface read_obj(const MeshSource& source) {
  FileSurface surface;
  surface.format = "OBJ";
  const std::string_view text = without_utf8_mark(source.text());
  surface.is_ours = text.starts_with("# ") && is_signature(text.substr(2));
  TextScanner scanner(text);
  std::vector<std::uint32_t> corners;
  std::size_t lines_and_points = 0;
  while (scanner.next_line()) {
    const std::string_view keyword = scanner.word_of_joined_lines();
    if (keyword == "v") {
      std::array<double, 3> p{};
      for (double& coordinate : p) coordinate = scanner.number(scanner.word_of_joined_lines());
      source.memory.make_room(surface.positions, 1);
      surface.positions.emplace_back(p[0], p[1], p[2]);
    } else if (keyword == "f") {
      corners.clear();
      for (;;) {
        const std::string_view corner = scanner.word_of_joined_lines();
        if (corner.empty() || corner.front() == '#') break;
        source.memory.make_room(corners, 1);
        corners.push_back(vertex_index(scanner, corner, surface.positions.size()));
      }
      if (corners.size() < 3) scanner.expected("at least 3 corners of a face", std::to_string(corners.size()));
      add_polygon(surface.triangles, corners, source.memory);
    } else if (keyword == "l" || keyword == "p") {
      ++lines_and_points;
    } else if (keyword == "curv" || keyword == "surf") {
      scanner.expected("polygons", keyword);
    } else if (keyword.find('\0') != std::string_view::npos) {
      scanner.expected("text", keyword);
    }
  }
  require_vertex_count(surface.positions.size());
  if (lines_and_points > 0) {
    surface.notes.push_back(fmt::format("{} lines and points, which are no surface, were left out", lines_and_points));
  }
  return surface;
}

}  // namespace isoextract::meshes
