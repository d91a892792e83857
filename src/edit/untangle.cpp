#include "edit/untangle.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <new>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "base/allocation_error.hpp"
#include "edit/detail/edge_flips.hpp"
#include "edit/detail/place_search.hpp"
#include "edit/detail/smooth_signal.hpp"
#include "edit/detail/surface_change.hpp"
#include "mesh/attributes.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/self_intersections.hpp"

namespace isoextract::edit {
namespace {

constexpr int kMostRounds = 40;  // per look
constexpr int kMovingRings = 2;  // vertices so many edges away from an intersecting triangle may move
constexpr std::uint64_t kMostPairs = 1 << 20;
constexpr int kMostLooks = 4;                  // each look takes the pairs that the previous look left
constexpr std::uint64_t kMostSearched = 2000;  // more pairs than this are left to flips: each search takes about 0.05 s
constexpr double kMostMove = 1;                // length in the space of UntangleOptions::to_metric
// While more pairs than kFewPairs are left, as of bodies that overlap, searching ends unless it removes a tenth of
// them.
constexpr std::uint64_t kFewPairs = 100;
constexpr double kLeastGain = 0.1;

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

SmoothOptions bounds_of(const UntangleOptions& options) {
  SmoothOptions bounds;
  bounds.walls = options.walls;
  bounds.cuts = options.cuts;
  return bounds;
}

// Returns 1 for each vertex of the triangles in the pairs, and of vertices up to `rings` edges away from these.
std::vector<char> vertices_around(const mesh::Mesh& mesh, const Pairs& pairs, int rings) {
  std::vector<char> marks(mesh.positions.size(), 0);
  const auto mark = [&](const glm::uvec3& t) { marks[t.x] = marks[t.y] = marks[t.z] = 1; };
  for (const auto& [a, b] : pairs) {
    mark(mesh.triangles[a]);
    mark(mesh.triangles[b]);
  }
  for (int ring = 0; ring < rings; ++ring) {
    const std::vector<char> inner(marks.begin(), marks.end());
    for (const glm::uvec3& t : mesh.triangles) {
      if ((inner[t.x] | inner[t.y] | inner[t.z]) != 0) mark(t);
    }
  }
  return marks;
}

template <class T>
Buffer<T> resized(const Buffer<T>& old, std::size_t size) {
  Buffer<T> buffer(size);
  std::copy_n(old.begin(), std::min(size, old.size()), buffer.begin());
  return buffer;
}

// The triangles that untangling can change or meet, as a separate mesh. Its boundary stays in place.
class Patch {
 public:
  // `before` are the positions of the whole mesh from which moves are measured.
  Patch(const mesh::Mesh& mesh, std::span<const glm::vec3> before, const Pairs& pairs, const glm::dmat3& to_metric) {
    const std::vector<char> moving = vertices_around(mesh, pairs, kMovingRings);
    const std::vector<char> kept = vertices_around(mesh, pairs, kMovingRings + 2);
    const mesh::BoxTree reached = tree_of_reach(mesh, moving, to_metric);
    std::vector<char> chosen(mesh.triangles.size(), 0);
    for_each_index(chosen.size(), [&](std::size_t t) {
      const glm::uvec3& c = mesh.triangles[t];
      const auto box = mesh::box_around(mesh.positions[c.x], mesh.positions[c.y], mesh.positions[c.z]);
      const bool near = (kept[c.x] | kept[c.y] | kept[c.z]) != 0 || reached.any_leaf_near(box);
      chosen[t] = near ? 1 : 0;
    });
    std::vector<std::uint32_t> number(mesh.positions.size(), 0);
    for (std::uint32_t t = 0; t < chosen.size(); ++t) {
      if (chosen[t] == 0) continue;
      triangles_.push_back(t);
      for (int corner = 0; corner < 3; ++corner) number[mesh.triangles[t][corner]] = 1;
    }
    for (std::uint32_t v = 0; v < number.size(); ++v) {
      if (number[v] == 0) continue;
      number[v] = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(v);
    }
    mesh_.name = mesh.name;
    mesh_.origin = mesh.origin;  // for tests against walls and cuts
    mesh_.positions = Buffer<glm::vec3>(vertices_.size());
    before_.resize(vertices_.size());
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
      mesh_.positions[v] = mesh.positions[vertices_[v]];
      before_[v] = before[vertices_[v]];
    }
    mesh_.triangles = Buffer<glm::uvec3>(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const glm::uvec3& c = mesh.triangles[triangles_[t]];
      mesh_.triangles[t] = {number[c.x], number[c.y], number[c.z]};
    }
  }

  static std::uint64_t bytes(const mesh::Mesh& whole) {
    const std::size_t vertices = whole.positions.size();
    const std::size_t triangles = whole.triangles.size();
    return vertices * (2 * sizeof(glm::vec3) + 2 * sizeof(std::uint32_t) + 3) + mesh::BoxTree::bytes(triangles) +
           triangles * (sizeof(glm::uvec3) + 2 * sizeof(std::uint32_t) + 1);
  }

