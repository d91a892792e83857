#include "mesh_io/write/gltf_packed_part.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>
#include <type_traits>
#include <utility>

#include "mesh_io/detail/gltf_codes.hpp"
#include "mesh_io/write/draco_packing.hpp"
#include "mesh_io/write/mesh_encoding.hpp"
#include "mesh_io/write/position_lattice.hpp"

namespace isoextract::mesh_io {
namespace {

using ShortVector = glm::vec<3, std::uint16_t>;
using ByteVector = glm::vec<3, std::int8_t>;

// A normalized signed byte b encodes b / 127 (glTF 2.0, 3.6.2.2).
constexpr float kByteOne = 127;

// Makes the views and accessors of a mesh that is quantized, compressed by meshoptimizer, or both. Values keep their
// order.
class ViewPacking {
 public:
  ViewPacking(const GltfPart& part, const MeshPacking& packing) : part_(part), packing_(packing) {}

  Result<GltfPackedPart> pack() {
    TRY(packing_.quantize ? add_short_positions() : add_float_positions());
    add_normals();
    for (const GltfSemantic& semantic : part_.semantics) add_attribute(semantic);
    if (part_.layout == GltfPart::Layout::indexed) {
      TRY(add_indices());
    }
    if (damaged_) {
      return fail(ErrorCode::output, "the mesh that meshoptimizer unpacks differs from the original mesh");
    }
    return std::move(packed_);
  }

 private:
  [[nodiscard]] const mesh::Mesh& mesh() const { return *part_.mesh; }
  [[nodiscard]] bool split() const { return part_.layout == GltfPart::Layout::split; }
  [[nodiscard]] std::size_t vertex(std::size_t v) const {
    return split() ? mesh().triangles[v / 3][static_cast<int>(v % 3)] : v;
  }

  // Adds a view of value_at(v) for every vertex, each aligned to four bytes.
  template <class ValueAt>
  GltfPackedAccessor& add_values(const std::string& semantic, int component, const ValueAt& value_at) {
    using Value = std::invoke_result_t<ValueAt, std::size_t>;
    constexpr std::size_t kStride = gltf_aligned(sizeof(Value));
    std::vector<std::byte> raw(part_.vertex_count() * kStride);
    for (std::size_t v = 0; v < part_.vertex_count(); ++v) {
      const Value value = value_at(v);
      std::memcpy(raw.data() + v * kStride, &value, sizeof value);
    }
    return add_view(semantic, component, 3, std::move(raw), kStride);
  }

  GltfPackedAccessor& add_view(const std::string& semantic, int component, std::size_t components,
                               std::vector<std::byte> raw, std::size_t stride) {
    GltfPackedView view;
    view.count = part_.vertex_count();
    view.stride = stride;
    view.bytes = packing_.compression == Compression::meshopt ? packed_values(raw, view) : std::move(raw);
    packed_.views.push_back(std::move(view));
    GltfPackedAccessor accessor;
    accessor.semantic = semantic;
    accessor.view = packed_.views.size() - 1;
    accessor.component = component;
    accessor.components = components;
    accessor.count = part_.vertex_count();
    return packed_.attributes.emplace_back(std::move(accessor));
  }

  std::vector<std::byte> packed_values(const std::vector<std::byte>& raw, GltfPackedView& view) {
    view.meshopt = MeshoptMode::attributes;
    std::vector<std::byte> bytes = encode_meshopt_values(raw, view.stride);
    std::vector<std::byte> unpacked(raw.size());
    damaged_ = damaged_ || !decode_meshopt(bytes, {MeshoptMode::attributes, {}, view.count, view.stride}, unpacked) ||
               unpacked != raw;
    return bytes;
  }

  // Sets min and max of the positions as stored in the file.
  template <class Vector>
  static void set_bounds(GltfPackedAccessor& accessor, const Vector& low, const Vector& high) {
    for (int axis = 0; axis < 3; ++axis) {
      accessor.min.push_back(static_cast<double>(low[axis]));
      accessor.max.push_back(static_cast<double>(high[axis]));
    }
  }

