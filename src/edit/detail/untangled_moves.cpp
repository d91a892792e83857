#include "edit/detail/untangled_moves.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/exact_sign.hpp"
#include "mesh/self_intersections.hpp"
#include "mesh/triangle_overlap.hpp"

namespace isoextract::edit {
namespace {

using TrianglePairs = std::vector<std::array<std::uint32_t, 2>>;

// The parts of a move that a vertex tries, one after the other.
constexpr std::array kParts{1.0, 0.5, 0.25, 0.0};

class MoveUntangler {
 public:
  MoveUntangler(mesh::Mesh& mesh, std::span<const glm::vec3> before, std::span<const glm::vec3> moves)
      : mesh_(mesh), before_(before), moves_(moves), part_(mesh.positions.size(), 0), changed_(part_.size(), 0) {}

  static std::uint64_t bytes(const mesh::Mesh& mesh) {
    return mesh.positions.size() * 2 + mesh::BoxTree::bytes(mesh.triangles.size());
  }

  // `pairs` are triangles that intersect.
  Result<void> run(TrianglePairs pairs, const Context& context) {
    std::erase_if(pairs, [&](const auto& pair) { return met_before(pair[0], pair[1]); });
    if (pairs.empty()) return {};
    const mesh::BoxTree tree = tree_of_moves();
    // Each round takes all vertices of each pair back by one part, so the rounds end.
    while (!pairs.empty()) {
      TRY(context.check());
      take_back(pairs);
      pairs = new_pairs(tree);
    }
    return {};
  }

  [[nodiscard]] std::uint64_t held() const {
    return static_cast<std::uint64_t>(std::ranges::count_if(part_, [](std::uint8_t part) { return part > 0; }));
  }

 private:
  [[nodiscard]] glm::vec3 place(std::uint32_t v) const {
    return glm::vec3(glm::dvec3(before_[v]) + kParts[part_[v]] * glm::dvec3(moves_[v]));
  }

  [[nodiscard]] static mesh::FloatBox box_of(std::span<const glm::vec3> positions, const glm::uvec3& t) {
    return mesh::box_around(positions[t.x], positions[t.y], positions[t.z]);
  }

  [[nodiscard]] bool meet(std::span<const glm::vec3> positions, std::uint32_t a, std::uint32_t b) const {
    const auto placed = [&](const glm::uvec3& t) {
      return mesh::PlacedTriangle{{glm::dvec3(positions[t.x]), glm::dvec3(positions[t.y]), glm::dvec3(positions[t.z])}};
    };
    const auto has_area = [](const mesh::PlacedTriangle& t) {
      return !mesh::are_collinear(t.corners[0], t.corners[1], t.corners[2]);
    };
    if (!box_of(positions, mesh_.triangles[a]).meets(box_of(positions, mesh_.triangles[b]))) return false;
    const mesh::PlacedTriangle p = placed(mesh_.triangles[a]);
    const mesh::PlacedTriangle q = placed(mesh_.triangles[b]);
    return has_area(p) && has_area(q) && mesh::find_overlap(p, q).meet;
  }

  [[nodiscard]] bool met_before(std::uint32_t a, std::uint32_t b) const { return meet(before_, a, b); }

  // Returns a tree of boxes that hold the triangles at all parts of their moves. No move may be taken back yet.
  [[nodiscard]] mesh::BoxTree tree_of_moves() const {
    const auto moved = std::as_const(mesh_.positions).span();
    const auto box = [&](std::uint32_t t) {
      return box_of(before_, mesh_.triangles[t]).with(box_of(moved, mesh_.triangles[t]));
    };
    Buffer<mesh::BoxTree::Item> items(mesh_.triangles.size());
    for_each_index(items.size(), [&](std::size_t t) {
      const auto number = static_cast<std::uint32_t>(t);
      items[t] = {box(number).center(), number};
    });
    return {items.span(), box};
  }

  void take_back(const TrianglePairs& pairs) {
    std::ranges::fill(changed_, 0);
    for (const auto& pair : pairs) {
      for (const std::uint32_t t : pair) {
        for (int corner = 0; corner < 3; ++corner) {
          const std::uint32_t v = mesh_.triangles[t][corner];
          if (changed_[v] != 0 || part_[v] + std::size_t{1} == kParts.size()) continue;
          changed_[v] = 1;
          ++part_[v];
          mesh_.positions[v] = place(v);
        }
      }
    }
  }

  [[nodiscard]] bool is_changed(std::uint32_t t) const {
    const glm::uvec3& c = mesh_.triangles[t];
    return (changed_[c.x] | changed_[c.y] | changed_[c.z]) != 0;
  }

  // Returns the pairs with a changed triangle. Every earlier pair has a changed triangle, so there are no others.
  [[nodiscard]] TrianglePairs new_pairs(const mesh::BoxTree& tree) const {
    const auto positions = std::as_const(mesh_.positions).span();
    TrianglePairs pairs;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (!is_changed(t)) continue;
      tree.for_each_near(box_of(positions, mesh_.triangles[t]), [&](std::uint32_t other) {
        if (other == t || (other < t && is_changed(other))) return;
        if (meet(positions, t, other) && !met_before(t, other)) pairs.push_back({t, other});
      });
    }
    return pairs;
  }

  mesh::Mesh& mesh_;
  std::span<const glm::vec3> before_;
  std::span<const glm::vec3> moves_;
  std::vector<std::uint8_t> part_;     // per vertex: index into kParts
  std::vector<std::uint8_t> changed_;  // 1: the vertex was taken back in this round
};

}  // namespace

Result<UntangledMoves> move_untangled(mesh::Mesh& mesh, const Buffer<glm::vec3>& moves, const Context& context) {
  constexpr std::uint64_t kMostPairs = 1 << 24;
  UntangledMoves result;
  result.before = std::move(mesh.positions);
  mesh.positions = Buffer<glm::vec3>(moves.size());
  for_each_index(moves.size(), [&](std::size_t v) {
    mesh.positions[v] = glm::vec3(glm::dvec3(result.before[v]) + glm::dvec3(moves[v]));
  });
  auto found = TRY(mesh::find_self_intersections(mesh, {kMostPairs, kMostPairs}, context));
  if (found.examples.empty()) return result;
  const auto memory = TRY(context.reserve(MoveUntangler::bytes(mesh), mesh.name + ": taking moves back"));
  MoveUntangler untangler(mesh, result.before.span(), moves.span());
  TRY(untangler.run(std::move(found.examples), context));
  result.held_vertices = untangler.held();
  return result;
}

}  // namespace isoextract::edit
