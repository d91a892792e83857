#include "accuracy/mesh_match.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>

#include <fmt/format.h>

#include "accuracy/extraction_comparison.hpp"
#include "accuracy/float_spacing.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "mesh/buckets.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::accuracy {
namespace {

// The largest absolute local and world coordinates of a mesh.
struct Reach {
  double local = 0;
  glm::dvec3 world{0.0};

  explicit Reach(const mesh::Mesh& mesh) {
    if (mesh.positions.empty()) return;
    const mesh::LocalBounds bounds = mesh::measure_local_bounds(mesh);
    for (const glm::vec3& corner : {bounds.min, bounds.max}) {
      local = std::max(local, max_abs_coordinate(glm::dvec3(corner)));
      world = glm::max(world, glm::abs(mesh.origin + glm::dvec3(corner)));
    }
  }
};

glm::dvec3 match_tolerance(const mesh::Mesh& written, const mesh::Mesh& extracted, bool float32_world) {
  constexpr double kSums = 4;
  const Reach ours(extracted);
  const Reach theirs(written);
  glm::dvec3 allowed(kStabilityUlps * float_spacing(ours.local));
  if (float32_world && extracted.origin != glm::dvec3(0)) {
    for (int axis = 0; axis < 3; ++axis) allowed[axis] += float_spacing(ours.world[axis]);
  }
  if (written.origin != extracted.origin) {
    allowed += float_spacing(theirs.local) / 2;
    allowed += kSums * std::numeric_limits<double>::epsilon() * glm::max(ours.world, theirs.world);
  }
  return allowed;
}

// Returns the largest power of two of which all world coordinates are multiples; 0 if all are 0.
double step_of(const mesh::Mesh& mesh) {
  int least = std::numeric_limits<int>::max();
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3 place = mesh.position(v);
    for (int axis = 0; axis < 3; ++axis) {
      if (place[axis] == 0) continue;
      constexpr int kDigits = std::numeric_limits<double>::digits;
      int exponent = 0;
      const double mantissa = std::frexp(std::abs(place[axis]), &exponent);
      const auto digits = static_cast<std::uint64_t>(std::ldexp(mantissa, kDigits));
      least = std::min(least, exponent - kDigits + std::countr_zero(digits));
    }
  }
  return least == std::numeric_limits<int>::max() ? 0 : std::ldexp(1.0, least);
}

// Divides space into boxes sixteen times as wide as the limit, so few vertices are near a neighboring box.
class Cells {
 public:
  Cells(const glm::dvec3& allowed, const glm::dvec3& center, double reach, std::size_t vertices)
      : size_(16.0 * allowed), center_(center) {
    // A bucket holds a block of 2^shift cells a side, about four edges of such a surface wide: neighbors in the mesh
    // are then neighbors in the cache.
    const double edges = 4 * reach / std::sqrt(static_cast<double>(vertices) + 1);
    while (shift_ < kMaxShift && std::ldexp(max_abs_coordinate(size_), shift_ + 1) <= edges) ++shift_;
    buckets_ = vertices / 16 + 1;
  }

  // The extracted mesh spans about 2^20 cells; everything far beyond it falls into the outermost cells.
  [[nodiscard]] glm::ivec3 of(const glm::dvec3& place) const {
    constexpr double kFarthest = 0x1p30;
    return glm::ivec3(glm::clamp(glm::floor((place - center_) / size_), -kFarthest, kFarthest));
  }
  [[nodiscard]] std::size_t bucket_of(const glm::ivec3& cell) const {
    const glm::ivec3 block = cell >> shift_;
    return mesh::bucket_of_cell(block.x, block.y, block.z, buckets_);
  }
  [[nodiscard]] std::size_t buckets() const { return buckets_; }

 private:
  static constexpr int kMaxShift = 30;
  glm::dvec3 size_;
  glm::dvec3 center_;
  int shift_ = 0;
  std::size_t buckets_ = 1;
};

