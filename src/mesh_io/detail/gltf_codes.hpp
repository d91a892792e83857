// Numeric codes of glTF component types (glTF 2.0, 3.6.2.2) and names of the supported packing extensions.
#pragma once

#include "mesh/attributes.hpp"

namespace isoextract::mesh_io {

inline constexpr int kGltfByte = 5120;
inline constexpr int kGltfUnsignedByte = 5121;
inline constexpr int kGltfShort = 5122;
inline constexpr int kGltfUnsignedShort = 5123;
inline constexpr int kGltfUnsignedInt = 5125;
inline constexpr int kGltfFloat = 5126;

// Returns the code for a type that glTF allows for vertex attributes; kGltfFloat for all other types.
[[nodiscard]] constexpr int gltf_code(mesh::ComponentType type) {
  using Type = mesh::ComponentType;
  switch (type) {
    case Type::i8: return kGltfByte;
    case Type::u8: return kGltfUnsignedByte;
    case Type::i16: return kGltfShort;
    case Type::u16: return kGltfUnsignedShort;
    default: return kGltfFloat;
  }
}

// Extensions that compress or quantize meshes.
inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";
inline constexpr const char* kQuantizationExtension = "KHR_mesh_quantization";
inline constexpr const char* kMeshoptExtension = "EXT_meshopt_compression";

}  // namespace isoextract::mesh_io
