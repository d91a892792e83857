// Reads the vertices and faces of Wavefront OBJ, and normals if requested. For a scene, makes each object a part.
// Ignores texture coordinates and materials.
#include <limits>

#include <fmt/format.h>

#include "mesh_io/detail/placement_entry.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {
namespace {

// Parses an index: positive ones count from 1, negative ones backwards from the last element so far, which is -1.
// Returns it counted from 0.
std::uint32_t index_of(const TextScanner& scanner, std::string_view word, std::string_view corner, std::size_t so_far,
                       const char* what) {
  const std::int64_t number = scanner.whole_number(word);
  const auto count = static_cast<std::int64_t>(so_far);
  const std::int64_t index = number > 0 ? number - 1 : count + number;
  // Whether the element exists is checked at the end, since a file may refer to vertices that come later.
  if (number == 0 || index < 0 || index > std::numeric_limits<std::uint32_t>::max()) {
    scanner.expected(fmt::format("a {} index from 1 on, or a negative one down to -{}", what, so_far), corner);
  }
  return static_cast<std::uint32_t>(index);
}

// Returns the first number of "7", "7/1", "7//3" or "7/1/3".
std::uint32_t vertex_index(const TextScanner& scanner, std::string_view corner, std::size_t vertices) {
  return index_of(scanner, corner.substr(0, corner.find('/')), corner, vertices, "vertex");
}

constexpr std::uint32_t kNoNormalIndex = ~std::uint32_t{0};  // larger than any index

// Returns the third number, or kNoNormalIndex.
std::uint32_t normal_index(const TextScanner& scanner, std::string_view corner, std::size_t normals) {
  const std::size_t first = corner.find('/');
  const std::size_t second = first == std::string_view::npos ? first : corner.find('/', first + 1);
  if (second == std::string_view::npos || second + 1 == corner.size()) return kNoNormalIndex;
  return index_of(scanner, corner.substr(second + 1), corner, normals, "normal");
}

// Makes each object of a file a part, if the faces of each object use only vertices listed between its name and the
// next name.
class ObjectParts {
 public:
  ObjectParts(FileSurface& surface, MemoryUse& memory) : surface_(surface), memory_(memory) {}

  void begin(std::string_view name) {
    constexpr std::size_t kNameBytes = 200;
    // Vertices before the first object belong to it.
    const bool first = surface_.parts.empty();
    if (first && !surface_.triangles.empty()) are_apart_ = false;
    name = name.substr(0, kNameBytes);
    memory_.make_room(surface_.parts, 1);
    memory_.take(2 * (sizeof(MeshPart) + name.size()));  // twice: also in MeshFile::parts
    surface_.parts.push_back({std::string(name), first ? 0 : surface_.positions.size(), surface_.triangles.size()});
  }

  void add_face(std::span<const std::uint32_t> corners) {
    if (surface_.parts.empty()) return;
    const std::uint64_t first = surface_.parts.back().first_vertex;
    for (const std::uint32_t corner : corners) {
      are_apart_ = are_apart_ && corner >= first && corner < surface_.positions.size();
    }
  }

  void end() {
    if (are_apart_ || surface_.parts.empty()) return;
    surface_.left_out.insert(
        surface_.parts.size() == 1
            ? "the name of its object"
            : fmt::format("the names of its {} objects, which share vertices", surface_.parts.size()));
    surface_.parts.clear();
  }

 private:
  FileSurface& surface_;
  MemoryUse& memory_;
  bool are_apart_ = true;
};

glm::dvec3 point_of(TextScanner& scanner) {
  glm::dvec3 p;
  for (int axis = 0; axis < 3; ++axis) p[axis] = scanner.number(scanner.next_continued_word());
  return p;
}

}  // namespace

FileSurface read_obj(const MeshSource& source) {
  FileSurface surface;
  surface.format = "OBJ";
  const std::string_view text = without_byte_order_mark(source.text());
  surface.is_by_isoextract = text.starts_with("# ") && is_signature(text.substr(2));
  TextScanner scanner(text);
  std::vector<std::uint32_t> corners;
  std::vector<std::uint32_t> corner_normals;
  FileSurfaceNormals& normals = surface.normals;
  std::size_t lines_and_points = 0;
  ObjectParts objects(surface, source.memory);
  while (scanner.next_line()) {
    const std::string_view keyword = scanner.next_continued_word();
    if (keyword == "#" && surface.is_by_isoextract && surface.positions.empty() && scanner.word() == kPlacementEntry) {
      surface.placement = scanner.rest_of_line().substr(0, kMaxPlacement + 1);
      continue;
    }
    if (keyword == "v") {
      source.memory.make_room(surface.positions, 1);
      surface.positions.push_back(point_of(scanner));
      if (source.as_scene && !scanner.word().empty() && !scanner.word().empty())
        surface.left_out.insert("vertex colors");
    } else if (keyword == "o" && source.as_scene) {
      objects.begin(scanner.rest_of_line());
    } else if (keyword == "vn" && source.with_normals) {
      source.memory.make_room(normals.values, 1);
      normals.values.emplace_back(point_of(scanner));
    } else if (keyword == "f") {
      corners.clear();
      corner_normals.clear();
      for (;;) {
        const std::string_view corner = scanner.next_continued_word();
        if (corner.empty() || corner.front() == '#') break;
        source.memory.make_room(corners, 1);
        corners.push_back(vertex_index(scanner, corner, surface.positions.size()));
        if (!source.with_normals) continue;
        source.memory.make_room(corner_normals, 1);
        corner_normals.push_back(normal_index(scanner, corner, normals.values.size()));
      }
      if (corners.size() < 3) scanner.expected("at least 3 corners of a face", std::to_string(corners.size()));
      objects.add_face(corners);
      add_polygon(surface.triangles, corners, source.memory);
      if (source.with_normals) add_polygon(normals.numbers, corner_normals, source.memory);
    } else if (keyword == "vn" || keyword == "vt" || keyword == "usemtl") {
      surface.left_out.insert(keyword == "vn" ? "normals" : keyword == "vt" ? "texture coordinates" : "materials");
    } else if (keyword == "l" || keyword == "p") {
      ++lines_and_points;
    } else if (keyword == "curv" || keyword == "surf") {
      scanner.expected("polygons", keyword);
    } else if (keyword.find('\0') != std::string_view::npos) {
      scanner.expected("text", keyword);
    }
  }
  require_vertex_count(surface.positions.size());
  objects.end();
  if (lines_and_points > 0) {
    surface.notes.push_back(
        {NoteId::data_left_out,
         fmt::format("the reader skips {} lines and points, which form no surface", lines_and_points)});
  }
  return surface;
}

}  // namespace isoextract::mesh_io
