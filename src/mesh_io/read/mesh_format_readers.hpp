// The readers behind mesh_reader.hpp, one file a format. They get the file's bytes and give points and triangles;
// read_mesh makes a mesh of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "base/ascii.hpp"
#include "base/context.hpp"
#include "base/finite.hpp"
#include "files/file_bytes.hpp"
#include "mesh/attributes.hpp"

namespace isoextract::mesh_io {

struct MeshPart;

// Thrown within this room, where a mesh file does not hold what it should: what was expected and what was found.
// read_mesh puts the file's name in front and makes an Error of it.
struct DamagedMesh : std::runtime_error {
  explicit DamagedMesh(const std::string& message, Hint the_hint = {})
      : std::runtime_error(message), hint(std::move(the_hint)) {}
  Hint hint;
};

// Thrown within this room where somebody wants the reading to end.
struct Cancelled {
  Error error;
};

struct FileAttribute {
  mesh::Attribute kind;  // without values
  std::vector<std::byte> values;
};

// Normals as the file has them, which are not always those of vertices: STL has one a triangle, OBJ one a corner.
struct FileSurfaceNormals {
  std::vector<glm::vec3> values;
  std::vector<glm::uvec3> numbers;  // of each triangle's corners; empty: those of its vertices
};

// What belongs to one mesh of a file of several.
struct FilePart {
  std::string name;
  std::uint64_t first_vertex = 0;
  std::uint64_t first_triangle = 0;
};

struct FileSurface {
  std::vector<glm::dvec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<FileAttribute> attributes;  // of each position
  FileSurfaceNormals normals;             // where they were asked for and the file has any
  std::vector<FilePart> parts;            // of a format that holds several meshes, one after the other
  // The positions are float32 numbers relative to this, as the file has them; to be kept so.
  std::optional<glm::dvec3> origin;
  std::string_view format;
  bool y_up = false;      // the format prescribes that y points up
  bool is_ours = false;   // it says that isoextract wrote it
  std::string placement;  // as MeshWriteOptions has it, whoever wrote it; up to kMaxPlacement of it count
  // Vertices have normals, and places that were not rounded: there may be several vertices at one, for their normals.
  bool has_normals = false;
  bool is_quantised = false;  // positions were rounded to be packed
  std::vector<std::string> notes;
};

// What our writers sign files with (generator()) starts with this word, whatever the version.
inline constexpr std::string_view kProgram = "isoextract";
[[nodiscard]] inline bool is_signature(std::string_view text) {
  return text.starts_with(kProgram) && text.substr(kProgram.size()).starts_with(' ');
}

// What the reading of one file holds in memory, all parts together. Asked before every growth: sizes in a file, and
// files that a file names again and again, may ask for far more than its own bytes.
class MemoryUse {
 public:
  explicit MemoryUse(const Context& context) : context_(context) {}

  // Throws DamagedMesh where that is more than is left, and Cancelled.
  void take(std::uint64_t bytes);
  void give_back(std::uint64_t bytes) { used_ -= bytes; }

  // Room for `more` values behind those that are there.
  template <class T>
  void make_room(std::vector<T>& values, std::uint64_t more) {
    if (more <= values.capacity() - values.size()) return;
    const std::uint64_t before = values.capacity();
    const std::uint64_t after = std::max(values.size() + more, 2 * before);
    take(after * sizeof(T));  // the old values stay until they are copied
    values.reserve(after);
    give_back(before * sizeof(T));
  }

 private:
  const Context& context_;
  std::uint64_t used_ = 0;
  std::uint64_t reserved_ = 0;  // at least what is used
  std::vector<Reservation> parts_;
};

struct MeshSource {
  const files::InputFile& file;
  std::span<const std::byte> content;
  MemoryUse& memory;
  bool with_normals = false;
  [[nodiscard]] std::string_view text() const {
    return {reinterpret_cast<const char*>(content.data()), content.size()};
  }
};

[[nodiscard]] FileSurface read_ply(const MeshSource& source);
[[nodiscard]] FileSurface read_obj(const MeshSource& source);
[[nodiscard]] FileSurface read_stl(const MeshSource& source);
[[nodiscard]] FileSurface read_glb(const MeshSource& source);
[[nodiscard]] FileSurface read_gltf(const MeshSource& source);
[[nodiscard]] FileSurface read_drc(const MeshSource& source);

// "my%20mesh.bin" -> "my mesh.bin"
[[nodiscard]] std::string decode_percent(std::string_view uri);
// The bytes of "data:...". Throws DamagedMesh.
[[nodiscard]] std::vector<std::byte> decode_data_uri(std::string_view uri, MemoryUse& memory);

// A polygon of at least 3 corners as triangles that wind as it does, in linear time: around its first corner, or where
// it has very many corners by halving it along diagonals. Thousands of needles that meet in one corner lie in each
// other's bounding boxes, and whoever looks for the nearest of them has to look at all.
void add_polygon(std::vector<glm::uvec3>& triangles, std::span<const std::uint32_t> corners, MemoryUse& memory);

// A mesh's indices have 32 bits. Throws DamagedMesh.
void require_vertex_count(std::uint64_t count);

// Makes one vertex of all corners whose coordinates are equal; -0 is 0, and NaN is itself. `corners` come three a
// triangle. Returns the first corner of each new vertex. Attributes are left to the caller.
std::vector<std::uint32_t> weld_corners(std::span<const glm::vec3> corners, FileSurface& surface, MemoryUse& memory);

// Makes one vertex of copies that are there for their normals: where an edge that only one triangle runs along lies
// upon another such edge, which runs the other way, and no third one, they are one edge. Of attributes those of the
// first copy are kept. Surfaces that only touch in points, and surfaces that are closed by their numbers, stay as they
// are. Parts stay apart; their vertices are fewer, and still follow each other. Throws DamagedMesh and Cancelled as
// MemoryUse does.
void join_normal_seams(mesh::Mesh& mesh, std::vector<MeshPart>& parts, const Context& context);

// The text behind the mark that some programs put in front of UTF-8.
[[nodiscard]] std::string_view without_utf8_mark(std::string_view text);

// Words and numbers of a text, line by line.
class TextScanner {
 public:
  // Lines end with a line feed, a carriage return or both; where `line_end` is given, with that alone, for what follows
  // a line may be binary.
  explicit TextScanner(std::string_view text, std::optional<char> line_end = {}) : rest_(text), line_end_(line_end) {}

  // Moves to the next line; false at the end of the text.
  bool next_line();
  // The next word of the line; empty at its end.
  std::string_view word();
  // The same, but a backslash at the end of a line joins the next one to it.
  std::string_view word_of_joined_lines();
  // The next word of this line or the following ones; empty at the end of the text.
  std::string_view word_anywhere();

  // What is left of the line, without blanks at its ends.
  [[nodiscard]] std::string_view rest_of_line() const { return trimmed(line_); }
  // The text after this line.
  [[nodiscard]] std::string_view rest() const { return rest_; }
  // Throws DamagedMesh with the line's number.
  [[noreturn]] void expected(std::string_view what, std::string_view found) const;
  // Too small for double is 0, too large is infinite.
  [[nodiscard]] double number(std::string_view word) const;
  [[nodiscard]] std::int64_t whole_number(std::string_view word) const;

 private:
  std::string_view rest_;  // after this line
  std::string_view line_;  // what is left of it
  std::optional<char> line_end_;
  bool joins_next_ = false;  // the line has ended with a backslash
  std::size_t line_number_ = 0;
};

}  // namespace isoextract::mesh_io
