// Loads the buffers of a glTF file and gives access to its accessors (glTF 2.0, 3.6). Throws DamagedMesh for invalid
// data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include "mesh/attributes.hpp"
#include "mesh_io/detail/draco_codec.hpp"
#include "mesh_io/detail/gltf_codes.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {

[[nodiscard]] std::optional<mesh::ComponentType> gltf_component(int code);

// Values in memory, `stride` bytes from one to the next.
struct GltfView {
  const std::byte* first = nullptr;
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
  int component = 0;
  bool normalized = false;  // integers that encode 0 .. 1, or -1 .. 1 if signed

  // Returns a VEC3 value: floats unchanged, integers of up to 16 bits decoded if normalized.
  [[nodiscard]] glm::dvec3 point(std::uint64_t index) const;
  // Returns a SCALAR value of an unsigned integer type.
  [[nodiscard]] std::uint32_t whole_number(std::uint64_t index) const;
  [[nodiscard]] bool has_whole_numbers() const {
    return component == kGltfUnsignedByte || component == kGltfUnsignedShort || component == kGltfUnsignedInt;
  }
};

class GltfData {
 public:
  // Loads the buffers: `binary` is the binary chunk of a .glb; other buffers are files beside it or data URIs.
  // `source`, `model` and the bytes of `binary` must outlive this object.
  GltfData(const MeshSource& source, const nlohmann::json& model, std::span<const std::byte> binary);

  // Returns the values of an accessor of `type` (such as "VEC3") with that many components, after checking that all lie
  // within their buffer. Builds the values of a sparse accessor on the first call.
  [[nodiscard]] GltfView view(std::uint64_t accessor, std::string_view type, std::uint64_t components);

  // Decodes a primitive that uses KHR_draco_mesh_compression, so that view() finds the values of its accessors. Does
  // nothing for other primitives, nor if the file also has the positions uncompressed.
  // Returns true only for a decoded primitive of which no two triangles share a vertex: then vertex 3t + c is corner c
  // of triangle t, and the indices are not needed.
  bool unpack_draco(const nlohmann::json& primitive);
  [[nodiscard]] bool is_unpacked(std::uint64_t accessor) const { return made_views_.contains(accessor); }

 private:
  void load_buffer(const nlohmann::json& buffer, std::uint64_t index, std::span<const std::byte> binary);
  [[nodiscard]] std::vector<std::byte> load_file(const std::string& name) const;
  // Points `view`, whose values have `item` bytes, at the buffer view that `owner` names. `owner` is an accessor, or
  // the indices or values of a sparse one.
  void place(GltfView& view, const nlohmann::json& owner, std::uint64_t item);
  // Returns the bytes of a buffer view, or of another object with a buffer, an offset and a length.
  [[nodiscard]] std::span<const std::byte> range_of(const nlohmann::json& range) const;
  // Returns the decoded bytes of a buffer view that uses EXT_meshopt_compression. Decodes on the first call.
  [[nodiscard]] std::span<const std::byte> unpacked_view(std::uint64_t index, const nlohmann::json& packed);
  // The surface that Draco decoded from a buffer view, cached. Its address is stable, since made_views_ points into it.
  struct UnpackedDraco {
    DracoSurface surface;
    bool is_soup = false;  // no two triangles share a vertex
  };
  [[nodiscard]] const UnpackedDraco& unpacked_draco(std::uint64_t view);
  // Makes view() return the attribute's values for the accessor, without copying them.
  void provide(std::uint64_t accessor, const DracoAttribute& attribute, std::uint64_t vertices);
  [[nodiscard]] GltfView with_sparse(const GltfView& dense, const nlohmann::json& sparse, std::uint64_t item);

  const MeshSource& source_;
  const nlohmann::json& model_;
  std::vector<std::vector<std::byte>> owned_;
  std::vector<std::span<const std::byte>> buffers_;
  std::map<std::uint64_t, GltfView> made_views_;  // of sparse and of decoded accessors, by accessor
  std::map<std::uint64_t, std::span<const std::byte>> unpacked_views_;  // by buffer view
  std::map<std::uint64_t, UnpackedDraco> unpacked_draco_;               // by buffer view
};

}  // namespace isoextract::mesh_io
