// The readers of the single formats, which read_mesh() (mesh_reader.hpp) calls. Each reader turns a file's bytes into a
// FileSurface; read_mesh() makes a mesh of the FileSurface.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "base/ascii.hpp"
#include "base/context.hpp"
#include "base/finite.hpp"
#include "base/note.hpp"
#include "files/file_bytes.hpp"
#include "mesh/attributes.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh_io {

struct MeshPart;

// Thrown within mesh_io if a mesh file is invalid. The message says what was expected and found. read_mesh() prepends
// the file's name and returns it as an Error.
struct DamagedMesh : std::runtime_error {
  explicit DamagedMesh(const std::string& message, Hint the_hint = {})
      : std::runtime_error(message), hint(std::move(the_hint)) {}
  Hint hint;
};

// Thrown within mesh_io if the Context was cancelled.
struct Cancelled {
  Error error;
};

struct FileAttribute {
  mesh::Attribute kind;  // without values
  std::vector<std::byte> values;
};

// Normals as stored in the file: STL has one per triangle, OBJ one per corner, other formats one per vertex.
struct FileSurfaceNormals {
  std::vector<glm::vec3> values;
  // Per triangle: the index into `values` of each corner; if empty, the normals belong to the vertices.
  std::vector<glm::uvec3> numbers;
};

// One of several meshes of a file: its name and the index of its first vertex and triangle.
struct FilePart {
  std::string name;
  std::uint64_t first_vertex = 0;
  std::uint64_t first_triangle = 0;
  std::optional<mesh::Material> material = {};
};

struct FileSurface {
  std::vector<glm::dvec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<FileAttribute> attributes;  // one value per position
  FileSurfaceNormals normals;             // if requested and in the file
  std::vector<FilePart> parts;            // for formats with several meshes, in order
  // Set if positions are float32 numbers from the file, relative to this origin; they must be kept exactly.
  std::optional<glm::dvec3> origin;
  std::string_view format;
  bool y_up = false;              // the format prescribes that y points up
  bool is_by_isoextract = false;  // the file says that isoextract wrote it
  std::string placement;  // MeshWriteOptions::placement, from any program; read_mesh() keeps up to kMaxPlacement bytes
  // Vertices have normals and positions that were not rounded, so equal positions may be copies for different normals.
  bool has_normals = false;
  bool is_quantized = false;       // positions were rounded by packing
  std::set<std::string> left_out;  // of a scene: the kinds of data that a mesh cannot hold, "textures"
  Notes notes;
};

// The first word of the signature that isoextract writes into files (generator()), in every version.
inline constexpr std::string_view kProgram = "isoextract";
[[nodiscard]] inline bool is_signature(std::string_view text) {
  return text.starts_with(kProgram) && text.substr(kProgram.size()).starts_with(' ');
}

// Counts and reserves the memory that reading one file needs. Call take() before every allocation: sizes in a file, and
// data files that it names repeatedly, can ask for far more than its own bytes.
class MemoryUse {
 public:
  explicit MemoryUse(const Context& context) : context_(context) {}

  // Throws DamagedMesh if the memory budget has less than `bytes` left, and Cancelled if the context was cancelled.
  void take(std::uint64_t bytes);
  void give_back(std::uint64_t bytes) { used_ -= bytes; }

  // Reserves capacity for `more` additional values, doubling it at least. Throws as take() does.
  template <class T>
  void make_room(std::vector<T>& values, std::uint64_t more) {
    if (more <= values.capacity() - values.size()) return;
    const std::uint64_t before = values.capacity();
    const std::uint64_t after = std::max(values.size() + more, 2 * before);
    take(after * sizeof(T));  // the old values stay in memory until they are copied
    values.reserve(after);
    give_back(before * sizeof(T));
  }

 private:
  const Context& context_;
  std::uint64_t used_ = 0;
  std::uint64_t reserved_ = 0;  // never less than used_
  std::vector<Reservation> parts_;
};

struct MeshSource {
  const files::InputFile& file;
  std::span<const std::byte> content;
  MemoryUse& memory;
  bool with_normals = false;
  bool as_scene = false;  // MeshReadOptions::scene
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

// Decodes percent escapes: "my%20mesh.bin" becomes "my mesh.bin".
[[nodiscard]] std::string decode_percent(std::string_view uri);
// Returns the bytes of a URI that begins with "data:". Throws DamagedMesh.
[[nodiscard]] std::vector<std::byte> decode_data_uri(std::string_view uri, MemoryUse& memory);

// Appends the triangles of a polygon of at least 3 corners, with the same winding, in linear time. Small polygons
// become a fan around the first corner; large ones are halved recursively along diagonals.
// A fan of thousands of needle triangles would have overlapping bounding boxes, so that searches for the nearest
// triangle would visit all of them.
void add_polygon(std::vector<glm::uvec3>& triangles, std::span<const std::uint32_t> corners, MemoryUse& memory);

// Throws DamagedMesh if 32-bit indices cannot address so many vertices.
void require_vertex_count(std::uint64_t count);

// Welds corners with equal coordinates (-0 equals 0, a NaN equals the same NaN) and appends the vertices and triangles
// to `surface`. `corners` has three per triangle.
// Returns the first corner of each new vertex. The caller sets the attributes.
std::vector<std::uint32_t> weld_corners(std::span<const glm::vec3> corners, FileSurface& surface, MemoryUse& memory);

// Merges vertices that were duplicated for their normals. A boundary edge is merged with a boundary edge between the
// same two positions that runs the other way, if no third boundary edge lies between them. A merged vertex keeps the
// attributes of its first copy. Surfaces that only touch in points, and surfaces whose indices already close them, stay
// unchanged. Vertices of different parts are never merged; the vertex ranges of `parts` are updated. Throws DamagedMesh
// and Cancelled as MemoryUse does.
void merge_normal_copies(mesh::Mesh& mesh, std::vector<MeshPart>& parts, const Context& context);

// Returns the text without the byte order mark that some programs put in front of UTF-8.
[[nodiscard]] std::string_view without_byte_order_mark(std::string_view text);

// Splits a text into lines, words and numbers.
class TextScanner {
 public:
  // By default a line feed, a carriage return or both end a line. With `line_end`, only this character ends a line;
  // text before binary data needs this.
  explicit TextScanner(std::string_view text, std::optional<char> line_end = {}) : rest_(text), line_end_(line_end) {}

  // Moves to the next line. Returns false at the end of the text.
  bool next_line();
  // Returns the next word of the line; empty at its end.
  std::string_view word();
  // Like word(), but a backslash at the end of a line continues it on the next line.
  std::string_view next_continued_word();
  // Returns the next word of this or a following line; empty at the end of the text.
  std::string_view next_word_across_lines();

  // Returns the rest of the line without blanks at its ends.
  [[nodiscard]] std::string_view rest_of_line() const { return trimmed(line_); }
  // Returns the text after this line.
  [[nodiscard]] std::string_view rest() const { return rest_; }
  // Throws DamagedMesh with the line number.
  [[noreturn]] void expected(std::string_view what, std::string_view found) const;
  // Parses a word, or throws as expected() does. A number too small for double becomes 0, one too large infinity.
  [[nodiscard]] double number(std::string_view word) const;
  [[nodiscard]] std::int64_t whole_number(std::string_view word) const;

 private:
  std::string_view rest_;  // after this line
  std::string_view line_;  // the unread rest of this line
  std::optional<char> line_end_;
  bool joins_next_ = false;  // this line ended with a backslash
  std::size_t line_number_ = 0;
};

}  // namespace isoextract::mesh_io
