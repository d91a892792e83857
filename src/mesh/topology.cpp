#include "mesh/topology.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <new>
#include <string>
#include <vector>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

#include "base/allocation_error.hpp"
#include "base/parallel.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/detail/topology_part.hpp"

namespace isoextract::mesh {
namespace {

constexpr std::size_t kVerticesTogether = 1 << 10;

// Splits the vertices into up to eight ranges and provides the corners of one range at a time: the corners of all
// vertices would need more memory than the mesh. It skips whole blocks of triangles. Vertices and triangles of a
// surface are numbered in the same order, so most blocks use the vertices of few ranges.
class VertexRanges {
 public:
  VertexRanges(std::span<const glm::uvec3> triangles, std::size_t vertices)
      : triangles_(triangles),
        vertices_(vertices),
        size_(range_size(vertices)),
        blocks_((triangles.size() + kBlock - 1) / kBlock) {
    tbb::enumerable_thread_specific<std::array<std::uint64_t, kMost>> parts(std::array<std::uint64_t, kMost>{});
    for_each_index(blocks_.size(), [&](std::size_t b) {
      auto& counts = parts.local();
      Block& block = blocks_[b];
      for (const glm::uvec3& t : triangles.subspan(b * kBlock, std::min(kBlock, triangles.size() - b * kBlock))) {
        for (int c = 0; c < 3; ++c) {
          block.least = std::min(block.least, t[c]);
          block.most = std::max(block.most, t[c]);
          ++counts[t[c] / size_];
        }
      }
    });
    for (const auto& part : parts) {
      for (std::size_t range = 0; range < kMost; ++range) corners_[range] += part[range];
    }
  }

  [[nodiscard]] std::size_t count() const { return (vertices_ + size_ - 1) / size_; }
  [[nodiscard]] std::size_t first(std::size_t range) const { return range * size_; }
  [[nodiscard]] std::size_t end(std::size_t range) const { return std::min(vertices_, first(range) + size_); }

  // Returns the corners at the vertices of a range, in buckets numbered from its first vertex. Throws std::bad_alloc.
  [[nodiscard]] Buckets<Corner> corners(std::size_t range) const {
    const std::size_t from = first(range);
    const std::size_t to = end(range);
    std::vector<std::size_t> blocks;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (blocks_[b].least < to && blocks_[b].most >= from) blocks.push_back(b);
    }
    return {blocks.size() * kBlock, to - from, [&](std::size_t i, const auto& put) {
              const std::size_t t = blocks[i / kBlock] * kBlock + i % kBlock;
              if (t >= triangles_.size()) return;
              for (int c = 0; c < 3; ++c) {
                const std::size_t vertex = triangles_[t][c];
                if (vertex >= from && vertex < to) put(vertex - from, 3 * Corner{t} + static_cast<Corner>(c));
              }
            }};
  }

  // Returns the bytes of the corners of the largest range.
  [[nodiscard]] std::uint64_t bytes() const {
    return Buckets<Corner>::bytes(*std::ranges::max_element(corners_), std::min(size_, vertices_)) +
           blocks_.size() * sizeof(std::size_t);
  }

 private:
  static constexpr std::size_t kMost = 8;
  static constexpr std::size_t kLeastSize = std::size_t{1} << 17;
  static constexpr std::size_t kBlock = 1 << 12;
  struct Block {
    std::uint32_t least = std::numeric_limits<std::uint32_t>::max();
    std::uint32_t most = 0;
  };

  // The size of all ranges but the last, which is slightly smaller.
  static std::size_t range_size(std::size_t vertices) {
    const std::size_t count = std::clamp(vertices / kLeastSize, std::size_t{1}, kMost);
    return std::max<std::size_t>(1, (vertices + count - 1) / count);
  }

  std::span<const glm::uvec3> triangles_;
  std::size_t vertices_;
  std::size_t size_;
  std::vector<Block> blocks_;
  std::array<std::uint64_t, kMost> corners_{};
};

// part_of(vertex) returns a number below `count`; the results leave unused vertices to the caller.
template <class PartOf>
std::vector<Topology> look_at_vertices(std::span<const glm::uvec3> triangles, const VertexRanges& ranges,
                                       std::size_t count, const PartOf& part_of) {
  tbb::enumerable_thread_specific<TopologyPart> parts([&] { return TopologyPart(count); });
  for (std::size_t range = 0; range < ranges.count(); ++range) {
    const Buckets<Corner> corners = ranges.corners(range);
    const std::size_t first = ranges.first(range);
    for_each_range(ranges.end(range) - first, kVerticesTogether, [&](std::size_t begin, std::size_t end) {
      TopologyPart& part = parts.local();
      for (std::size_t v = begin; v != end; ++v) {
        part.look_at(static_cast<std::uint32_t>(first + v), part_of(first + v), corners.at(v), triangles);
      }
    });
  }
  std::vector<Topology> results(count);
  for (const TopologyPart& part : parts) part.add_to(results);
  return results;
}

Topology measure(const Mesh& mesh, const VertexRanges& ranges) {
  const auto triangles = mesh.triangles.span();
  const std::size_t vertices = mesh.positions.size();
  Topology result = look_at_vertices(triangles, ranges, 1, [](std::size_t) { return std::size_t{0}; }).front();
  for (const glm::uvec3& t : triangles) result.repeated_index_triangles += has_repeated_index(t) ? 1 : 0;
  result.components = Components(triangles, vertices).count();
  result.euler = static_cast<std::int64_t>(vertices - result.unused_vertices) -
                 static_cast<std::int64_t>(result.edges) +
                 static_cast<std::int64_t>(triangles.size() - result.repeated_index_triangles);
  return result;
}

std::vector<Topology> measure(const Mesh& mesh, const VertexRanges& ranges, const Components& components) {
  const auto triangles = mesh.triangles.span();
  const std::size_t count = components.count();
  if (count == 0) return {};
  auto results = look_at_vertices(triangles, ranges, count, [&](std::size_t v) {
    const std::uint32_t component = components.of_vertex(v);
    return component == Components::kNone ? 0 : component;
  });
  for (Topology& result : results) {
    result.components = 1;
    result.unused_vertices = 0;
    result.euler = -static_cast<std::int64_t>(result.edges);
  }
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (components.of_vertex(v) != Components::kNone) ++results[components.of_vertex(v)].euler;
  }
  for (const glm::uvec3& t : triangles) {
    if (!has_repeated_index(t)) ++results[components.of_vertex(t.x)].euler;
  }
  return results;
}

}  // namespace

Topology measure_topology(const Mesh& mesh) {
  return measure(mesh, VertexRanges(mesh.triangles.span(), mesh.positions.size()));
}

Result<Topology> measure_topology(const Mesh& mesh, const Context& context) {
  const std::string what = mesh.name + ": the edges of its triangles";
  const std::uint64_t vertices = mesh.positions.size();
  try {
    const VertexRanges ranges(mesh.triangles.span(), vertices);
    const auto memory = TRY(context.reserve(std::max(ranges.bytes(), Components::bytes(vertices)), what));
    return measure(mesh, ranges);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
}

Result<std::vector<Topology>> measure_topology(const Mesh& mesh, const Components& components, const Context& context) {
  const std::string what = mesh.name + ": the edges of its components";
  try {
    const VertexRanges ranges(mesh.triangles.span(), mesh.positions.size());
    const auto threads = static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency());
    const auto memory =
        TRY(context.reserve(ranges.bytes() + (threads + 1) * components.count() * sizeof(Topology), what));
    return measure(mesh, ranges, components);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
}

}  // namespace isoextract::mesh