  mesh::Mesh& mesh() { return mesh_; }
  [[nodiscard]] std::span<const glm::vec3> before() const { return before_; }

  // Splits edges for new vertices where that leaves fewer pairs. Returns the number of splits.
  std::size_t split_edges(const Pairs& pairs, const UntangleOptions& options, const Context& context) {
    const auto vertices = static_cast<std::uint32_t>(mesh_.positions.size());
    const auto triangles = static_cast<std::uint32_t>(mesh_.triangles.size());
    resize(vertices + pairs.size(), triangles + 2 * pairs.size());
    for (std::uint32_t i = 0; i < pairs.size(); ++i) {
      mesh_.positions[vertices + i] = mesh_.positions[0];
      mesh_.triangles[triangles + 2 * i] = mesh_.triangles[triangles + 2 * i + 1] = glm::uvec3(vertices + i);
    }
    const Signal signal(mesh_, bounds_of(options));
    PlaceSearch search(mesh_, signal, before_, {options.to_metric, kMostMove});
    const auto edges = search.split_edges(pairs, vertices, triangles, context);
    resize(vertices + edges.size(), triangles + 2 * edges.size());
    for (const auto& [a, b] : edges) {
      before_[vertices_.size() + split_.size()] = glm::vec3(0.5 * (glm::dvec3(before_[a]) + glm::dvec3(before_[b])));
      split_.push_back({a, b});
    }
    return edges.size();
  }

  static std::uint64_t split_bytes(std::uint64_t pairs) {
    return pairs * (2 * sizeof(glm::vec3) + 2 * sizeof(glm::uvec3));
  }

  // Copies the patch back into the whole mesh. Appends new vertices and triangles, and the vertices to `before`.
  void put_back(mesh::Mesh& whole, std::vector<glm::vec3>& before) {
    if (!split_.empty()) append_vertices(whole, before);
    for (std::size_t v = 0; v < vertices_.size(); ++v) whole.positions[vertices_[v]] = mesh_.positions[v];
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const glm::uvec3& c = mesh_.triangles[t];
      whole.triangles[triangles_[t]] = {vertices_[c.x], vertices_[c.y], vertices_[c.z]};
    }
  }

 private:
  // Returns a tree of the boxes that the triangles of moving vertices cannot leave.
  static mesh::BoxTree tree_of_reach(const mesh::Mesh& mesh, const std::vector<char>& moving,
                                     const glm::dmat3& to_metric) {
    const glm::dmat3 rows = glm::transpose(glm::inverse(to_metric));
    const glm::vec3 reach(kMostMove * glm::dvec3(glm::length(rows[0]), glm::length(rows[1]), glm::length(rows[2])));
    std::vector<mesh::FloatBox> boxes;
    for (const glm::uvec3& t : mesh.triangles) {
      if ((moving[t.x] | moving[t.y] | moving[t.z]) == 0) continue;
      const auto box = mesh::box_around(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]);
      boxes.push_back({box.min - reach, box.max + reach});
    }
    Buffer<mesh::BoxTree::Item> items(boxes.size());
    for (std::uint32_t i = 0; i < boxes.size(); ++i) items[i] = {boxes[i].center(), i};
    return {items.span(), [&](std::uint32_t i) { return boxes[i]; }};
  }

  void resize(std::size_t vertices, std::size_t triangles) {
    mesh_.positions = resized(mesh_.positions, vertices);
    mesh_.triangles = resized(mesh_.triangles, triangles);
    before_.resize(vertices);
  }

  // A new vertex has the normal and the attributes of the middle of its edge; put_back() sets its position.
  void append_vertices(mesh::Mesh& whole, std::vector<glm::vec3>& before) {
    std::vector<std::uint32_t> sources(whole.positions.size());
    std::iota(sources.begin(), sources.end(), 0U);
    for (const auto& [a, b] : split_) {
      vertices_.push_back(static_cast<std::uint32_t>(sources.size()));
      sources.push_back(sources[vertices_[a]]);
      before.push_back(before_[vertices_.size() - 1]);
    }
    const std::size_t first = whole.positions.size();
    mesh::gather_vertices(whole, sources);
    for (std::size_t n = 0; n < split_.size(); ++n) {  // in order: an end can be a new vertex, too
      const mesh::EdgePoint middle{vertices_[split_[n][0]], vertices_[split_[n][1]], 0.5};
      if (!whole.normals.empty()) whole.normals[first + n] = mesh::interpolated_normal(whole.normals, middle);
      for (mesh::Attribute& values : whole.attributes) mesh::set_interpolated(values, first + n, values, middle);
    }
    const std::size_t old = whole.triangles.size();
    whole.triangles = resized(whole.triangles, old + 2 * split_.size());
    for (std::size_t t = old; t < whole.triangles.size(); ++t) triangles_.push_back(static_cast<std::uint32_t>(t));
  }

  mesh::Mesh mesh_;
  std::vector<glm::vec3> before_;
  std::vector<std::uint32_t> vertices_;              // indices in the whole mesh, ascending
  std::vector<std::uint32_t> triangles_;             // indices in the whole mesh, ascending
  std::vector<std::array<std::uint32_t, 2>> split_;  // the edge of each new vertex
};

