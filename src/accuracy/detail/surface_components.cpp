#include "accuracy/detail/surface_components.hpp"

#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <unordered_set>

#include "accuracy/surface_coverage.hpp"
#include "base/disjoint_sets.hpp"
#include "base/parallel.hpp"

namespace isoextract::accuracy {
namespace {

glm::ivec3 brick_of_triangle(const WindowSurface& surface, std::size_t triangle) {
  const auto corners = surface.placed.corners(triangle);
  return surface.cells.brick((corners[0] + corners[1] + corners[2]) / 3.0);
}

// The faces of a box, shared with other boxes, in which an edge lies.
struct FacesOfEdge {
  bool before = false;  // one that an earlier box has, too
  bool after = false;   // one that a later box has, too
};

FacesOfEdge faces_of(const BrickBox& box, const mesh::EdgeKey& edge) {
  FacesOfEdge faces;
  for (int axis = 0; axis < 3; ++axis) {
    if ((edge.direction >> axis & 1) != 0) continue;
    const bool has_before = box.min[axis] > -BrickBox::kUnbounded;
    const bool has_after = box.max[axis] < BrickBox::kUnbounded;
    faces.before = faces.before || (has_before && edge.low[axis] == box.min[axis] * kBrickCells);
    faces.after = faces.after || (has_after && edge.low[axis] == (box.max[axis] + 1) * kBrickCells);
  }
  return faces;
}

}  // namespace

std::size_t SurfaceComponents::HashOfEdge::operator()(const mesh::EdgeKey& edge) const {
  constexpr std::uint64_t kOdd = 0x9E3779B97F4A7C15ULL;
  std::uint64_t hash = static_cast<std::uint32_t>(edge.direction);
  for (int axis = 0; axis < 3; ++axis) hash = (hash ^ static_cast<std::uint32_t>(edge.low[axis])) * kOdd;
  return static_cast<std::size_t>(hash ^ hash >> 32U);
}

std::vector<std::uint32_t> SurfaceComponents::number(const WindowSurface& surface, const mesh::Components& components,
                                                     std::uint32_t first) {
  std::vector<std::uint32_t> numbers(components.count(), kNone);
  for_each_range(surface.mesh.triangles.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t != end; ++t) {
      const std::uint32_t component = components.of_vertex(surface.mesh.triangles[t].x);
      if (component == kNone) continue;
      const std::atomic_ref mark(numbers[component]);
      if (mark.load(std::memory_order_relaxed) != kNone) continue;
      if (surface.window.bricks().contains(brick_of_triangle(surface, t))) mark.store(0, std::memory_order_relaxed);
    }
  });
  for (std::uint32_t& number : numbers) {
    if (number != kNone) number = first++;
  }
  return numbers;
}

void SurfaceComponents::join_neighbors(const WindowSurface& surface, const mesh::Components& components,
                                       std::span<const std::uint32_t> numbers) {
  const BrickBox& bricks = surface.window.bricks();
  // Windows come in the order of z: no later one has faces below this one.
  std::erase_if(on_faces_, [&](const auto& known) {
    return bricks.min.z > -BrickBox::kUnbounded && known.first.low.z < bricks.min.z * kBrickCells;
  });
  const DisjointSets sets(parents_, true);
  for (std::size_t v = 0; v < surface.mesh.edges.size(); ++v) {
    const std::uint32_t component = components.of_vertex(v);
    if (component == kNone || numbers[component] == kNone) continue;
    const mesh::EdgeKey& edge = surface.mesh.edges[v];
    const FacesOfEdge faces = faces_of(bricks, edge);
    if (faces.after) {
      const auto [known, is_new] = on_faces_.try_emplace(edge, numbers[component]);
      if (!is_new) sets.join(known->second, numbers[component]);
    } else if (faces.before) {
      const auto known = on_faces_.find(edge);
      if (known != on_faces_.end()) sets.join(known->second, numbers[component]);
    }
  }
}

