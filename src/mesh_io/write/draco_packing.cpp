#include "mesh_io/write/draco_packing.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/hash.hpp"
#include "base/version.hpp"
#include "mesh_io/detail/draco_codec.hpp"
#include "mesh_io/write/mesh_encoding.hpp"
#include "mesh_io/write/surface_match.hpp"

namespace isoextract::mesh_io {
namespace {

// Memory for Draco's meshes and corner tables while packing and unpacking, and for the comparison. Measured peaks are
// about two thirds of this (94 and 69 bytes for a gyroid of 1.5 million triangles).
constexpr std::uint64_t kPackedTriangleBytes = 144;
constexpr std::uint64_t kPackedVertexBytes = 96;

std::uint64_t hash_of(std::span<const std::byte> value, std::uint64_t seed) {
  for (std::size_t at = 0; at < value.size(); at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, value.data() + at, std::min(sizeof word, value.size() - at));
    seed = splitmix64(seed + word);
  }
  return seed;
}

std::uint64_t hash_of(const glm::uvec3& n) { return splitmix64(splitmix64(splitmix64(n.x) + n.y) + n.z); }

// Compares a mesh with its unpacked form. With face normals, "vertex" means a triangle corner.
class Comparison {
 public:
  Comparison(const mesh::Mesh& mesh, const DracoPacking& packing, const DracoInput& input, const DracoSurface& unpacked)
      : mesh_(mesh), packing_(packing), input_(input), unpacked_(unpacked) {}

  // Returns nullopt if they differ.
  std::optional<DracoPacked> compare() {
    const DracoAttribute* positions = unpacked_.find(kDracoPositions);
    const DracoAttribute* normals = input_.normals.empty() ? nullptr : unpacked_.find(kDracoPositions + 1);
    if (unpacked_.vertices != vertices() || positions == nullptr || !positions->is_position ||
        (normals == nullptr) != input_.normals.empty()) {
      return std::nullopt;
    }
    const auto positions_at = [&](std::size_t v) { return vector_at(*positions, v); };
    auto colors = unpacked_colors(*positions);
    if (!colors) return std::nullopt;
    const auto same =
        match_colored_vertices({mesh_colors(), mesh_triangles()}, {std::move(*colors), unpacked_.triangles});
    if (!same) return std::nullopt;

    DracoPacked packed;
    packed.vertices = unpacked_.vertices;
    packed.has_normals = normals != nullptr;
    PackedFacts::Positions measured{packing_.lattice.bits, packing_.lattice.step, 0, 0};
    packed.bounds = {positions_at(0), positions_at(0)};
    double largest_turn = 0;
    for (std::size_t first = 0; first < same->a.size(); first = same->end_of_group(first)) {
      const std::size_t end = same->end_of_group(first);
      for (std::size_t i = first; i < end; ++i) {
        const glm::vec3 local = positions_at(same->b[i].number);
        packed.bounds = {glm::min(packed.bounds.min, local), glm::max(packed.bounds.max, local)};
        const glm::dvec3 by = glm::abs(packing_.lattice.origin + glm::dvec3(local) - position(same->a[i].number));
        measured.largest_axis_move = std::max({measured.largest_axis_move, by.x, by.y, by.z});
        measured.largest_move = std::max(measured.largest_move, glm::length(by));
        if (normals == nullptr) continue;
        largest_turn =
            std::max(largest_turn, smallest_normal_angle(*same, first, end, vector_at(*normals, same->b[i].number)));
      }
    }
    packed.facts.positions = measured;
    if (normals != nullptr) packed.facts.largest_normal_angle = largest_turn;
    return packed;
  }

 private:
  [[nodiscard]] std::size_t vertices() const {
    return input_.face_normals ? 3 * mesh_.triangles.size() : mesh_.positions.size();
  }
  // Returns the mesh vertex of `v`, which is a vertex or, with face normals, a corner.
  [[nodiscard]] std::size_t vertex(std::size_t v) const {
    return input_.face_normals ? mesh_.triangles[v / 3][static_cast<int>(v % 3)] : v;
  }
  [[nodiscard]] glm::dvec3 position(std::size_t v) const { return mesh_.position(vertex(v)); }

  static glm::vec3 vector_at(const DracoAttribute& attribute, std::size_t v) {
    glm::vec3 value;
    std::memcpy(&value, attribute.values.data() + v * sizeof value, sizeof value);
    return value;
  }

  // Returns the smallest angle in degrees between `normal` and the normals of the group. Vertices of a group are
  // interchangeable, so the best match counts.
  [[nodiscard]] double smallest_normal_angle(const VertexMatch& same, std::size_t first, std::size_t end,
                                             const glm::vec3& normal) const {
    constexpr std::size_t kMostTried = 32;
    double least = 180;
    for (std::size_t i = first; i < std::min(end, first + kMostTried); ++i) {
      const std::size_t number = same.a[i].number;
      least = std::min(least, degrees_between(input_.normals[input_.face_normals ? number / 3 : number], normal));
    }
    return least;
  }

  std::vector<std::uint64_t> mesh_colors() const {
    std::vector<std::uint64_t> colors(vertices());
    for (std::size_t v = 0; v < colors.size(); ++v) {
      std::uint64_t color = hash_of(input_.positions[vertex(v)]);
      for (const mesh::Attribute* attribute : input_.attributes) color = hash_of(attribute->at(vertex(v)), color);
      colors[v] = color;
    }
    return colors;
  }

