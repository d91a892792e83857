// The vertex positions of a mesh as a signal on its edges, which smoothing filters.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "base/parallel.hpp"
#include "edit/smooth.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::edit {

using Neighbors = mesh::Buckets<std::uint32_t>;

inline constexpr std::size_t kVerticesAtATime = 1 << 12;

template <class Body>
void for_each_vertex(std::size_t count, const Body& body) {
  for_each_index(count, body, kVerticesAtATime);
}

// Lists for each vertex the next (outgoing) or previous vertex of its triangles. The lists differ at boundary edges.
inline Neighbors ends_of_edges(const mesh::Mesh& mesh, bool outgoing) {
  return {mesh.triangles.size(), mesh.positions.size(), [&mesh, outgoing](std::size_t i, const auto& put) {
            const glm::uvec3& t = mesh.triangles[i];
            if (mesh::has_repeated_index(t)) return;
            for (int c = 0; c < 3; ++c) {
              const std::uint32_t from = t[c];
              const std::uint32_t to = t[(c + 1) % 3];
              if (outgoing)
                put(from, to);
              else
                put(to, from);
            }
          }};
}

// Bits that say how a vertex may move.
inline constexpr std::uint8_t kFixed = 8;   // does not move; lower bits 1, 2, 4: not along x, y, z of the box
inline constexpr std::uint8_t kInCut = 16;  // does not move either: it lies in a cut

class Signal {
 public:
  Signal(const mesh::Mesh& mesh, const SmoothOptions& options)
      : mesh_(mesh), neighbors_(ends_of_edges(mesh, true)), constraints_(mesh.positions.size()), walls_(options.walls) {
    if (walls_) from_box_ = glm::inverse(walls_->to_box);
    const Neighbors incoming = ends_of_edges(mesh, false);
    for_each_vertex(mesh.positions.size(), [&](std::size_t v) {
      const auto out = neighbors_.at(v);
      constraints_[v] = out.empty() || !std::ranges::equal(out, incoming.at(v)) ? kFixed : sides_at(v);
    });
    keep_cuts(options.cuts);
  }

  // Returns the mean of the neighbors minus the vertex, for positions moved by `moves`. Keeps only the components in
  // which the vertex may move.
  [[nodiscard]] glm::dvec3 laplacian(const Buffer<glm::vec3>& moves, std::size_t v) const {
    if (constraints_[v] >= kFixed) return glm::dvec3(0);
    const glm::dvec3 here = glm::dvec3(mesh_.positions[v]) + glm::dvec3(moves[v]);
    glm::dvec3 sum(0);
    const auto near = neighbors_.at(v);
    for (const std::uint32_t n : near) sum += glm::dvec3(mesh_.positions[n]) + glm::dvec3(moves[n]) - here;
    sum /= static_cast<double>(near.size());
    return allowed_part(constraints_[v], sum);
  }

  // Returns the part of a move that a vertex with these bits may make.
  [[nodiscard]] glm::dvec3 allowed_part(std::uint8_t constraints, const glm::dvec3& move) const {
    if (constraints >= kFixed) return glm::dvec3(0);
    if (constraints == 0) return move;
    glm::dvec3 in_box = walls_->to_box * move;
    for (int axis = 0; axis < 3; ++axis) {
      if ((constraints >> axis & 1) != 0) in_box[axis] = 0;
    }
    return from_box_ * in_box;
  }

  // Returns the bits that all corners of a triangle have: those of the cap that it belongs to.
  [[nodiscard]] std::uint8_t sides_of(const glm::uvec3& t) const {
    return constraints_[t.x] & constraints_[t.y] & constraints_[t.z];
  }

  [[nodiscard]] std::uint8_t constraints(std::size_t v) const { return constraints_[v]; }
  [[nodiscard]] std::span<const std::uint32_t> neighbors(std::size_t v) const { return neighbors_.at(v); }

 private:
  void keep_cuts(std::span<const mesh::HalfSpace> cuts) {
    if (cuts.empty()) return;
    const double on_plane = 2 * mesh::on_plane_tolerance(mesh::farthest_coordinate(mesh_.positions.span()));
    for_each_vertex(mesh_.positions.size(), [&](std::size_t v) {
      const glm::dvec3 p = mesh_.position(v);
      if (std::ranges::any_of(cuts, [&](const mesh::HalfSpace& cut) { return std::abs(cut.depth(p)) <= on_plane; })) {
        if (constraints_[v] != kFixed) constraints_[v] = kInCut;
      }
    });
  }

  [[nodiscard]] std::uint8_t sides_at(std::size_t v) const {
    if (!walls_) return 0;
    constexpr double kNear = 1e-4;
    const glm::dvec3 p = walls_->to_box * mesh_.position(v) + walls_->offset;
    std::uint8_t sides = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(p[axis] - walls_->min[axis]) <= kNear || std::abs(p[axis] - walls_->max[axis]) <= kNear) {
        sides = static_cast<std::uint8_t>(sides | 1 << axis);
      }
    }
    return sides;
  }

  const mesh::Mesh& mesh_;
  Neighbors neighbors_;
  Buffer<std::uint8_t> constraints_;
  std::optional<DataBox> walls_;
  glm::dmat3 from_box_{1.0};
};

inline Buffer<glm::vec3> no_moves(std::size_t count) {
  Buffer<glm::vec3> moves(count);
  std::ranges::fill(moves, glm::vec3(0));
  return moves;
}

}  // namespace isoextract::edit
