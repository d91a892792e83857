// Writes mesh files of all formats. Each format has a source file in write/ (ply_writer.cpp, ...); glb and gltf share
// gltf_writer.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "mesh/mesh.hpp"
#include "mesh/mesh_sink.hpp"
#include "mesh_io/mesh_packing.hpp"

namespace isoextract::mesh_io {

enum class MeshFormat { glb, gltf, ply, obj, stl, drc };
constexpr auto words_of(MeshFormat /*type*/) {
  return std::array{Word{MeshFormat::glb, "glb"}, Word{MeshFormat::gltf, "gltf"}, Word{MeshFormat::ply, "ply"},
                    Word{MeshFormat::obj, "obj"}, Word{MeshFormat::stl, "stl"},   Word{MeshFormat::drc, "drc"}};
}

// Returns whether a file of this format has one place for each vertex and triangle, so that parts can come in any
// order, also from several ranks. False for text, for DRC, for STL, whose triangles have their own copies of the
// vertices, and for .gltf, because ranks share only one file.
[[nodiscard]] bool has_fixed_places(MeshFormat format, bool ascii);

// Returns true for glb and gltf, in which y points up, lengths are in meters and meshes have materials.
[[nodiscard]] bool is_gltf(MeshFormat format);

// Properties of a format; detection by extension, help and documentation use them.
struct MeshFormatInfo {
  MeshFormat format;
  std::string_view name;          // also the extension, without its dot
  std::string_view title;         // "glTF 2.0, one binary file"
  bool can_hold_several_meshes;   // several iso values can share one file
  bool writes_each_mesh_at_once;  // add() writes and frees each mesh; otherwise finish() writes all
  bool can_stream;                // can be written to standard output
  bool has_text_option;           // besides its binary form
  bool has_attributes;            // can store vertex attributes besides position and normal
  // True: the format rounds world positions to float32. False: it keeps more precision by a separate origin, doubles or
  // decimal text.
  bool stores_float32_world;
  bool readers_weld;  // the file has no vertex indices, so readers weld vertices at equal positions
  bool takes_parts;   // the one mesh of a file can be written part by part (MeshWriter::begin_parts())
};
[[nodiscard]] std::span<const MeshFormatInfo> mesh_formats();
// Returns ".glb, .gltf, .ply, .obj, .stl or .drc".
[[nodiscard]] std::string mesh_extensions();
[[nodiscard]] const MeshFormatInfo& mesh_format_info(MeshFormat format);
[[nodiscard]] std::optional<MeshFormat> mesh_format_by_name(std::string_view name);
// Finds the format by the extension, in upper or lower case.
[[nodiscard]] std::optional<MeshFormat> mesh_format_by_path(const std::filesystem::path& path);

struct MeshWriteOptions {
  MeshFormat format = MeshFormat::glb;
  bool flat_normals = false;  // one normal per triangle; the mesh must have no vertex normals
  bool ascii = false;         // writes PLY or STL as text
  MeshPacking packing = {};   // DRC uses Draco compression in any case
  // The mesh has vertices at equal positions that exist only because their normals differ (mesh/shading_normals.hpp).
  // OBJ indexes normals per corner, so it writes each such position once. The other formats need one vertex per normal.
  bool has_vertex_copies_for_normals = false;
  // The placement of the mesh, for programs that read the file: a JSON object in one line of ASCII, or empty. PLY and
  // OBJ store it as a comment, glTF in the extras of its asset, DRC in its metadata.
  // Binary STL stores it in its header of 80 bytes; if the placement does not fit, the header only says
  // that one exists.
  // Text STL cannot store it.
  std::string placement = {};
  bool hash_files = false;  // fills WrittenFile::hash
};

struct WrittenFile {
  std::string path;  // "-" for standard output
  std::uint64_t bytes = 0;
  std::optional<std::string> hash =
      {};  // see files/content_hash.hpp; set if requested and known without reading the file back
};

struct MeshWriteResult {
  std::vector<WrittenFile> files;  // two for gltf: the model and its .bin
  Notes notes;                     // losses and changes (omitted or renamed attributes, rounding), one sentence each
  std::vector<PackedFacts> packed = {};  // one per mesh if packed; the default for a mesh without triangles
};

// Fails with ErrorCode::usage if the format does not support this packing, or if options contradict each other.
[[nodiscard]] Result<void> check_packing(const MeshPacking& packing, MeshFormat format);

// Returns the most bytes of meshes that a writer holds while more come. It holds the first mesh of
// a GLB in any case, since a file of one mesh has another layout.
[[nodiscard]] std::uint64_t most_held_bytes(const std::filesystem::path& path, const MeshWriteOptions& options,
                                            const Context& context);

// Writes one file (for .gltf a pair of files) from meshes that are added one after another. Opens nothing before the
// first mesh. finish() gives the file its name; a writer destroyed without finish() leaves no file behind.
//
// Formats with MeshFormatInfo::writes_each_mesh_at_once write each mesh in add() and free it. The others hold all
// meshes until finish(): a GLB begins with the offsets of all its data. Beyond 64 MiB or an eighth of the memory limit,
// a GLB of several unpacked meshes gets the data of each mesh in add(), and finish() moves all of it behind the JSON.
// Standard output, pipes and devices must receive no bytes if a later surface fails, so the writer also holds the
// meshes that add() gets for them. It holds them, too, if it quantizes positions and packing.box is unset: it needs the
// box of all.
class MeshWriter {
 public:
  MeshWriter(const std::filesystem::path& path, const MeshWriteOptions& options, const Context& context);
  MeshWriter(MeshWriter&&) noexcept;
  MeshWriter& operator=(MeshWriter&&) noexcept;
  ~MeshWriter();

