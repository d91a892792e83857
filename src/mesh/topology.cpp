#include "mesh/topology.hpp"

#include <new>
#include <string>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "mesh/adjacency.hpp"
#include "mesh/components.hpp"

namespace isoextract::mesh {
namespace {

// What one thread found out, at one vertex after the other. An edge counts at the lower of its ends.
class Part {
 public:
  void look_at(std::uint32_t vertex, std::span<const Corner> corners, std::span<const glm::uvec3> triangles) {
    sound_.clear();
    for (const Corner corner : corners) {
      if (!repeats_index(triangles[triangle_of(corner)])) sound_.push_back(corner);
    }
    if (sound_.empty()) {
      ++facts_.unused_vertices;
      return;
    }
    star_.look_at(sound_, triangles);
    if (star_.fans() > 1) ++facts_.nonmanifold_vertices;
    const auto sides = star_.sides();
    for (std::size_t first = 0; first < sides.size();) {
      std::size_t last = first;
      while (last < sides.size() && sides[last].end == sides[first].end) ++last;
      if (sides[first].end > vertex) add_edge(sides.subspan(first, last - first));
      first = last;
    }
  }

  [[nodiscard]] const Topology& facts() const { return facts_; }

 private:
  void add_edge(std::span<const VertexStar::Side> sides) {
    ++facts_.edges;
    if (sides.size() == 1) ++facts_.open_edges;
    if (sides.size() > 2) ++facts_.nonmanifold_edges;
    if (sides.size() == 2 && sides[0].outgoing == sides[1].outgoing) ++facts_.misoriented_edges;
  }

  Topology facts_;
  VertexStar star_;
  std::vector<Corner> sound_;
};

}  // namespace

Topology measure_topology(const Mesh& mesh) {
  const auto triangles = mesh.triangles.span();
  const std::size_t vertices = mesh.positions.size();
  const Adjacency adjacency(triangles, vertices);
  constexpr std::size_t kGrain = 1 << 10;
  tbb::enumerable_thread_specific<Part> parts;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices, kGrain), [&](const auto& range) {
    Part& part = parts.local();
    for (std::size_t v = range.begin(); v != range.end(); ++v) {
      part.look_at(static_cast<std::uint32_t>(v), adjacency.corners(v), triangles);
    }
  });
  Topology result;
  for (const Part& part : parts) {
    result.edges += part.facts().edges;
    result.open_edges += part.facts().open_edges;
    result.nonmanifold_edges += part.facts().nonmanifold_edges;
    result.misoriented_edges += part.facts().misoriented_edges;
    result.nonmanifold_vertices += part.facts().nonmanifold_vertices;
    result.unused_vertices += part.facts().unused_vertices;
  }
  for (const glm::uvec3& t : triangles) result.repeated_index_triangles += repeats_index(t) ? 1 : 0;
  result.components = Components(triangles, vertices).count();
  result.euler = static_cast<std::int64_t>(vertices - result.unused_vertices) -
                 static_cast<std::int64_t>(result.edges) +
                 static_cast<std::int64_t>(triangles.size() - result.repeated_index_triangles);
  return result;
}

Result<Topology> measure_topology(const Mesh& mesh, const Context& context) {
  const std::string what = mesh.name + ": the edges of its triangles";
  const std::uint64_t vertices = mesh.positions.size();
  const auto memory =
      context.reserve(Adjacency::bytes(mesh.triangles.size(), vertices) + Components::bytes(vertices), what);
  if (!memory) return tl::unexpected(memory.error());
  try {
    return measure_topology(mesh);
  } catch (const std::bad_alloc&) {
    return fail(ErrorKind::input, what + " need more memory than there is");
  }
}

}  // namespace isoextract::mesh
