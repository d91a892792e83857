#include "accuracy/detail/mesh_parts.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/sparse_blocks.hpp"

namespace isoextract::accuracy {
namespace {

constexpr std::size_t kVertexGrain = 1 << 13;

field::IndexBox box_of_vertices(const mesh::Mesh& mesh, const IndexMesh& placed) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const field::Box none{glm::dvec3(kInfinity), glm::dvec3(-kInfinity)};
  const auto join = [](const field::Box& a, const field::Box& b) {
    return field::Box{glm::min(a.min, b.min), glm::max(a.max, b.max)};
  };
  const field::Box box = reduce_ranges(
      mesh.positions.size(), kVertexGrain, none,
      [&](std::size_t begin, std::size_t end, field::Box part) {
        for (std::size_t v = begin; v != end; ++v) part = join(part, {placed.vertex(v), placed.vertex(v)});
        return part;
      },
      join);
  if (box.min.x > box.max.x) return {};
  constexpr double kFarthest = field::kMaxSparseIndex;
  const auto limit = [](const glm::dvec3& p) { return glm::clamp(p, glm::dvec3(-kFarthest), glm::dvec3(kFarthest)); };
  return {glm::ivec3(glm::floor(limit(box.min))), glm::ivec3(glm::ceil(limit(box.max)))};
}

}  // namespace

field::IndexBox surface_box(const field::ScalarField& field) {
  const auto* sparse = std::get_if<field::SparseSamples>(&field.samples);
  if (sparse == nullptr) return field.extents();
  const field::IndexBox stored = extract::stored_box(*sparse);
  return stored.empty() ? stored : field::IndexBox{stored.min - 1, stored.max + 1};
}

Result<mesh::Mesh> extract_within(const SearchWindow& window, const field::ScalarField& field,
                                  extract::ExtractOptions options, const Context& context) {
  options.smooth_normals = false;
  options.sink = nullptr;
  const field::IndexBox all = surface_box(field);
  // Positions do not depend on the window, unless all samples together are too far apart for float32.
  options.shared_origin = extract::output_placement(field, options, all, all).fits_float32();
  field::IndexBox region = window.samples();
  if (options.region) region = {glm::max(region.min, options.region->min), glm::min(region.max, options.region->max)};
  const glm::ivec3 low = glm::max(region.min, all.min);
  const glm::ivec3 high = glm::min(region.max, all.max);
  if (glm::any(glm::greaterThanEqual(low, high))) return mesh::Mesh();
  if (low != all.min || high != all.max) options.region = region;
  auto extraction = TRY(extract::make_cpu_extractor()->extract(field, options, context));
  return std::move(extraction.mesh);
}

MeshInMemory::MeshInMemory(const mesh::Mesh& mesh, const IndexMesh& placed, const Context& context)
    : mesh_(mesh), placed_(placed), context_(context), samples_(box_of_vertices(mesh, placed)) {}

Result<const mesh::Mesh*> MeshInMemory::part(const SearchWindow& window) {
  if (window.is_whole()) return &mesh_;
  part_ = {};
  if (numbers_.empty() && !mesh_.positions.empty()) {
    numbers_memory_ =
        TRY(context_.reserve(mesh_.positions.size() * sizeof(std::uint32_t), "the error of parts of the mesh"));
    numbers_ = Buffer<std::uint32_t>(mesh_.positions.size());
  }
  // First, the sides of the window on which a vertex is, as bits.
  const glm::dvec3 low(window.samples().min);
  const glm::dvec3 high(window.samples().max);
  for_each_index(
      mesh_.positions.size(),
      [&](std::size_t v) {
        const glm::dvec3 p = placed_.vertex(v);
        std::uint32_t sides = 0;
        for (int axis = 0; axis < 3; ++axis) {
          if (!(p[axis] >= low[axis])) sides |= 1U << axis;
          if (!(p[axis] <= high[axis])) sides |= 8U << axis;
        }
        numbers_[v] = sides;
      },
      kVertexGrain);
  TRY(context_.check());
  constexpr std::uint32_t kUsed = 64;
  const auto sides_of = [&](std::uint32_t v) {
    return std::atomic_ref(numbers_[v]).load(std::memory_order_relaxed) & (kUsed - 1);
  };
  const auto chosen = reduce_ranges(
      mesh_.triangles.size(), kVertexGrain, std::vector<std::uint32_t>(),
      [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t> list) {
        for (std::size_t t = begin; t != end; ++t) {
          const glm::uvec3& corners = mesh_.triangles[t];
          if ((sides_of(corners.x) & sides_of(corners.y) & sides_of(corners.z)) != 0) continue;
          list.push_back(static_cast<std::uint32_t>(t));
          for (int c = 0; c < 3; ++c) {
            std::atomic_ref(numbers_[corners[c]]).fetch_or(kUsed, std::memory_order_relaxed);
          }
        }
        return list;
      },
      [](std::vector<std::uint32_t> a, const std::vector<std::uint32_t>& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
      });
  std::uint32_t count = 0;
  for (std::uint32_t& number : numbers_) {
    const bool is_in = number == 0 || (number & kUsed) != 0;
    number = is_in ? count++ : std::numeric_limits<std::uint32_t>::max();
  }

  part_.memory = TRY(context_.reserve(count * sizeof(glm::vec3) + chosen.size() * sizeof(glm::uvec3),
                                      "the error of parts of the mesh"));
  part_.origin = mesh_.origin;
  part_.positions = Buffer<glm::vec3>(count);
  part_.triangles = Buffer<glm::uvec3>(chosen.size());
  for_each_index(
      mesh_.positions.size(),
      [&](std::size_t v) {
        if (numbers_[v] < count) part_.positions[numbers_[v]] = mesh_.positions[v];
      },
      kVertexGrain);
  for_each_index(
      chosen.size(),
      [&](std::size_t i) {
        const glm::uvec3& t = mesh_.triangles[chosen[i]];
        part_.triangles[i] = {numbers_[t.x], numbers_[t.y], numbers_[t.z]};
      },
      kVertexGrain);
  return &part_;
}

ExtractedMesh::ExtractedMesh(const field::ScalarField& field, const extract::ExtractOptions& extracted,
                             const Context& context)
    : field_(field), context_(context), options_(extracted) {
  options_.edge_keys = false;
}

Result<const mesh::Mesh*> ExtractedMesh::part(const SearchWindow& window) {
  part_ = {};
  // The progress is that of the measurement.
  part_ = TRY(extract_within(window, field_, options_, context_.beside()));
  return &part_;
}

}  // namespace isoextract::accuracy
