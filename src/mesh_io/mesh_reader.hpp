// The one door for meshes in files; one file per format behind it (ply_reader.cpp, obj_reader.cpp, ...).
//
// Coordinates are read in double, as far as the file has them, and become float32 relative to an origin in double that
// is chosen as the extractor does. A glTF file whose meshes share one translation keeps that as the origin, and its
// positions bit for bit. Polygons become triangles along diagonals that are chosen by the numbers of their corners, as
// if they were convex. All surfaces of a file are joined into one mesh, less those that glTF scales to nothing: of a
// sequence in one file (animation_writer.hpp) that leaves the first frame with triangles, and a note.
//
// Where a file has normals, and places that are not rounded by packing, vertices that are copies for their normals'
// sake, along creases, become one again (join_normal_seams() in read/mesh_format_readers.hpp), so that the surface is
// as closed as it looks.
//
// Attributes of vertices are read from PLY and DRC (every number but the place and the normal) and from glTF (COLOR_0,
// and what begins with an underscore), as the file has them: vectors do not turn with a node. The writers write them
// back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::mesh_io {

// Normals as the file has them, in the frame of the mesh. STL has one a triangle, OBJ one a corner, and other formats
// one a vertex; corners that were welded keep their own.
struct FileNormals {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  Buffer<glm::vec3> values;    // any length; of files, so that they need not be finite
  Buffer<glm::uvec3> numbers;  // of each triangle's corners: which value they have, or kNone

  [[nodiscard]] bool empty() const { return values.empty(); }
};

// One mesh of a file that holds several: its vertices and triangles follow each other.
struct MeshPart {
  std::string name;  // as the file has it, up to 200 bytes; may be empty
  std::uint64_t first_vertex = 0;
  std::uint64_t vertices = 0;
  std::uint64_t first_triangle = 0;
  std::uint64_t triangles = 0;
};

struct MeshReadOptions {
  bool normals = false;
};

struct MeshFile {
  mesh::Mesh mesh;                 // named like the file; without normals
  FileNormals normals;             // where they were asked for and the file has any; the mesh's memory counts them
  std::vector<MeshPart> parts;     // of glTF, one for each place where a mesh stands; none where that is one
  std::string_view format;         // "PLY, text"
  bool y_up = false;               // its format prescribes that y points up; the others do not say what does
  bool is_quantised = false;       // positions were rounded to be packed: Draco, KHR_mesh_quantization
  bool is_ours = false;            // it says that isoextract wrote it; STL as text does not say who did
  std::string placement;           // where it is ours and has one: MeshWriteOptions::placement, not checked
  std::vector<std::string> notes;  // what was left out, one sentence each; each starts with the file's name
};

// The format is found by content first, and by extension for those without a mark (OBJ, STL, glTF as text); where the
// name has no extension of a mesh, as that of standard input, by their first line too. STL, and glTF without indices,
// are triangles without connectivity (so is Draco's where no two triangles share a vertex): corners are welded where
// their coordinates are equal (-0 is 0), whatever their attributes: those of the first corner are kept, and a note
// counts the others.
//
// Fails with ErrorCode::input: a file that cannot be read, is damaged, has coordinates that are not finite, indices of
// vertices that are not there, or needs more memory than is left; or glTF that requires an extension which may change
// its triangles and is not read. The mesh keeps its part reserved. A file without triangles is no error.
[[nodiscard]] Result<MeshFile> read_mesh(const std::filesystem::path& path, const Context& context,
                                         const MeshReadOptions& options = {});

// Returns whether the file begins as a mesh of one of the formats does, whatever its name is. PLY may hold particles.
[[nodiscard]] bool holds_mesh(const std::filesystem::path& path, const Context& context);

// Whether the file's beginning says that isoextract wrote it, without reading the mesh. STL as text never does, nor
// does what cannot be read.
[[nodiscard]] bool is_signed(const std::filesystem::path& path, const Context& context);

// The names of the files in which a .gltf keeps its data, as it has them; none where it is no glTF, or has none.
[[nodiscard]] std::vector<std::string> data_file_names(const std::filesystem::path& gltf, const Context& context);

}  // namespace isoextract::mesh_io
