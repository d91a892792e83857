// The JSON of a glTF file: TinyGLTF's model, made of the parts whose bytes are written beside it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tiny_gltf.h>
#include <nlohmann/json.hpp>

#include "mesh/metrics.hpp"
#include "mesh_io/write/gltf_packed_part.hpp"
#include "mesh_io/write/gltf_part.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"

namespace isoextract::mesh_io {

// Collects views and accessors in the order in which write_part() writes their bytes.
class GltfModel {
 public:
  // `placement` as MeshWriteOptions has it.
  explicit GltfModel(std::string placement = {}) : placement_(std::move(placement)) {}

  // One node and, unless the part is without triangles, its mesh.
  void add(const GltfPart& part);

  // The JSON text. Its one buffer is described to the library's JSON afterwards, as the library would want its bytes.
  [[nodiscard]] std::string json(const std::string& uri, int indent, Notes& notes);

  // For files whose model is never held as a whole, in place of add() and json(). A node for the parts together, of
  // scale 0 where it is hidden, which no scene refers to yet: its number. Parts without triangles are left out, of
  // which not all may be.
  [[nodiscard]] int add_frame(const std::string& name, std::span<const GltfPart> parts, bool hidden);
  // What was added since the last call, and is forgotten then: its JSON, without scenes and buffers, and notes. Numbers
  // go on.
  void take(const std::function<void(nlohmann::json& document)>& look);
  [[nodiscard]] Notes take_notes();
  [[nodiscard]] std::uint64_t binary_bytes() const { return offset_; }
  // The buffer after the one of the file's bytes, which stands for what views are unpacked to; null where none are.
  [[nodiscard]] nlohmann::json unpacked_buffer() const;

 private:
  // How many of each were taken.
  struct Taken {
    std::size_t nodes = 0;
    std::size_t meshes = 0;
    std::size_t materials = 0;
    std::size_t views = 0;
    std::size_t accessors = 0;
  };

  // The number of the node.
  int node(const GltfPart& part);
  int push(tinygltf::Node node);
  // The number of the material of such a part; colours of vertices are multiplied with it.
  int material(const GltfPart& part);
  // A view of the next `bytes` bytes.
  int view(std::uint64_t bytes, int target, std::size_t stride = 0);
  int accessor(int view, std::size_t offset, int component, int type, std::uint64_t count);
  int vectors(int view, std::size_t offset, std::uint64_t count);
  int positions(int view, std::uint64_t count, const mesh::LocalBounds& bounds);
  void attributes(const GltfPart& part, tinygltf::Primitive& primitive);
  tinygltf::Primitive split(const GltfPart& part);
  tinygltf::Primitive indexed(const GltfPart& part);
  tinygltf::Primitive triangles(const GltfPart& part);

  // Of packed parts; gltf_packed_model.cpp.
  tinygltf::Primitive packed(const GltfPart& part);
  int packed_view(const GltfPackedView& source);
  int packed_accessor(const GltfPackedAccessor& source, int first_view);
  void use_extension(const std::string& name);
  // What the library has no members for.
  void describe_packed_views(nlohmann::json& document) const;

  tinygltf::Model model_;
  tinygltf::Scene scene_;
  Taken taken_;
  std::uint64_t offset_ = 0;
  struct MadeMaterial {
    bool vertex_colours;
    std::optional<mesh::Material> look;
    std::string name;  // that of the mesh, so that each grid and iso value can be given another look
    int number;
  };
  std::vector<MadeMaterial> materials_;
  bool has_split_ = false;
  std::string placement_;
  bool in_frame_ = false;  // the frames of a sequence share their materials, whatever their meshes are called
  struct MeshoptView {
    int view;  // of the buffer that is not there, and stands for what is unpacked
    std::uint64_t offset;
    std::uint64_t bytes;
    std::uint64_t count;
    std::size_t stride;
    MeshoptMode mode;
  };
  std::vector<MeshoptView> meshopt_views_;
  std::uint64_t unpacked_bytes_ = 0;  // of that buffer
  Notes notes_;                       // of the meshes' names
};

}  // namespace isoextract::mesh_io
