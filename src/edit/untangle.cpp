#include "edit/untangle.hpp"

#include <algorithm>
#include <array>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "base/allocation_error.hpp"
#include "edit/detail/smooth_signal.hpp"
#include "edit/detail/untangled_moves.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/exact_sign.hpp"
#include "mesh/self_intersections.hpp"
#include "mesh/triangle_overlap.hpp"

namespace isoextract::edit {
namespace {

constexpr int kMostRounds = 40;
constexpr int kRoundsARing = 8;  // after so many rounds of moves, vertices one edge farther away move, too
constexpr std::uint64_t kMostPairs = 1 << 20;
constexpr double kMostMove = 1;  // in the space of UntangleOptions::to_metric

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

// Flips edges of intersecting triangles, where that leaves fewer pairs. Changes the surface only within the two
// triangles of an edge.
class EdgeFlips {
 public:
  EdgeFlips(mesh::Mesh& mesh, const Signal& signal)
      : mesh_(mesh),
        signal_(signal),
        around_(mesh.triangles.span(), mesh.positions.size()),
        tree_(tree_of(mesh)),
        slots_(mesh.triangles.size()),
        changed_(mesh.positions.size(), 0) {
    const auto numbers = tree_.numbers();
    for (std::uint32_t slot = 0; slot < numbers.size(); ++slot) slots_[numbers[slot]] = slot;
  }

  static std::uint64_t bytes(const mesh::Mesh& mesh) {
    return mesh::Adjacency::bytes(mesh.triangles.size(), mesh.positions.size()) +
           mesh::BoxTree::bytes(mesh.triangles.size()) + mesh.triangles.size() * sizeof(std::uint32_t) +
           mesh.positions.size();
  }

  // Flips at most one edge at each vertex, and returns the number of flips. For more flips, make a new object.
  std::size_t run(const Pairs& pairs) {
    std::size_t flips = 0;
    for (const auto& pair : pairs) {
      std::optional<Flip> best;
      for (const std::uint32_t t : pair) {
        for (int corner = 0; corner < 3; ++corner) {
          const auto flip = flip_at(t, corner);
          if (flip && (!best || flip->gain > best->gain)) best = flip;
        }
      }
      if (!best) continue;
      apply(*best);
      ++flips;
    }
    return flips;
  }

 private:
  struct Flip {
    std::array<std::uint32_t, 2> triangles;
    std::array<glm::uvec3, 2> corners;  // after the flip
    std::size_t gain;                   // of pairs
  };

  static mesh::FloatBox box_of(const mesh::Mesh& mesh, const glm::uvec3& t) {
    return mesh::box_around(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]);
  }

  static mesh::BoxTree tree_of(const mesh::Mesh& mesh) {
    Buffer<mesh::BoxTree::Item> items(mesh.triangles.size());
    for_each_index(items.size(), [&](std::size_t t) {
      items[t] = {box_of(mesh, mesh.triangles[t]).center(), static_cast<std::uint32_t>(t)};
    });
    return {items.span(), [&](std::uint32_t t) { return box_of(mesh, mesh.triangles[t]); }};
  }

  [[nodiscard]] mesh::PlacedTriangle placed(const glm::uvec3& t) const {
    return {{glm::dvec3(mesh_.positions[t.x]), glm::dvec3(mesh_.positions[t.y]), glm::dvec3(mesh_.positions[t.z])}};
  }

  [[nodiscard]] bool has_area(const glm::uvec3& t) const {
    const mesh::PlacedTriangle p = placed(t);
    return !mesh::are_collinear(p.corners[0], p.corners[1], p.corners[2]);
  }

  [[nodiscard]] bool meet(const glm::uvec3& a, const glm::uvec3& b) const {
    return box_of(mesh_, a).meets(box_of(mesh_, b)) && mesh::find_overlap(placed(a), placed(b)).meet && has_area(a) &&
           has_area(b);
  }

  // Counts the intersections of two triangles with each other and with all triangles except `numbers`.
  [[nodiscard]] std::size_t count_pairs(const std::array<glm::uvec3, 2>& triangles,
                                        const std::array<std::uint32_t, 2>& numbers) const {
    std::size_t count = meet(triangles[0], triangles[1]) ? 1 : 0;
    for (const glm::uvec3& t : triangles) {
      tree_.for_each_near(box_of(mesh_, t), [&](std::uint32_t other) {
        if (other != numbers[0] && other != numbers[1] && meet(t, mesh_.triangles[other])) ++count;
      });
    }
    return count;
  }