  Result<void> add_float_positions() {
    packed_.translation = mesh().origin;
    glm::vec3 low = mesh().positions[vertex(0)];
    glm::vec3 high = low;
    GltfPackedAccessor& accessor = add_values("POSITION", kGltfFloat, [&](std::size_t v) {
      const glm::vec3 position = mesh().positions[vertex(v)];
      low = glm::min(low, position);
      high = glm::max(high, position);
      return position;
    });
    set_bounds(accessor, low, high);
    return {};
  }

  Result<void> add_short_positions() {
    const PositionLattice lattice = choose_lattice(packing_, *packing_.box, LatticeUse::short_positions);
    const auto on_lattice = TRY(round_to_lattice(mesh(), lattice));
    packed_.quantized = true;
    packed_.translation = lattice.origin;
    packed_.scale = lattice.step;
    packed_.facts.positions = on_lattice.facts;
    packed_.facts.flattened_triangles = on_lattice.flattened_triangles;
    ShortVector low(on_lattice.numbers[vertex(0)]);
    ShortVector high = low;
    GltfPackedAccessor& accessor = add_values("POSITION", kGltfUnsignedShort, [&](std::size_t v) {
      const ShortVector position(on_lattice.numbers[vertex(v)]);
      low = glm::min(low, position);
      high = glm::max(high, position);
      return position;
    });
    set_bounds(accessor, low, high);
    return {};
  }

  void add_normals() {
    if (!split() && mesh().normals.empty()) return;
    const auto normal_at = [&](std::size_t v) {
      return split() ? face_normal(mesh(), mesh().triangles[v / 3]) : mesh().normals[v];
    };
    if (!packing_.quantize) {
      add_values("NORMAL", kGltfFloat, normal_at);
      return;
    }
    double largest_turn = 0;
    GltfPackedAccessor& accessor = add_values("NORMAL", kGltfByte, [&](std::size_t v) {
      const glm::vec3 normal = normal_at(v);
      const ByteVector rounded(glm::round(glm::clamp(normal, -1.0F, 1.0F) * kByteOne));
      largest_turn = std::max(largest_turn, degrees_between(normal, rounded));
      return rounded;
    });
    accessor.normalized = true;
    packed_.facts.largest_normal_angle = largest_turn;
  }

  void add_attribute(const GltfSemantic& semantic) {
    const mesh::Attribute& attribute = *semantic.attribute;
    std::vector<std::byte> raw(part_.vertex_count() * semantic.stride());
    for (std::size_t v = 0; v < part_.vertex_count(); ++v) {
      std::memcpy(raw.data() + v * semantic.stride(), attribute.at(vertex(v)).data(), attribute.stride());
    }
    add_view(semantic.name, gltf_code(attribute.type), attribute.components, std::move(raw), semantic.stride())
        .normalized = attribute.normalized;
  }

  Result<void> add_indices() {
    const auto triangles = mesh().triangles.span();
    GltfPackedView view;
    view.indices = true;
    view.count = 3 * triangles.size();
    view.stride = part_.short_indices ? sizeof(std::uint16_t) : sizeof(std::uint32_t);
    if (packing_.compression == Compression::meshopt) {
      view.meshopt = MeshoptMode::triangles;
      const std::span<const std::uint32_t> indices(&triangles.data()->x, view.count);
      view.bytes = encode_meshopt_triangles(indices, mesh().positions.size());
      check_triangles(view);
    } else if (part_.short_indices) {
      view.bytes.resize(view.count * view.stride);
      char* out = reinterpret_cast<char*>(view.bytes.data());
      for (const glm::uvec3& triangle : triangles) out = put_bytes(out, ShortVector(triangle));
    } else {
      const auto bytes = std::as_bytes(triangles);
      view.bytes.assign(bytes.begin(), bytes.end());
    }
    packed_.views.push_back(std::move(view));
    GltfPackedAccessor accessor;
    accessor.view = packed_.views.size() - 1;
    accessor.component = part_.short_indices ? kGltfUnsignedShort : kGltfUnsignedInt;
    accessor.count = 3 * triangles.size();
    packed_.indices = std::move(accessor);
    return {};
  }

