// The numbers of a glTF file: its buffers, and accessors as views of them; glTF 2.0, 3.6. Whatever is not as it should
// be is a DamagedMesh.
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

// Values that lie in memory, each a stride behind the one before.
struct GltfView {
  const std::byte* first = nullptr;
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
  int component = 0;
  bool normalised = false;  // integers that stand for 0 .. 1, or -1 .. 1 where they are signed

  // Of a view of VEC3: floats as they are, integers of at most 16 bits as what they stand for.
  [[nodiscard]] glm::dvec3 point(std::uint64_t index) const;
  // Of a view of SCALAR of an unsigned type.
  [[nodiscard]] std::uint32_t whole_number(std::uint64_t index) const;
  [[nodiscard]] bool has_whole_numbers() const {
    return component == kGltfUnsignedByte || component == kGltfUnsignedShort || component == kGltfUnsignedInt;
  }
};

class GltfData {
 public:
  // Loads the buffers: `binary` is that of a .glb, the others lie beside the file or in the model's text. `model` has
  // to stay.
  GltfData(const MeshSource& source, const nlohmann::json& model, std::span<const std::byte> binary);

  // An accessor of `type` ("VEC3") with so many components, all of whose values are there. Those of a sparse one are
  // put together here, once.
  [[nodiscard]] GltfView view(std::uint64_t accessor, std::string_view type, std::uint64_t components);

  // Unpacks a primitive that KHR_draco_mesh_compression packed, so that view() finds the values of its accessors. True
  // where no two of its triangles share a vertex: vertices then come three a triangle, and there is no use for indices.
  bool unpack_draco(const nlohmann::json& primitive);
  [[nodiscard]] bool is_unpacked(std::uint64_t accessor) const { return made_views_.contains(accessor); }

 private:
  void load_buffer(const nlohmann::json& buffer, std::uint64_t index, std::span<const std::byte> binary);
  [[nodiscard]] std::vector<std::byte> load_file(const std::string& name) const;
  // Places `view`, of values of `item` bytes, in the buffer view that `owner` names: an accessor or a part of one.
  void place(GltfView& view, const nlohmann::json& owner, std::uint64_t item);
  // The bytes of a buffer view, or of another object that names a buffer and a place in it.
  [[nodiscard]] std::span<const std::byte> range_of(const nlohmann::json& range) const;
  // A buffer view that EXT_meshopt_compression packed, unpacked once.
  [[nodiscard]] std::span<const std::byte> unpacked_view(std::uint64_t index, const nlohmann::json& packed);
  // What Draco packed into a buffer view, unpacked once; it stays where it is.
  struct UnpackedDraco {
    DracoSurface surface;
    bool is_soup = false;  // no two triangles share a vertex
  };
  [[nodiscard]] const UnpackedDraco& unpacked_draco(std::uint64_t view);
  // An accessor's values, which stay those of the attribute.
  void provide(std::uint64_t accessor, const DracoAttribute& attribute, std::uint64_t vertices);
  [[nodiscard]] GltfView with_sparse(const GltfView& dense, const nlohmann::json& sparse, std::uint64_t item);

  const MeshSource& source_;
  const nlohmann::json& model_;
  std::vector<std::vector<std::byte>> owned_;
  std::vector<std::span<const std::byte>> buffers_;
  std::map<std::uint64_t, GltfView> made_views_;                        // sparse and unpacked, by accessor
  std::map<std::uint64_t, std::span<const std::byte>> unpacked_views_;  // by buffer view
  std::map<std::uint64_t, UnpackedDraco> unpacked_draco_;               // likewise
};

}  // namespace isoextract::mesh_io