  // Returns the corner at which the edge from b to a starts; nothing if several triangles or none have this edge.
  [[nodiscard]] std::optional<mesh::Corner> across(std::uint32_t a, std::uint32_t b) const {
    std::optional<mesh::Corner> found;
    for (const mesh::Corner corner : around_.corners(b)) {
      const glm::uvec3& t = mesh_.triangles[mesh::triangle_of(corner)];
      if (t[static_cast<int>((corner % 3 + 1) % 3)] != a) continue;
      if (found) return std::nullopt;
      found = corner;
    }
    return found;
  }

  [[nodiscard]] bool are_joined(std::uint32_t a, std::uint32_t b) const {
    return std::ranges::any_of(around_.corners(a), [&](mesh::Corner corner) {
      const glm::uvec3& t = mesh_.triangles[mesh::triangle_of(corner)];
      return t.x == b || t.y == b || t.z == b;
    });
  }

  // Returns the flip of the edge that starts at this corner; nothing unless it leaves fewer intersecting pairs.
  [[nodiscard]] std::optional<Flip> flip_at(std::uint32_t t, int corner) const {
    const glm::uvec3& own = mesh_.triangles[t];
    const std::uint32_t a = own[corner];
    const std::uint32_t b = own[(corner + 1) % 3];
    const std::uint32_t c = own[(corner + 2) % 3];
    if (changed_[a] != 0 || changed_[b] != 0 || changed_[c] != 0) return std::nullopt;
    const auto other_corner = across(a, b);
    if (!other_corner) return std::nullopt;
    const auto other = static_cast<std::uint32_t>(mesh::triangle_of(*other_corner));
    const std::uint32_t d = mesh_.triangles[other][static_cast<int>((*other_corner % 3 + 2) % 3)];
    if (d == c || changed_[d] != 0 || are_joined(c, d)) return std::nullopt;
    if ((signal_.bound(a) | signal_.bound(b) | signal_.bound(c) | signal_.bound(d)) != 0) return std::nullopt;
    Flip flip{{t, other}, {glm::uvec3(a, d, c), glm::uvec3(d, b, c)}, 0};
    if (!has_area(flip.corners[0]) || !has_area(flip.corners[1])) return std::nullopt;
    const std::size_t before = count_pairs({own, mesh_.triangles[other]}, flip.triangles);
    const std::size_t after = count_pairs(flip.corners, flip.triangles);
    if (after >= before) return std::nullopt;
    flip.gain = before - after;
    return flip;
  }

  void apply(const Flip& flip) {
    for (std::size_t i = 0; i < 2; ++i) {
      mesh_.triangles[flip.triangles[i]] = flip.corners[i];
      tree_.enlarge(slots_[flip.triangles[i]], box_of(mesh_, flip.corners[i]));
      for (int corner = 0; corner < 3; ++corner) changed_[flip.corners[i][corner]] = 1;
    }
  }