// Vertices as float32 numbers, as their file stores them or would store them.
class Places {
 public:
  // Rounds to multiples of `step`, if that is not 0.
  Places(const mesh::Mesh& mesh, bool float32_world, double step)
      : stored_(mesh.positions.span()), origin_(mesh.origin) {
    if (!float32_world && step == 0) return;
    // A separate pass: if the value becomes double again in the same expression, GCC 12 may drop the rounding
    // (-ftree-slp-vectorize).
    rounded_ = Buffer<glm::vec3>(mesh.positions.size());
    const auto on_lattice = [&](const glm::dvec3& place) { return step * glm::floor(place / step + 0.5); };
    origin_ = step == 0 ? glm::dvec3(0) : on_lattice(mesh.origin);
    for_each_index(rounded_.size(), [&](std::size_t v) {
      rounded_[v] = step == 0 ? mesh.position(v) : on_lattice(mesh.position(v)) - origin_;
    });
    stored_ = rounded_.span();
  }
  [[nodiscard]] std::size_t size() const { return stored_.size(); }
  [[nodiscard]] const glm::vec3& stored(std::size_t v) const { return stored_[v]; }
  [[nodiscard]] glm::dvec3 place(const glm::vec3& stored) const { return origin_ + glm::dvec3(stored); }

 private:
  Buffer<glm::vec3> rounded_;
  std::span<const glm::vec3> stored_;
  glm::dvec3 origin_;
};

struct PlacedVertex {
  glm::ivec3 cell;
  glm::vec3 stored;
  std::uint32_t vertex;

  [[nodiscard]] auto key() const { return std::tie(cell.x, cell.y, cell.z, stored.x, stored.y, stored.z); }
  friend bool operator<(const PlacedVertex& a, const PlacedVertex& b) {
    return std::tuple_cat(a.key(), std::tie(a.vertex)) < std::tuple_cat(b.key(), std::tie(b.vertex));
  }
};

mesh::Buckets<PlacedVertex> by_cell(const Places& places, const Cells& cells) {
  return {places.size(), cells.buckets(), [&](std::size_t v, const auto& put) {
            const glm::vec3& stored = places.stored(v);
            const glm::dvec3 place = places.place(stored);
            if (!std::isfinite(place.x + place.y + place.z)) return;  // NaN and infinity match nothing
            const glm::ivec3 cell = cells.of(place);
            put(cells.bucket_of(cell), PlacedVertex{cell, stored, static_cast<std::uint32_t>(v)});
          }};
}

// Returns for each vertex the first one at exactly the same place; kNoName if not finite.
Buffer<std::uint32_t> first_at_place(const mesh::Buckets<PlacedVertex>& buckets, std::size_t vertices) {
  Buffer<std::uint32_t> first(vertices);
  std::fill(first.begin(), first.end(), kNoName);
  for_each_index(buckets.size(), [&](std::size_t b) {
    const PlacedVertex* before = nullptr;
    for (const PlacedVertex& v : buckets.at(b)) {
      first[v.vertex] = before != nullptr && before->key() == v.key() ? first[before->vertex] : v.vertex;
      before = &v;
    }
  });
  return first;
}

struct Nearest {
  std::uint32_t vertex = kNoName;
  double share =
      std::numeric_limits<double>::infinity();  // fraction of the limit used, along the axis where it is largest
};

// Returns the nearest vertex within `allowed` along each axis; the first of equally near ones.
Nearest nearest_to(const glm::dvec3& place, const glm::dvec3& allowed, const Places& places, const Cells& cells,
                   const mesh::Buckets<PlacedVertex>& buckets) {
  Nearest nearest;
  const glm::ivec3 low = cells.of(place - allowed);
  const glm::ivec3 high = cells.of(place + allowed);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) {
        const glm::ivec3 cell(x, y, z);
        const auto all = buckets.at(cells.bucket_of(cell));
        const auto order = [](const glm::ivec3& c) { return std::tuple(c.x, c.y, c.z); };
        auto v = std::ranges::lower_bound(all, order(cell), {}, [&](const PlacedVertex& p) { return order(p.cell); });
        for (; v != all.end() && v->cell == cell; ++v) {
          const double share = max_abs_coordinate((places.place(v->stored) - place) / allowed);
          if (share > 1 || std::tie(share, v->vertex) >= std::tie(nearest.share, nearest.vertex)) continue;
          nearest = {v->vertex, share};
        }
      }
    }
  }
  return nearest;
}

std::uint64_t matching_bytes(std::uint64_t vertices) {
  return mesh::Buckets<PlacedVertex>::bytes(vertices, vertices / 8) +
         vertices * (sizeof(Nearest) + sizeof(glm::vec3) + 2 * sizeof(std::uint32_t));
}

}  // namespace

