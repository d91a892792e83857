// A mesh as glTF's extensions pack it: its bytes, made and checked when the part is, and what the JSON says of them.
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
  std::vector<std::byte> bytes;  // as they lie in the file, up to the next view's alignment
  std::uint64_t count = 0;       // of values
  std::size_t stride = 0;        // of a value, unpacked; 0 for Draco's bytes, which are no values
  bool indices = false;
  std::optional<MeshoptMode> meshopt;  // how it is packed; nothing: it is not

  [[nodiscard]] std::uint64_t unpacked_bytes() const { return count * stride; }
};

struct GltfPackedAccessor {
  std::string semantic;             // empty for indices
  std::optional<std::size_t> view;  // nothing for what Draco unpacks
  std::uint32_t draco_id = 0;
  int component = 0;  // as glTF numbers them
  std::size_t components = 1;
  std::uint64_t count = 0;
  bool normalised = false;
  std::vector<double> min;  // of positions
  std::vector<double> max;
};

struct GltfPackedPart {
  std::vector<GltfPackedView> views;
  std::vector<GltfPackedAccessor> attributes;
  std::optional<GltfPackedAccessor> indices;
  bool draco = false;  // the one view holds it all
  bool quantized = false;
  glm::dvec3 translation{0.0};  // of the node
  double scale = 1;
  PackedFacts facts;

  [[nodiscard]] std::uint64_t bytes() const;
};

// `part` is not packed, and has triangles. packing.box is there where positions are quantised. Fails as
// pack_with_draco() does.
[[nodiscard]] Result<GltfPackedPart> pack_part(const GltfPart& part, const MeshPacking& packing,
                                               const Context& context);

}  // namespace isoextract::mesh_io