  // Returns nullopt if a position is not a lattice point, or an attribute is missing or of another type.
  std::optional<std::vector<std::uint64_t>> unpacked_colors(const DracoAttribute& positions) const {
    std::vector<std::uint64_t> colors(unpacked_.vertices);
    for (std::size_t v = 0; v < colors.size(); ++v) {
      const glm::vec3 p = vector_at(positions, v);
      const glm::vec3 steps = (p - input_.first) / input_.step;
      const bool counts = glm::all(glm::greaterThanEqual(steps, glm::vec3(0))) &&
                          glm::all(glm::lessThanEqual(steps, glm::vec3(packing_.lattice.last)));
      if (!counts || input_.first + glm::vec3(glm::uvec3(steps)) * input_.step != p) return std::nullopt;
      colors[v] = hash_of(glm::uvec3(steps));
    }
    for (std::size_t a = 0; a < input_.attributes.size(); ++a) {
      const mesh::Attribute& expected = *input_.attributes[a];
      const DracoAttribute* found = unpacked_.find(draco_attribute_id(!input_.normals.empty(), a));
      if (found == nullptr || found->type != expected.type || found->components != expected.components ||
          found->normalized != expected.normalized) {
        return std::nullopt;
      }
      const std::size_t stride = expected.stride();
      for (std::size_t v = 0; v < colors.size(); ++v) {
        colors[v] = hash_of(std::span(found->values).subspan(v * stride, stride), colors[v]);
      }
    }
    return colors;
  }

  std::span<const glm::uvec3> mesh_triangles() {
    if (!input_.face_normals) return mesh_.triangles.span();
    split_.resize(mesh_.triangles.size());
    for (std::size_t t = 0; t < split_.size(); ++t) {
      split_[t] = glm::uvec3(static_cast<std::uint32_t>(3 * t)) + glm::uvec3(0, 1, 2);
    }
    return split_;
  }

  const mesh::Mesh& mesh_;
  const DracoPacking& packing_;
  const DracoInput& input_;
  const DracoSurface& unpacked_;
  std::vector<glm::uvec3> split_;
};

// Packs, unpacks and compares. Returns nullopt if unpacking does not reproduce the mesh.
Result<std::optional<DracoPacked>> attempt_packing(const mesh::Mesh& mesh, const DracoPacking& packing,
                                                   const DracoInput& input, DracoMethod method) {
  auto bytes = TRY(encode_draco(input, method));
  const auto unpacked = decode_draco(bytes, [](std::uint64_t /*reserved before*/) {});
  if (!unpacked) return std::optional<DracoPacked>();
  auto packed = Comparison(mesh, packing, input, *unpacked).compare();
  if (packed) packed->bytes = std::move(bytes);
  return packed;
}

}  // namespace

Result<DracoPacked> pack_with_draco(const mesh::Mesh& mesh, const DracoPacking& packing, const Context& context) {
  const Stopwatch watch;
  std::uint64_t bytes = mesh.triangles.size() * kPackedTriangleBytes + mesh.positions.size() * kPackedVertexBytes;
  const std::uint64_t vertices = packing.flat_normals ? 3 * mesh.triangles.size() : mesh.positions.size();
  for (const GltfSemantic& semantic : packing.semantics) bytes += 4 * vertices * semantic.attribute->stride();
  if (packing.flat_normals) bytes += vertices * kPackedVertexBytes;
  const auto memory = TRY(context.reserve(bytes, "packing it"));

  auto on_lattice = TRY(round_to_lattice(mesh, packing.lattice));
  std::vector<glm::vec3> face_normals;
  if (packing.flat_normals) {
    face_normals.reserve(mesh.triangles.size());
    for (const glm::uvec3& triangle : mesh.triangles) face_normals.push_back(face_normal(mesh, triangle));
  }
  DracoInput input;
  input.positions = on_lattice.numbers.span();
  input.first = packing.lattice.local_first();
  input.step = static_cast<float>(packing.lattice.step);
  input.bits = packing.lattice.bits;
  input.triangles = mesh.triangles.span();
  input.normals = packing.flat_normals ? std::span<const glm::vec3>(face_normals) : mesh.normals.span();
  input.face_normals = packing.flat_normals;
  for (const GltfSemantic& semantic : packing.semantics) {
    input.attributes.push_back(semantic.attribute);
    input.names.push_back(semantic.attribute->name);
  }
  input.names_in_file = packing.is_file;
  if (packing.is_file) input.generator = generator();
  input.placement = packing.placement;

  bool used_sequential_method = false;
  auto packed = attempt_packing(mesh, packing, input, DracoMethod::edgebreaker);
  if (!packed || !*packed) {
    TRY(context.check());
    used_sequential_method = true;
    packed = attempt_packing(mesh, packing, input, DracoMethod::sequential);
  }
  if (!packed) return tl::unexpected(std::move(packed.error()));
  if (!*packed) {
    return fail(ErrorCode::output,
                "the check of the packed mesh failed: Draco unpacks it to a mesh that differs from the original");
  }
  DracoPacked result = std::move(**packed);
  result.facts.used_sequential_method = used_sequential_method;
  result.facts.bytes_after = result.bytes.size();
  result.facts.flattened_triangles = on_lattice.flattened_triangles;
  result.facts.time = watch.elapsed();
  return result;
}

}  // namespace isoextract::mesh_io
