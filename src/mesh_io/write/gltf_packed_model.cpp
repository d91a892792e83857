// The JSON of packed meshes: KHR_draco_mesh_compression, KHR_mesh_quantization, EXT_meshopt_compression.
#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>

#include "mesh_io/detail/gltf_codes.hpp"
#include "mesh_io/write/gltf_model.hpp"

namespace isoextract::mesh_io {

tinygltf::Primitive GltfModel::packed(const GltfPart& whole) {
  const GltfPackedPart& part = *whole.packed;
  tinygltf::Primitive primitive = triangles(whole);
  const int first_view = static_cast<int>(taken_.views + model_.bufferViews.size());
  for (const GltfPackedView& source : part.views) packed_view(source);
  tinygltf::Value::Object ids;
  for (const GltfPackedAccessor& attribute : part.attributes) {
    primitive.attributes[attribute.semantic] = packed_accessor(attribute, first_view);
    ids[attribute.semantic] = tinygltf::Value(static_cast<int>(attribute.draco_id));
  }
  if (part.indices) primitive.indices = packed_accessor(*part.indices, first_view);
  if (part.quantized) use_extension(kQuantizationExtension);
  if (part.draco) {
    use_extension(kDracoExtension);
    tinygltf::Value::Object draco;
    draco["bufferView"] = tinygltf::Value(first_view);
    draco["attributes"] = tinygltf::Value(std::move(ids));
    primitive.extensions[kDracoExtension] = tinygltf::Value(std::move(draco));
  }
  return primitive;
}

int GltfModel::packed_view(const GltfPackedView& source) {
  const int target = source.stride == 0 ? 0
                     : source.indices   ? TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER
                                        : TINYGLTF_TARGET_ARRAY_BUFFER;
  const std::uint64_t offset = offset_;
  const int index = view(source.bytes.size(), target, source.indices ? 0 : source.stride);
  if (!source.meshopt) return index;
  use_extension(kMeshoptExtension);
  meshopt_views_.push_back({index, offset, source.bytes.size(), source.count, source.stride, *source.meshopt});
  tinygltf::BufferView& unpacked = model_.bufferViews.back();
  unpacked.buffer = 1;
  unpacked.byteOffset = unpacked_bytes_;
  unpacked.byteLength = source.unpacked_bytes();
  unpacked_bytes_ += gltf_aligned(source.unpacked_bytes());
  return index;
}

int GltfModel::packed_accessor(const GltfPackedAccessor& source, int first_view) {
  constexpr std::array kTypes{TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4};
  const int where = source.view ? first_view + static_cast<int>(*source.view) : -1;
  const int index = accessor(where, 0, source.component, kTypes[source.components - 1], source.count);
  tinygltf::Accessor& made = model_.accessors.back();
  made.normalized = source.normalized;
  made.minValues = source.min;
  made.maxValues = source.max;
  return index;
}

// Programs that do not support these extensions cannot read the file, so they are required.
void GltfModel::use_extension(const std::string& name) {
  auto& used = model_.extensionsUsed;
  if (std::find(used.begin(), used.end(), name) != used.end()) return;
  used.push_back(name);
  model_.extensionsRequired.push_back(name);
}

void GltfModel::describe_packed_views(const Portion& portion, nlohmann::json& document) {
  for (const MeshoptView& view : portion.meshopt_views) {
    const std::size_t number = static_cast<std::size_t>(view.view) - portion.first_view;
    nlohmann::json& packed = document["bufferViews"][number]["extensions"][kMeshoptExtension];
    packed = {{"buffer", 0},
              {"byteOffset", view.offset},
              {"byteLength", view.bytes},
              {"byteStride", view.stride},
              {"count", view.count},
              {"mode", meshopt_word(view.mode)}};
  }
}

nlohmann::json GltfModel::unpacked_buffer() const {
  if (unpacked_bytes_ == 0) return nullptr;
  return {{"byteLength", unpacked_bytes_}, {"extensions", {{kMeshoptExtension, {{"fallback", true}}}}}};
}

}  // namespace isoextract::mesh_io