// Flips edges; in rounds without a flip moves vertices; and in rounds without a move splits edges. Returns whether
// anything changed.
Result<bool> untangle_patch(Patch& patch, const UntangleOptions& options, UntangleFigures& figures,
                            const Context& context) {
  mesh::Mesh& mesh = patch.mesh();
  bool any = false;
  std::uint64_t searched = std::numeric_limits<std::uint64_t>::max();  // pairs before the last search
  for (int round = 0; round < kMostRounds; ++round) {
    const auto found = TRY(mesh::find_self_intersections(mesh, {kMostPairs, kMostPairs}, context));
    if (found.pairs == 0) return any;
    const auto memory = TRY(context.reserve(2 * Neighbors::bytes(3 * mesh.triangles.size(), mesh.positions.size()) +
                                                std::max(EdgeFlips::bytes(mesh), PlaceSearch::bytes(mesh)) +
                                                Patch::split_bytes(found.pairs),
                                            mesh.name + ": the vertices of intersecting triangles"));
    ++figures.rounds;
    TRY(context.check());
    std::size_t changes = EdgeFlips(mesh, Signal(mesh, bounds_of(options))).run(found.examples, context);
    TRY(context.check());
    figures.flips += changes;
    any = any || changes > 0;
    if (changes > 0) continue;
    const bool gains_little = static_cast<double>(found.pairs) > (1 - kLeastGain) * static_cast<double>(searched);
    if (found.pairs > kMostSearched || (found.pairs > kFewPairs && gains_little)) return any;
    searched = found.pairs;
    {
      const Signal signal(mesh, bounds_of(options));
      PlaceSearch search(mesh, signal, patch.before(), {options.to_metric, kMostMove});
      changes = search.move_vertices(found.examples, context);
    }
    TRY(context.check());
    any = any || changes > 0;
    if (changes > 0) continue;
    changes = patch.split_edges(found.examples, options, context);
    TRY(context.check());
    figures.splits += changes;
    if (changes == 0) return any;
    any = true;
  }
  return any;
}

Result<UntangleFigures> untangle_mesh(mesh::Mesh& mesh, const UntangleOptions& options, const Context& context) {
  const Stopwatch watch;
  UntangleFigures figures;
  auto found = TRY(mesh::find_self_intersections(mesh, {kMostPairs, kMostPairs}, context));
  figures.pairs_before = figures.pairs_after = found.pairs;
  figures.more_before = found.at_least;
  if (found.pairs > 0) {
    const auto memory =
        TRY(context.reserve(Patch::bytes(mesh) + 2 * mesh.positions.size_bytes() + mesh.triangles.size_bytes(),
                            mesh.name + ": the triangles near intersections"));
    const std::vector<glm::vec3> old_positions(mesh.positions.begin(), mesh.positions.end());
    const std::vector<glm::uvec3> old_triangles(mesh.triangles.begin(), mesh.triangles.end());
    std::vector<glm::vec3> before = old_positions;
    for (int look = 0; look < kMostLooks && found.pairs > 0; ++look) {
      Patch patch(mesh, before, found.examples, options.to_metric);
      if (!TRY(untangle_patch(patch, options, figures, context))) break;
      patch.put_back(mesh, before);
      found = TRY(mesh::find_self_intersections(mesh, {kMostPairs, kMostPairs}, context));
    }
    figures.pairs_after = found.pairs;
    for (std::size_t v = 0; v < old_positions.size(); ++v) {
      const glm::dvec3 move = glm::dvec3(mesh.positions[v]) - glm::dvec3(old_positions[v]);
      figures.moved += move != glm::dvec3(0) ? 1 : 0;
      figures.greatest_move = std::max(figures.greatest_move, glm::length(options.to_metric * move));
    }
    figures.distance = TRY(bound_surface_change(old_positions, old_triangles, mesh, options.to_metric, context));
    mesh.edges = {};
  }
  figures.time = watch.elapsed();
  return figures;
}

}  // namespace

Result<UntangleFigures> untangle(mesh::Mesh& mesh, const UntangleOptions& options, const Context& context) {
  try {
    return untangle_mesh(mesh, options, context);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(mesh.name + ": moving the vertices of intersecting triangles needs more "
                                                       "memory than is available"));
  }
}

}  // namespace isoextract::edit
