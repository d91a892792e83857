// Reads mesh files of all formats; each format has its own source file (read/ply_reader.cpp, read/obj_reader.cpp, ...).
//
// Coordinates are read in double where the file has that precision. They become float32 relative to an origin in
// double. If all coordinates are float32 numbers, the origin keeps them exact (it is 0 if need be); else it is the
// origin that the extractor would choose. If all meshes of a glTF file share one translation, it becomes the origin and
// the positions stay bit for bit.
// Polygons are triangulated as if they were convex, along diagonals that depend on the order of the corners only.
// All surfaces of a file are joined into one mesh, except those that glTF scales to zero: of an animated sequence
// (animation_writer.hpp) only the first frame with triangles is read, and a note tells so.
//
// A surface that looks closed is read as closed: vertices that were duplicated along creases for their normals are
// merged (merge_normal_copies() in read/mesh_format_readers.hpp). This needs normals in the file and positions that
// packing did not round.
//
// Vertex attributes are read from PLY and DRC (every number except position and normal) and from glTF (COLOR_0 and
// names that begin with an underscore). Values stay as stored: vectors are not rotated with a node. The writers of
// PLY, DRC and glTF write them back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "mesh/mesh.hpp"
#include "mesh/mesh_part.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::mesh_io {

// Normals of a file, in the coordinates of the mesh. STL has one per triangle, OBJ one per corner, other formats one
// per vertex. Corners keep their own normals when they are welded.
struct FileNormals {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  Buffer<glm::vec3> values;    // of any length, as stored; may be infinite or NaN
  Buffer<glm::uvec3> numbers;  // per triangle: the index into `values` of each corner, or kNone

  [[nodiscard]] bool empty() const { return values.empty(); }
};

// One mesh of a file with several: a range of vertices and a range of triangles.
struct MeshPart : mesh::PartRange {
  std::string name;                             // from the file, up to 200 bytes; may be empty
  std::optional<mesh::Material> material = {};  // with MeshReadOptions::scene, if the file states one
};

struct MeshReadOptions {
  bool normals = false;
  // For conversions: reads materials of glTF. Makes a part for each node of glTF, or for each material in the node, and
  // for each object of OBJ unless objects share vertices. Makes parts even if there is only one. A part has the name of
  // its node or object; if a node has several materials, the name of the material follows. Adds a note about all data
  // that a mesh cannot hold, such as textures.
  bool scene = false;
};

struct MeshFile {
  mesh::Mesh mesh;      // has the file's name; has no normals
  FileNormals normals;  // if requested and in the file; mesh.memory includes their bytes
  // glTF: one per node that shows a mesh; empty if there is only one. MeshReadOptions::scene makes more parts.
  std::vector<MeshPart> parts;
  std::string_view format;        // "PLY, text"
  bool y_up = false;              // the format prescribes that y points up; other formats prescribe no up axis
  bool is_quantized = false;      // positions were rounded by packing: Draco, KHR_mesh_quantization
  bool is_by_isoextract = false;  // the file says that isoextract wrote it; text STL cannot say so
  std::string placement;          // MeshWriteOptions::placement of a file of isoextract; not validated
  Notes notes;                    // data left out, one sentence each, starting with the file's name
};

// Reads a mesh file. Finds the format by its magic bytes; formats without any (OBJ, STL, text glTF) by the extension.
// If the name has no mesh extension (standard input has none), the beginning of the content decides.
// STL, and glTF without indices, store triangles without connectivity; so does Draco if no two triangles share a
// vertex. Their corners are welded where coordinates are equal (-0 equals 0), whatever their attributes. A welded
// vertex keeps the attributes of its first corner; for glTF, a note counts the corners that had other attributes.
//
// Fails with ErrorCode::input if the file cannot be read or is damaged, has coordinates that are not finite or indices
// of missing vertices, or needs more memory than the context has left. Also fails with ErrorCode::input if a glTF
// file requires an extension that isoextract does not support and that may change the triangles.
// Fails with ErrorCode::out_of_memory if an allocation fails, and as Context::check() does.
// The mesh holds the reservation of its memory. A file without triangles is no error.
[[nodiscard]] Result<MeshFile> read_mesh(const std::filesystem::path& path, const Context& context,
                                         const MeshReadOptions& options = {});

// Returns whether the file begins like one of the mesh formats, whatever its name. A PLY may hold particles instead.
[[nodiscard]] bool holds_mesh(const std::filesystem::path& path, const Context& context);

// Returns the format of a mesh file: by its magic bytes, else by the extension, or by the beginning of standard input.
// Returns nullopt for other files, for a PLY without faces, which holds particles, and for folders.
[[nodiscard]] std::optional<MeshFormat> find_mesh_format(const std::filesystem::path& path, const Context& context);

// Returns whether the first bytes of the file say that isoextract wrote it, without reading the mesh. Returns false for
// text STL and for files that cannot be read.
[[nodiscard]] bool is_written_by_isoextract(const std::filesystem::path& path, const Context& context);

// Returns the names of the data files that a .gltf refers to, with %-escapes decoded; empty if it refers to none, is
// no glTF or cannot be read.
[[nodiscard]] std::vector<std::string> external_buffer_names(const std::filesystem::path& gltf, const Context& context);

}  // namespace isoextract::mesh_io