Result<MeshMatch> match_written_mesh(const mesh::Mesh& written, const mesh::Mesh& extracted, bool float32_world,
                                     const Context& context, bool quantized) {
  const std::uint64_t vertices = written.positions.size() + extracted.positions.size();
  const std::uint64_t triangles = written.triangles.size() + extracted.triangles.size();
  const std::uint64_t bytes =
      matching_bytes(vertices) + triangle_comparison_bytes(triangles, extracted.positions.size());
  const auto memory = TRY(context.reserve(bytes, fmt::format("{}: matching {} triangles", written.name, triangles)));

  MeshMatch result;
  result.vertices = {written.positions.size(), extracted.positions.size()};
  const double step = quantized ? step_of(written) : 0;
  result.allowed = match_tolerance(written, extracted, float32_world) + step;
  const Places theirs(written, false, 0);
  const Places ours(extracted, float32_world, step);
  const Cells cells(result.allowed, extracted.origin, Reach(extracted).local,
                    std::max(written.positions.size(), extracted.positions.size()));
  const mesh::Buckets<PlacedVertex> our_buckets = by_cell(ours, cells);
  Buffer<std::uint32_t> our_names = first_at_place(our_buckets, extracted.positions.size());
  Buffer<std::uint32_t> their_names = first_at_place(by_cell(theirs, cells), written.positions.size());

  Buffer<Nearest> nearest(written.positions.size());
  for_each_index(nearest.size(), [&](std::size_t v) {
    nearest[v] =
        their_names[v] == v ? nearest_to(written.position(v), result.allowed, ours, cells, our_buckets) : Nearest{};
  });
  // Matches one to one: the nearest of several candidates gets the vertex, the other candidates get none.
  Buffer<std::uint32_t> taken_by(extracted.positions.size());
  std::fill(taken_by.begin(), taken_by.end(), kNoName);
  for (std::uint32_t v = 0; v < nearest.size(); ++v) {
    if (nearest[v].vertex == kNoName) continue;
    std::uint32_t& holder = taken_by[nearest[v].vertex];
    if (holder != kNoName && nearest[holder].share <= nearest[v].share) {
      nearest[v] = {};
      continue;
    }
    if (holder != kNoName) nearest[holder] = {};
    holder = v;
  }

  const auto add_only = [&](std::size_t side, const glm::dvec3& place) {
    ++result.vertices_only[side];
    if (!result.vertex_example[side]) result.vertex_example[side] = place;
  };
  double greatest_share = 0;
  for (std::uint32_t v = 0; v < nearest.size(); ++v) {
    if (their_names[v] != v) continue;
    if (nearest[v].vertex == kNoName) {
      add_only(0, written.position(v));
      continue;
    }
    ++result.matched;
    if (nearest[v].share > greatest_share) {
      greatest_share = nearest[v].share;
      result.farthest = written.position(v);
      result.distance = glm::abs(ours.place(ours.stored(nearest[v].vertex)) - result.farthest);
    }
  }
  for (std::uint32_t v = 0; v < taken_by.size(); ++v) {
    if ((our_names[v] == v || our_names[v] == kNoName) && taken_by[v] == kNoName) add_only(1, extracted.position(v));
  }
  const auto rename = [](Buffer<std::uint32_t>& names, const auto& name_of) {
    for (std::uint32_t& name : names) {
      if (name != kNoName) name = name_of(name);
    }
  };
  rename(their_names, [&](std::uint32_t first) { return nearest[first].vertex; });
  rename(our_names, [&](std::uint32_t first) { return taken_by[first] == kNoName ? kNoName : first; });
  result.triangles =
      compare_triangle_sets({written, their_names.span()}, {extracted, our_names.span()}, extracted.positions.size());
  return result;
}

std::vector<std::string> differences(const MeshMatch& match, const MeshLabels& names) {
  std::vector<std::string> found;
  add_difference_sentences(match.triangles, names, found);
  for (std::size_t side = 0; side < 2; ++side) {
    if (!match.vertex_example[side]) continue;
    found.push_back(fmt::format("{} of {} vertices are in {} only, one of them at {}", match.vertices_only[side],
                                match.vertices[side], names[side], point_text(*match.vertex_example[side], 9)));
  }
  return found;
}

}  // namespace isoextract::accuracy