  // Checks that decoding gives the same triangles in the same order, up to a rotation of their corners.
  void check_triangles(const GltfPackedView& view) {
    std::vector<glm::uvec3> unpacked(mesh().triangles.size());
    const MeshoptView all{MeshoptMode::triangles, {}, view.count, sizeof(std::uint32_t)};
    damaged_ = damaged_ || !decode_meshopt(view.bytes, all, std::as_writable_bytes(std::span(unpacked)));
    const auto same = [](const glm::uvec3& a, const glm::uvec3& b) {
      return a == b || glm::uvec3(a.y, a.z, a.x) == b || glm::uvec3(a.z, a.x, a.y) == b;
    };
    damaged_ = damaged_ || !std::equal(unpacked.begin(), unpacked.end(), mesh().triangles.begin(), same);
  }

  const GltfPart& part_;
  const MeshPacking& packing_;
  GltfPackedPart packed_;
  bool damaged_ = false;
};

Result<GltfPackedPart> pack_draco(const GltfPart& part, const MeshPacking& packing, const Context& context) {
  DracoPacking draco;
  draco.lattice = choose_lattice(packing, *packing.box, LatticeUse::float_positions);
  draco.flat_normals = part.layout == GltfPart::Layout::split;
  draco.semantics = part.semantics;
  auto made = TRY(pack_with_draco(*part.mesh, draco, context));

  GltfPackedPart packed;
  packed.draco = true;
  packed.translation = draco.lattice.origin;
  packed.facts = made.facts;
  packed.memory = TRY(context.reserve(made.bytes.size(), "the packed mesh"));
  packed.views.emplace_back().bytes = std::move(made.bytes);
  const auto add = [&](const std::string& semantic, int component, std::size_t components) -> GltfPackedAccessor& {
    GltfPackedAccessor accessor;
    accessor.semantic = semantic;
    accessor.draco_id = static_cast<std::uint32_t>(packed.attributes.size());
    accessor.component = component;
    accessor.components = components;
    accessor.count = made.vertices;
    return packed.attributes.emplace_back(std::move(accessor));
  };
  GltfPackedAccessor& positions = add("POSITION", kGltfFloat, 3);
  for (int axis = 0; axis < 3; ++axis) {
    positions.min.push_back(static_cast<double>(made.bounds.min[axis]));
    positions.max.push_back(static_cast<double>(made.bounds.max[axis]));
  }
  if (made.has_normals) add("NORMAL", kGltfFloat, 3);
  for (const GltfSemantic& semantic : part.semantics) {
    const mesh::Attribute& attribute = *semantic.attribute;
    add(semantic.name, gltf_code(attribute.type), attribute.components).normalized = attribute.normalized;
  }
  GltfPackedAccessor indices;
  indices.component = made.vertices <= GltfPart::kMaxShortVertices ? kGltfUnsignedShort : kGltfUnsignedInt;
  indices.count = 3 * part.mesh->triangles.size();
  packed.indices = std::move(indices);
  return packed;
}

Result<GltfPackedPart> pack_views(const GltfPart& part, const MeshPacking& packing, const Context& context) {
  // All values, and at most as much again for the packed and for the unpacked copy.
  constexpr std::uint64_t kLatticeBytes = 16;
  const std::uint64_t bytes = 3 * part.bytes() + part.mesh->positions.size() * kLatticeBytes;
  auto memory = TRY(context.reserve(bytes, "packing it"));
  auto packed = TRY(ViewPacking(part, packing).pack());
  packed.memory = std::move(memory);
  packed.memory.shrink(packed.bytes());
  return packed;
}

}  // namespace

std::uint64_t GltfPackedPart::bytes() const {
  std::uint64_t sum = 0;
  for (const GltfPackedView& view : views) sum += gltf_aligned(view.bytes.size());
  return sum;
}

Result<GltfPackedPart> pack_part(const GltfPart& part, const MeshPacking& packing, const Context& context) {
  const Stopwatch watch;
  auto packed = packing.compression == Compression::draco ? pack_draco(part, packing, context)
                                                          : pack_views(part, packing, context);
  if (!packed) return packed;
  packed->facts.bytes_before = part.bytes();
  packed->facts.bytes_after = packed->bytes();
  packed->facts.time = watch.elapsed();
  return packed;
}

}  // namespace isoextract::mesh_io