  mesh::Mesh& mesh_;
  const Signal& signal_;
  mesh::Adjacency around_;  // of the triangles before the flips
  mesh::BoxTree tree_;
  std::vector<std::uint32_t> slots_;
  std::vector<char> changed_;  // 1: around_ is outdated at this vertex
};

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

// The triangles that untangling can change or meet, as a mesh of their own. Its boundary stays in place.
class Patch {
 public:
  Patch(const mesh::Mesh& mesh, const Pairs& pairs, const glm::dmat3& to_metric) {
    const std::vector<char> moving = vertices_around(mesh, pairs, kMostRounds / kRoundsARing);
    const std::vector<char> kept = vertices_around(mesh, pairs, kMostRounds / kRoundsARing + 2);
    const mesh::BoxTree reached = tree_of_reach(mesh, moving, to_metric);
    std::vector<char> chosen(mesh.triangles.size(), 0);
    for_each_index(chosen.size(), [&](std::size_t t) {
      const glm::uvec3& c = mesh.triangles[t];
      bool near = (kept[c.x] | kept[c.y] | kept[c.z]) != 0;
      const auto box = mesh::box_around(mesh.positions[c.x], mesh.positions[c.y], mesh.positions[c.z]);
      if (!near) reached.for_each_near(box, [&](std::uint32_t) { near = true; });
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
    mesh_.positions = Buffer<glm::vec3>(vertices_.size());
    for (std::size_t v = 0; v < vertices_.size(); ++v) mesh_.positions[v] = mesh.positions[vertices_[v]];
    mesh_.triangles = Buffer<glm::uvec3>(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const glm::uvec3& c = mesh.triangles[triangles_[t]];
      mesh_.triangles[t] = {number[c.x], number[c.y], number[c.z]};
    }
  }

  static std::uint64_t bytes(const mesh::Mesh& whole) {
    const std::size_t vertices = whole.positions.size();
    const std::size_t triangles = whole.triangles.size();
    return vertices * (sizeof(glm::vec3) + 2 * sizeof(std::uint32_t) + 3) + mesh::BoxTree::bytes(triangles) +
           triangles * (sizeof(glm::uvec3) + 2 * sizeof(std::uint32_t) + 1);
  }

  mesh::Mesh& mesh() { return mesh_; }

  void put_back(mesh::Mesh& whole) const {
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

  mesh::Mesh mesh_;
  std::vector<std::uint32_t> vertices_;   // of the whole mesh, ascending
  std::vector<std::uint32_t> triangles_;  // of the whole mesh, ascending
};

Result<void> untangle_patch(mesh::Mesh& mesh, const UntangleOptions& options, UntangleFigures& figures,
                            const Context& context) {
  const std::size_t vertices = mesh.positions.size();
  const auto memory = TRY(context.reserve(2 * Neighbors::bytes(3 * mesh.triangles.size(), vertices) +
                                              EdgeFlips::bytes(mesh) + vertices * (4 * sizeof(glm::vec3) + 3),
                                          mesh.name + ": the vertices of intersecting triangles"));
  const std::vector<glm::vec3> before(mesh.positions.begin(), mesh.positions.end());
  SmoothOptions bounds;
  bounds.walls = options.walls;
  bounds.cuts = options.cuts;
  const Buffer<glm::vec3> none = no_moves(vertices);
  int moves_done = 0;
  auto found = TRY(mesh::find_self_intersections(mesh, {kMostPairs, kMostPairs}, context));
  while (found.pairs > 0 && figures.rounds < kMostRounds) {
    TRY(context.check());
    const Signal signal(mesh, bounds);  // flips change the neighbors
    const std::size_t flips = EdgeFlips(mesh, signal).run(found.examples);
    figures.flips += flips;
    if (flips == 0) {
      const std::vector<char> moving = vertices_around(mesh, found.examples, moves_done++ / kRoundsARing);
      Buffer<glm::vec3> moves(vertices);
      for_each_vertex(vertices, [&](std::size_t v) {
        const glm::dvec3 moved = options.to_metric * (glm::dvec3(mesh.positions[v]) - glm::dvec3(before[v]));
        const bool may_move = moving[v] != 0 && glm::length(moved) < kMostMove / 2;
        const glm::dvec3 move = may_move ? signal.laplacian(none, v) : glm::dvec3(0);
        const double length = glm::length(options.to_metric * move);
        moves[v] = length > kMostMove / 2 ? glm::vec3(move * (kMostMove / 2 / length)) : glm::vec3(move);
      });
      TRY(move_untangled(mesh, moves, context));
    }
    found = TRY(mesh::find_self_intersections(mesh, {kMostPairs, kMostPairs}, context));
    ++figures.rounds;
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    const glm::dvec3 move = glm::dvec3(mesh.positions[v]) - glm::dvec3(before[v]);
    figures.moved += move != glm::dvec3(0) ? 1 : 0;
    figures.greatest_move = std::max(figures.greatest_move, glm::length(options.to_metric * move));
  }
  return {};
}

Result<UntangleFigures> untangle_mesh(mesh::Mesh& mesh, const UntangleOptions& options, const Context& context) {
  const Stopwatch watch;
  UntangleFigures figures;
  const auto found = TRY(mesh::find_self_intersections(mesh, {kMostPairs, kMostPairs}, context));
  figures.pairs_before = figures.pairs_after = found.pairs;
  figures.more_before = found.at_least;
  if (found.pairs > 0) {
    if (found.at_least) {  // the pairs beyond the limit can be anywhere
      TRY(untangle_patch(mesh, options, figures, context));
    } else {
      const auto memory = TRY(context.reserve(Patch::bytes(mesh), mesh.name + ": the triangles near intersections"));
      Patch patch(mesh, found.examples, options.to_metric);
      TRY(untangle_patch(patch.mesh(), options, figures, context));
      patch.put_back(mesh);
    }
    figures.pairs_after = TRY(mesh::find_self_intersections(mesh, {kMostPairs, 0}, context)).pairs;
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
