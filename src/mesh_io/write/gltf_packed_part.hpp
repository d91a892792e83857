// Packs a mesh with the extensions of glTF: its checked bytes, and their description for the JSON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/detail/meshopt_codec.hpp"
#include "mesh_io/mesh_packing.hpp"
#include "mesh_io/write/gltf_part.hpp"

namespace isoextract::mesh_io {

struct GltfPackedView {
  std::vector<std::byte> bytes;  // as stored in the file, without the padding before the next view
  std::uint64_t count = 0;       // of values
  std::size_t stride = 0;        // bytes of a decoded value; 0 for Draco's bit stream
  bool indices = false;
  std::optional<MeshoptMode> meshopt;  // unset: not compressed

  [[nodiscard]] std::uint64_t unpacked_bytes() const { return count * stride; }
};

struct GltfPackedAccessor {
  std::string semantic;             // empty for indices
  std::optional<std::size_t> view;  // unset for values that Draco decodes
  std::uint32_t draco_id = 0;
  int component = 0;  // a code of gltf_codes.hpp
  std::size_t components = 1;
  std::uint64_t count = 0;
  bool normalized = false;
  std::vector<double> min;  // set for positions
  std::vector<double> max;
};

struct GltfPackedPart {
  std::vector<GltfPackedView> views;
  std::vector<GltfPackedAccessor> attributes;
  std::optional<GltfPackedAccessor> indices;
  bool draco = false;  // the only view holds everything
  bool quantized = false;
  glm::dvec3 translation{0.0};  // of the node
  double scale = 1;
  PackedFacts facts;
  Reservation memory;  // for the bytes of the views

  [[nodiscard]] std::uint64_t bytes() const;
};

// Packs `part`, which has triangles and is not packed. packing.box must be set if positions are quantized. Fails as
// pack_with_draco() does.
[[nodiscard]] Result<GltfPackedPart> pack_part(const GltfPart& part, const MeshPacking& packing,
                                               const Context& context);

}  // namespace isoextract::mesh_io