  // Adds a mesh with its vertex normals and attributes. A note lists the attributes that the format cannot store; STL
  // drops vertex normals without a note. Fails with ErrorCode::usage if the format does not support the options, or if
  // it holds one mesh only and this is the second. Fails with ErrorCode::output if writing fails, if a vertex lies
  // outside packing.box, or if the unpacked mesh differs from the original. Fails with the same code if rounding would
  // destroy the mesh because it is far from the origin (write/coordinate_rounding.hpp). After a failure every later
  // call returns the first error.
  [[nodiscard]] Result<void> add(mesh::Mesh mesh);

  // Begins the only mesh of the file, whose parts take_part() writes. `head` is the mesh without its arrays and without
  // the values of its attributes; glTF also needs MeshShape::not_finite_attributes. Works for PLY, OBJ, STL and
  // unpacked glTF, in the original order, without an origin. A glTF must have 32-bit indices and no flat normals, an
  // OBJ no vertex copies for normals, OBJ and STL no attributes. Otherwise returns false: add() the whole mesh. Fails
  // like add(). If `ranks` is not null, these ranks write a binary PLY without flat normals or a GLB together: all of
  // them call it with the same mesh, each writes its parts, and all call finish(). Only rank 0 knows the hash.
  [[nodiscard]] Result<bool> begin_parts(mesh::Mesh head, const mesh::MeshShape& shape, Ranks* ranks = nullptr);
  // Prepares for vertices that come before begin_parts(), as mesh::MeshSink::begin_early() says; take_part() takes
  // them. Works for binary PLY without normals of faces and for glTF without normals, in a regular file.
  [[nodiscard]] Result<bool> begin_early(mesh::Mesh head, const mesh::MeshShape& estimate);
  // After begin_parts() returned true, part_passes() are the passes of mesh::MeshSink, begin_pass() comes before each
  // of them, and take_part() writes a part. They fail with ErrorCode::output, for STL and flat normals with
  // ErrorCode::out_of_memory, too. After a failure, every later call returns the first error, also finish(). A stream
  // gets bytes with the parts, and ends incomplete if a later part fails.
  [[nodiscard]] std::vector<mesh::PartPass> part_passes() const;
  [[nodiscard]] Result<void> begin_pass(std::size_t pass) const;
  [[nodiscard]] Result<void> take_part(const mesh::MeshPart& part) const;

  // Completes the file and gives it its name. Call once, last.
  [[nodiscard]] Result<MeshWriteResult> finish();

 private:
  friend Result<MeshWriteResult> write_meshes(std::span<const mesh::Mesh>, const std::filesystem::path&,
                                              const MeshWriteOptions&, const Context&);
  struct State;
  std::unique_ptr<State> state_;
};

// Writes a file from meshes that are all in memory. "-" is standard output.
[[nodiscard]] Result<MeshWriteResult> write_meshes(std::span<const mesh::Mesh> meshes,
                                                   const std::filesystem::path& path, const MeshWriteOptions& options,
                                                   const Context& context);

}  // namespace isoextract::mesh_io
