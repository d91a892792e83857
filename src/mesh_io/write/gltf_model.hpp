// Builds the JSON of a glTF file as a TinyGLTF model. write_part() writes the bytes of the parts separately.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include <tiny_gltf.h>
#include <nlohmann/json.hpp>

#include "mesh/metrics.hpp"
#include "mesh_io/write/gltf_packed_part.hpp"
#include "mesh_io/write/gltf_part.hpp"
#include "mesh_io/write/json_lists.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"

namespace isoextract::mesh_io {

// Collects buffer views and accessors in the order in which write_part() writes their bytes.
class GltfModel {
 public:
  // `placement` is MeshWriteOptions::placement.
  explicit GltfModel(std::string placement = {}) : placement_(std::move(placement)) {}

  // Adds a node and, if the part has triangles, its mesh. A model of many meshes becomes JSON text bit by bit: TinyGLTF
  // needs ten times the memory.
  void add(const GltfPart& part);

  // Returns the JSON text and appends notes. `uri` names the file of the buffer; empty in a GLB. `indent` -1 gives one
  // line. Describes the buffer in the finished JSON, because TinyGLTF would need the buffer's bytes to describe it.
  [[nodiscard]] std::string json(const std::string& uri, int indent, Notes& notes);

  // Adds one node for all parts of a frame and returns its number; no scene refers to it yet. A hidden node has scale
  // 0. Skips parts without triangles, but at least one part must have triangles.
  // Used with flush() instead of add() and json() for files whose model is never complete in memory.
  [[nodiscard]] int add_frame(const std::string& name, std::span<const GltfPart> parts, bool hidden);
  // Calls look() with the JSON of everything added since the last flush(), without scenes and buffers; then forgets it.
  // Later nodes, meshes and accessors continue the numbering.
  void flush(const std::function<void(nlohmann::json& document)>& look);
  [[nodiscard]] Notes release_notes();
  [[nodiscard]] std::uint64_t binary_bytes() const { return offset_; }
  // Returns the second buffer of the file, a placeholder for the bytes that compressed views decode to
  // (EXT_meshopt_compression); null if no view is compressed.
  [[nodiscard]] nlohmann::json unpacked_buffer() const;

 private:
  // The number of entries of each list that take_portion() has moved out.
  struct Taken {
    std::size_t nodes = 0;
    std::size_t meshes = 0;
    std::size_t materials = 0;
    std::size_t views = 0;
    std::size_t accessors = 0;
  };

  struct MeshoptView {
    int view;  // into the placeholder buffer for decoded bytes
    std::uint64_t offset;
    std::uint64_t bytes;
    std::uint64_t count;
    std::size_t stride;
    MeshoptMode mode;
  };

  // A range of consecutive entries of the model.
  struct Portion {
    tinygltf::Model model;
    std::vector<MeshoptView> meshopt_views;
    std::size_t first_view;
  };

  // Moves the entries that were added since the last call out of model_.
  [[nodiscard]] Portion take_portion();
  // Returns the JSON of a portion, without buffers.
  [[nodiscard]] nlohmann::json document_of(Portion& portion) const;
  // Appends the JSON of portions_ to earlier_. Runs in parallel.
  void convert_portions();

  // Adds the part's node and mesh; returns the node's number.
  int node(const GltfPart& part);
  int push(tinygltf::Node node);
  // Returns the number of the part's material, adding it if it is new. Viewers multiply vertex colors with it.
  int material(const GltfPart& part);
  // Adds a buffer view of the next `bytes` bytes.
  int view(std::uint64_t bytes, int target, std::size_t stride = 0);
  int accessor(int view, std::size_t offset, int component, int type, std::uint64_t count);
  int vectors(int view, std::size_t offset, std::uint64_t count);
  int positions(int view, std::uint64_t count, const mesh::LocalBounds& bounds);
  void attributes(const GltfPart& part, tinygltf::Primitive& primitive);
  tinygltf::Primitive split(const GltfPart& part);
  tinygltf::Primitive indexed(const GltfPart& part);
  tinygltf::Primitive triangles(const GltfPart& part);

  // Adds the data of a packed part (gltf_packed_model.cpp).
  tinygltf::Primitive packed(const GltfPart& part);
  int packed_view(const GltfPackedView& source);
  int packed_accessor(const GltfPackedAccessor& source, int first_view);
  void use_extension(const std::string& name);
  // Adds the packed views to the JSON, because TinyGLTF cannot describe them.
  static void describe_packed_views(const Portion& portion, nlohmann::json& document);

  tinygltf::Model model_;
  tinygltf::Scene scene_;
  Taken taken_;
  std::vector<Portion> portions_;  // the entries that add() has moved out of model_, unless earlier_ has them
  JsonLists earlier_;
  std::uint64_t offset_ = 0;
  struct MaterialEntry {
    bool vertex_colors;
    std::optional<mesh::Material> look;
    int number;
  };
  // By the mesh's name, so that each grid, iso value and label has its own material to edit.
  std::unordered_map<std::string, std::vector<MaterialEntry>> materials_;
  bool has_split_ = false;
  std::string placement_;
  bool in_frame_ = false;  // frames of a sequence share materials, whatever the names of their meshes
  std::vector<MeshoptView> meshopt_views_;
  std::uint64_t unpacked_bytes_ = 0;  // size of the placeholder buffer
  Notes notes_;                       // about the meshes' names
};

}  // namespace isoextract::mesh_io