Result<double> SurfaceComponents::add(const WindowSurface& surface, const mesh::Mesh& mesh, const IndexMesh& placed,
                                      Progress* progress, const Context& context) {
  const mesh::Components components(surface.mesh.triangles.span(), surface.mesh.positions.size());
  const auto first = static_cast<std::uint32_t>(parents_.size());
  const std::vector<std::uint32_t> numbers = number(surface, components, first);
  const SearchWindow& window = surface.window;
  std::vector<std::uint8_t> found(components.count(), 0);
  std::vector<Beyond> beyond;
  std::mutex mutex;  // of `beyond` and `needed`
  double needed = 0;
  for_each_range(mesh.positions.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
    std::uint32_t near = 0;
    for (std::size_t v = begin; v != end && !context.cancelled(); ++v) {
      const glm::dvec3 index = placed.vertex(v);
      if (!window.bricks().contains(surface.cells.brick(index))) continue;
      double distance = std::numeric_limits<double>::infinity();
      if (surface.tree != nullptr) {
        const auto nearest = surface.tree->nearest(mesh.position(v) - surface.mesh.origin, near);
        near = nearest.slot;
        distance = std::sqrt(nearest.distance_squared);
      }
      if (const double here = window.needed(index, distance); here > 0) {
        const std::lock_guard lock(mutex);
        needed = std::max(needed, here);
      }
      if (surface.tree == nullptr) continue;
      const std::size_t triangle = surface.tree->triangle(near);
      const std::uint32_t vertex = surface.mesh.triangles[triangle].x;
      const std::uint32_t component = components.of_vertex(vertex);
      if (component == kNone) continue;
      const bool is_new = std::atomic_ref(found[component]).exchange(1, std::memory_order_relaxed) == 0;
      if (!is_new || numbers[component] != kNone) continue;
      const std::lock_guard lock(mutex);
      beyond.push_back({surface.mesh.edges[vertex], brick_of_triangle(surface, triangle)});
    }
    if (progress != nullptr) progress->advance(end - begin);
  });
  if (needed > 0) return needed;

  std::vector<std::uint8_t> counts(components.count(), kept_.empty() ? 1 : 0);
  for (std::size_t v = 0; v < surface.mesh.positions.size() && !kept_.empty(); ++v) {
    const std::uint32_t component = components.of_vertex(v);
    if (component != kNone && is_kept(surface.mesh.position(v), kept_)) counts[component] = 1;
  }
  const auto own = static_cast<std::uint32_t>(std::ranges::count_if(numbers, [](auto n) { return n != kNone; }));
  const auto on_later_faces = static_cast<std::uint64_t>(std::ranges::count_if(
      surface.mesh.edges.span(), [&](const mesh::EdgeKey& edge) { return faces_of(window.bricks(), edge).after; }));
  constexpr std::uint64_t kGrowth = 2;  // of vectors
  constexpr std::uint64_t kFaceBytes = 64;
  constexpr std::uint64_t kComponentBytes = sizeof(std::uint32_t) + 2;
  const std::uint64_t lasting = kGrowth * (parents_.size() + own) * kComponentBytes +
                                kFaceBytes * (on_faces_.size() + on_later_faces) +
                                kGrowth * (beyond_.size() + beyond.size()) * sizeof(Beyond);
  if (lasting > memory_.bytes()) {
    memory_.take(TRY(context.reserve(lasting - memory_.bytes(), "the components of the isosurface")));
  }
  for (std::size_t c = 0; c < numbers.size(); ++c) {
    if (numbers[c] == kNone) continue;
    parents_.push_back(numbers[c]);
    counted_.push_back(counts[c]);
    found_.push_back(found[c]);
  }
  windows_.push_back({window, first, own});
  beyond_.insert(beyond_.end(), beyond.begin(), beyond.end());
  join_neighbors(surface, components, numbers);
  return 0.0;
}

const SearchWindow* SurfaceComponents::unfinished() const {
  if (beyond_.empty()) return nullptr;
  const auto it = std::ranges::find_if(
      windows_, [&](const Added& added) { return added.window.bricks().contains(beyond_.front().brick); });
  return &it->window;
}

Result<void> SurfaceComponents::mark_found(const WindowSurface& surface) {
  const mesh::Components components(surface.mesh.triangles.span(), surface.mesh.positions.size());
  const auto added = std::ranges::find_if(windows_, [&](const Added& one) { return &one.window == &surface.window; });
  const std::vector<std::uint32_t> numbers = number(surface, components, added->first);
  std::unordered_set<mesh::EdgeKey, HashOfEdge> wanted;
  std::erase_if(beyond_, [&](const Beyond& one) {
    const bool is_here = surface.window.bricks().contains(one.brick);
    if (is_here) wanted.insert(one.vertex);
    return is_here;
  });
  for (std::size_t v = 0; v < surface.mesh.edges.size(); ++v) {
    const std::uint32_t component = components.of_vertex(v);
    if (component == kNone || numbers[component] == kNone || !wanted.contains(surface.mesh.edges[v])) continue;
    if (numbers[component] >= added->first + added->count) {
      return fail(ErrorCode::input, "the samples changed while the program measured the error",
                  "wait until the program that writes the file has finished");
    }
    found_[numbers[component]] = 1;
  }
  return {};
}

SurfaceComponents::Counts SurfaceComponents::counts() {
  const DisjointSets sets(parents_, true);
  for (std::uint32_t c = 0; c < parents_.size(); ++c) {
    const std::uint32_t root = sets.root(c);
    counted_[root] |= counted_[c];
    found_[root] |= found_[c];
  }
  Counts counts;
  for (std::uint32_t c = 0; c < parents_.size(); ++c) {
    if (parents_[c] != c || counted_[c] == 0) continue;
    ++counts.components;
    counts.lost += found_[c] == 0 ? 1 : 0;
  }
  return counts;
}

}  // namespace isoextract::accuracy
