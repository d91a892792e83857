// The one door to the mesh formats; one file per format behind it (gltf_writer.cpp, ply_writer.cpp, ...).
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
#include "base/error.hpp"
#include "base/words.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_packing.hpp"

namespace isoextract::mesh_io {

enum class MeshFormat { glb, gltf, ply, obj, stl, drc };
constexpr auto words_of(MeshFormat /*type*/) {
  return std::array{Word{MeshFormat::glb, "glb"}, Word{MeshFormat::gltf, "gltf"}, Word{MeshFormat::ply, "ply"},
                    Word{MeshFormat::obj, "obj"}, Word{MeshFormat::stl, "stl"},   Word{MeshFormat::drc, "drc"}};
}

// In one file or two: y points up, lengths are metres, and there are materials.
[[nodiscard]] bool is_gltf(MeshFormat format);

// One row a format: detection, help and README read it.
struct MeshFormatInfo {
  MeshFormat format;
  std::string_view name;      // also the extension, without its dot
  std::string_view title;     // "glTF 2.0, one binary file"
  bool holds_several_meshes;  // several iso values fit into one file
  bool writes_as_they_come;   // a mesh is written, and may go, before there is a next one; else all are held
  bool can_stream;            // may be written to standard output
  bool has_ascii;             // it can be text
  bool has_attributes;        // vertices may have more than a place and a normal
  bool rounds_world;          // positions are float32 numbers of the world; else they keep an origin, or more digits
};
[[nodiscard]] std::span<const MeshFormatInfo> mesh_formats();
// ".glb, .gltf, .ply, .obj, .stl or .drc"
[[nodiscard]] std::string mesh_extensions();
[[nodiscard]] const MeshFormatInfo& mesh_format_info(MeshFormat format);
[[nodiscard]] std::optional<MeshFormat> mesh_format_by_name(std::string_view name);
// By extension, whatever its case.
[[nodiscard]] std::optional<MeshFormat> mesh_format_by_path(const std::filesystem::path& path);

struct MeshWriteOptions {
  MeshFormat format = MeshFormat::glb;
  bool flat_normals = false;  // one normal a triangle, from its corners; exclusive with vertex normals in the mesh
  bool ascii = false;         // PLY and STL as text
  MeshPacking packing = {};   // DRC is Draco's whatever it says
  // Vertices at one place whose normals differ are copies for those normals' sake (mesh/shading_normals.hpp). OBJ,
  // whose corners have normals of their own, writes that place once; the other formats need a vertex for each normal.
  bool copies_for_normals = false;
  // Where the mesh is, for whoever reads it again: a JSON object in one line of ASCII, or nothing. PLY and OBJ keep it
  // as a comment, glTF in the extras of its asset, DRC in its metadata, binary STL in its header of 80 bytes, which may
  // have room only to say that there is one; STL as text cannot.
  std::string placement = {};
  bool hash_files = false;  // WrittenFile::hash
};

struct WrittenFile {
  std::string path;  // "-" for standard output
  std::uint64_t bytes = 0;
  std::optional<std::string> hash = {};  // files/content_hash.hpp; where it was asked for and is known without reading
};

struct MeshWriteResult {
  std::vector<WrittenFile> files;        // glTF writes two: the model and its .bin
  std::vector<std::string> notes;        // what the format could not hold, one sentence each
  std::vector<PackedFacts> packed = {};  // one a mesh where they were packed; of a mesh without triangles nothing is
};

// What the format cannot do of it, or what makes no sense together, is ErrorCode::usage.
[[nodiscard]] Result<void> check_packing(const MeshPacking& packing, MeshFormat format);

// One file (or, for .gltf, one pair of files) that takes its meshes one after another. Nothing is opened before the
// first mesh, and the file gets its name in finish(): a writer that goes without it leaves nothing behind.
//
// OBJ and .gltf with its .bin are written as the meshes come: after add() a mesh is gone. The file of a GLB begins with
// where everything in it is, so its meshes are held until finish(); writing them to another file meanwhile and copying
// that would be writing everything twice. Meshes are held for standard output, pipes and devices too: nothing can be
// taken back there, and where a later surface fails they shall get nothing. So they are, too, where their positions
// are quantised in a box that is not given: it is the one around all of them.
class MeshWriter {
 public:
  MeshWriter(const std::filesystem::path& path, const MeshWriteOptions& options, const Context& context);
  MeshWriter(MeshWriter&&) noexcept;
  MeshWriter& operator=(MeshWriter&&) noexcept;
  ~MeshWriter();

  // Vertex normals and attributes are written where the mesh has them, or noted where the format cannot hold them.
  // Fails with ErrorCode::output, also where the mesh is so far from the origin of its coordinates that the numbers of
  // the format would destroy its triangles (write/written_places.hpp says when), where it is outside of the box of its
  // packing, or where what was packed does not come back; or with ErrorCode::usage for what the format cannot do. Then
  // every later call fails alike.
  [[nodiscard]] Result<void> add(mesh::Mesh mesh);

  // Writes what comes after the last mesh and commits. Call once, last.
  [[nodiscard]] Result<MeshWriteResult> finish();

 private:
  friend Result<MeshWriteResult> write_meshes(std::span<const mesh::Mesh>, const std::filesystem::path&,
                                              const MeshWriteOptions&, const Context&);
  struct State;
  std::unique_ptr<State> state_;
};

// All of a file at once, for whoever has all meshes anyway. "-" is standard output.
[[nodiscard]] Result<MeshWriteResult> write_meshes(std::span<const mesh::Mesh> meshes,
                                                   const std::filesystem::path& path, const MeshWriteOptions& options,
                                                   const Context& context);

}  // namespace isoextract::mesh_io
