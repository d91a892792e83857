#include "check/boundary_defects.hpp"

#include <algorithm>
#include <numeric>
#include <string>
#include <tuple>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/parallel.hpp"
#include "mesh/adjacency.hpp"

namespace isoextract::check {
namespace {

// One end of an open edge, and the fan of triangles at that vertex.
struct OpenEnd {
  std::uint32_t low, high;  // the ends of the edge
  // The vertex at this end.
  std::uint32_t at;
  std::uint32_t fan;
  std::uint32_t edge = 0;  // number of the edge, once known

  [[nodiscard]] auto edge_key() const { return std::tie(low, high, at); }
  [[nodiscard]] auto fan_key() const { return std::tie(at, fan, edge); }
  [[nodiscard]] bool same_fan(const OpenEnd& other) const { return at == other.at && fan == other.fan; }
};

// Copies the corners at the vertex, except corners of triangles that repeat an index.
void copy_valid_corners(std::span<const mesh::Corner> corners, std::span<const glm::uvec3> triangles,
                        std::vector<mesh::Corner>& sound) {
  sound.clear();
  std::ranges::copy_if(corners, std::back_inserter(sound), [&](mesh::Corner corner) {
    return !mesh::has_repeated_index(triangles[mesh::triangle_of(corner)]);
  });
}

class BoundarySearch {
 public:
  BoundarySearch(const mesh::Mesh& mesh, const mesh::Topology& topology, const mesh::Components& components)
      : mesh_(mesh), components_(components), adjacency_(mesh.triangles.span(), mesh.positions.size()) {
    result_.components.resize(components.count());
    ends_.reserve(2 * topology.open_edges);
  }

  BoundaryDefects run() {
    find_ends();
    number_edges();
    join_loops();
    return std::move(result_);
  }

 private:
  // Finds the sound vertices, usually most vertices, on several threads; examines the other vertices in order.
  void find_ends() {
    const auto triangles = mesh_.triangles.span();
    Buffer<std::uint8_t> sound(mesh_.positions.size());
    constexpr std::size_t kVerticesAtATime = 1 << 10;
    for_each_range(sound.size(), kVerticesAtATime, [&](std::size_t begin, std::size_t end) {
      mesh::VertexStar star;
      std::vector<mesh::Corner> corners;
      for (std::size_t v = begin; v != end; ++v) {
        copy_valid_corners(adjacency_.corners(v), triangles, corners);
        if (!corners.empty()) star.look_at(corners, triangles);
        sound[v] = corners.empty() || star.is_closed_fan() ? 1 : 0;
      }
    });
    mesh::VertexStar star;
    std::vector<mesh::Corner> corners;
    for (std::uint32_t v = 0; v < sound.size(); ++v) {
      if (sound[v] != 0) continue;
      copy_valid_corners(adjacency_.corners(v), triangles, corners);
      star.look_at(corners, triangles);
      look_at(v, star);
    }
  }

  void look_at(std::uint32_t vertex, const mesh::VertexStar& star) {
    EdgeDefects& defects = result_.components[components_.of_vertex(vertex)];
    if (star.fans() > 1) ++defects.nonmanifold_vertices;
    const auto sides = star.sides();
    for (std::size_t first = 0; first < sides.size();) {
      std::size_t last = first;
      while (last < sides.size() && sides[last].end == sides[first].end) ++last;
      const mesh::VertexStar::Side& side = sides[first];
      const std::size_t count = last - first;
      if (count == 1) {
        ends_.push_back({std::min(vertex, side.end), std::max(vertex, side.end), vertex, star.fan_of()[side.corner]});
      }
      if (side.end > vertex) {  // an edge counts at the lower of its ends
        defects.open += count == 1 ? 1 : 0;
        defects.nonmanifold += count > 2 ? 1 : 0;
        defects.misoriented += count == 2 && side.outgoing == sides[first + 1].outgoing ? 1 : 0;
      }
      first = last;
    }
  }

  // Sorting puts the two ends of each open edge side by side.
  void number_edges() {
    std::ranges::sort(ends_, [](const OpenEnd& a, const OpenEnd& b) { return a.edge_key() < b.edge_key(); });
    length_.resize(ends_.size() / 2);
    component_.resize(length_.size());
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      ends_[i].edge = static_cast<std::uint32_t>(i / 2);
      if (i % 2 != 0) continue;
      length_[i / 2] =
          glm::distance(glm::dvec3(mesh_.positions[ends_[i].low]), glm::dvec3(mesh_.positions[ends_[i].high]));
      component_[i / 2] = components_.of_vertex(ends_[i].low);
    }
  }

  void join_loops() {
    std::vector<std::uint32_t> first(length_.size());
    std::iota(first.begin(), first.end(), 0U);
    const auto find = [&](std::uint32_t edge) {
      while (first[edge] != edge) edge = first[edge] = first[first[edge]];
      return edge;
    };
    std::ranges::sort(ends_, [](const OpenEnd& a, const OpenEnd& b) { return a.fan_key() < b.fan_key(); });
    for (std::size_t i = 1; i < ends_.size(); ++i) {
      if (!ends_[i].same_fan(ends_[i - 1])) continue;
      const auto [low, high] = std::minmax({find(ends_[i - 1].edge), find(ends_[i].edge)});
      first[high] = low;
    }
    // The first edge of a loop comes before the other edges of the loop, so it already has the loop's number.
    for (std::uint32_t edge = 0; edge < first.size(); ++edge) {
      if (first[edge] == edge) {
        first[edge] = static_cast<std::uint32_t>(result_.loops.size());
        result_.loops.push_back({0, 0, component_[edge]});
      } else {
        first[edge] = first[first[edge]];
      }
      BoundaryLoop& loop = result_.loops[first[edge]];
      ++loop.edges;
      loop.length += length_[edge];
    }
  }

  const mesh::Mesh& mesh_;
  const mesh::Components& components_;
  mesh::Adjacency adjacency_;
  std::vector<OpenEnd> ends_;
  std::vector<double> length_;            // of each open edge
  std::vector<std::uint32_t> component_;  // of each open edge
  BoundaryDefects result_;
};

}  // namespace

Result<BoundaryDefects> find_boundary_defects(const mesh::Mesh& mesh, const mesh::Topology& topology,
                                              const mesh::Components& components, const Context& context) {
  const std::uint64_t vertices = mesh.positions.size();
  constexpr std::uint64_t kEdgeBytes =
      2 * sizeof(OpenEnd) + sizeof(double) + 2 * sizeof(std::uint32_t) + sizeof(BoundaryLoop);
  const bool all_sound =
      topology.open_edges + topology.nonmanifold_edges + topology.misoriented_edges + topology.nonmanifold_vertices ==
      0;
  const std::uint64_t search_bytes =
      mesh::Adjacency::bytes(mesh.triangles.size(), vertices) + vertices + topology.open_edges * kEdgeBytes;
  const std::string what = fmt::format("{}: the boundary edges of its surface", mesh.name);
  const auto memory =
      TRY(context.reserve(components.count() * sizeof(EdgeDefects) + (all_sound ? 0 : search_bytes), what));
  try {
    if (!all_sound) return BoundarySearch(mesh, topology, components).run();
    BoundaryDefects defects;
    defects.components.resize(components.count());
    return defects;
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
}

}  // namespace isoextract::check
