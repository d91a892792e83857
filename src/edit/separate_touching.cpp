#include "edit/separate_touching.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/allocation_error.hpp"
#include "base/parallel.hpp"
#include "edit/detail/vertex_cone.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/coincident_vertices.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::edit {
namespace {

constexpr double kFloatSteps = 8;
// A vertex moves off the planes of its triangles by at least this many float32 steps, against rounding.
constexpr double kStepsOffPlanes = 2;
constexpr double kLastSlope = 1e-6;  // without regard to rounding, if the vertices would stay together otherwise
constexpr double kMostTimesDistance = 20;

// A vertex that shares its position with other vertices, and its new position.
struct TouchingVertex {
  std::uint32_t first;  // the first vertex at the position
  std::uint32_t vertex;
  glm::vec3 to{0.0F};
};

// Lists the vertices that share their position, grouped by position.
std::vector<TouchingVertex> list_touching(std::span<const glm::vec3> positions) {
  const mesh::CoincidentVertices places(positions);
  std::vector<TouchingVertex> touching;
  if (places.repeated() == 0) return touching;
  std::vector<bool> listed(positions.size());
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    const std::uint32_t first = places.of_vertex(v);
    if (first == v) continue;
    if (!listed[first]) touching.push_back({first, first, positions[first]});
    listed[first] = true;
    touching.push_back({first, v, positions[v]});
  }
  std::ranges::sort(touching, {}, [](const TouchingVertex& t) { return std::pair(t.first, t.vertex); });
  return touching;
}

// Returns the distance between float32 numbers at the largest coordinate of the position.
double float_step_at(const glm::dvec3& position) {
  const auto size = static_cast<float>(std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)}));
  return static_cast<double>(std::nextafter(size, std::numeric_limits<float>::infinity()) - size);
}

class Separation {
 public:
  Separation(const mesh::Mesh& mesh, double voxels, const glm::dmat3& voxel)
      : mesh_(mesh), voxels_(voxels), adjacency_(mesh.triangles.span(), mesh.positions.size()) {
    if (!(std::abs(glm::determinant(voxel)) > 0)) return;
    voxel_ = voxel;
    to_voxels_ = glm::inverse(voxel);
    shortest_edge_ = std::min({glm::length(voxel[0]), glm::length(voxel[1]), glm::length(voxel[2])});
  }

  // Finds where the vertices of one position move to.
  void separate(std::span<TouchingVertex> together) const {
    const double step = float_step_at(mesh_.position(together.front().vertex)) / shortest_edge_;
    const double move = std::max(voxels_, kFloatSteps * step);
    const double least_slope = kStepsOffPlanes * step / move;
    if (!(move <= kMostTimesDistance * voxels_)) return;
    std::vector<VertexCone> cones;
    for (const TouchingVertex& t : together) cones.emplace_back(mesh_, adjacency_.corners(t.vertex), to_voxels_);
    std::vector<double> signs;
    std::size_t staying = 0;
    std::vector<std::optional<glm::dvec3>> ways;
    for (std::size_t i = 0; i < cones.size(); ++i) {
      signs.push_back(own_side(cones, i));
      ways.push_back(signs[i] != 0 ? cones[i].way_off(signs[i], least_slope) : std::nullopt);
      staying += ways[i] ? 0 : 1;
    }
    for (std::size_t i = 0; i < cones.size(); ++i) {
      if (!ways[i] && staying > 1 && signs[i] != 0) {
        ways[i] = cones[i].way_off(signs[i], least_slope, cones);
        if (!ways[i]) ways[i] = cones[i].way_off(signs[i], kLastSlope);
      }
    }
    bool one_stays = false;
    for (std::size_t i = 0; i < cones.size(); ++i) {
      const bool lacks_way = !ways[i] && !cones[i].empty();  // a vertex without triangles touches nothing
      if (lacks_way && std::exchange(one_stays, true)) ways[i] = cones[i].mean_way(signs[i] != 0 ? signs[i] : -1);
      if (ways[i]) together[i].to = glm::vec3(glm::dvec3(together[i].to) + voxel_ * (move * *ways[i]));
    }
  }

 private:
  // Returns 1 if all other cones are inside of cone i, -1 if they are outside, 0 if they are on both sides.
  static double own_side(const std::vector<VertexCone>& cones, std::size_t i) {
    double sign = 0;
    for (std::size_t other = 0; other < cones.size(); ++other) {
      if (other == i || cones[other].empty()) continue;
      const double away = -std::copysign(1.0, cones[i].side_of(cones[other]));
      if (sign != 0 && sign != away) return 0;
      sign = away;
    }
    return sign;
  }

  const mesh::Mesh& mesh_;
  double voxels_;
  glm::dmat3 voxel_{1.0};
  glm::dmat3 to_voxels_{1.0};
  double shortest_edge_ = 1;
  mesh::Adjacency adjacency_;
};

SeparationFigures move_apart(mesh::Mesh& mesh, const Separation& separation, std::vector<TouchingVertex>& touching,
                             const Context& context) {
  std::vector<std::span<TouchingVertex>> groups;
  for (std::size_t begin = 0; begin < touching.size();) {
    std::size_t end = begin + 1;
    while (end < touching.size() && touching[end].first == touching[begin].first) ++end;
    groups.push_back(std::span(touching).subspan(begin, end - begin));
    begin = end;
  }
  constexpr std::size_t kGroupsAtATime = 64;
  for_each_index(
      groups.size(),
      [&](std::size_t g) {
        if (!context.cancelled()) separation.separate(groups[g]);
      },
      kGroupsAtATime);
  SeparationFigures figures;
  figures.touching = touching.size();
  figures.volume_before = mesh::measure_size(mesh).volume;
  for (const TouchingVertex& t : touching) {
    const double move = glm::distance(glm::dvec3(mesh.positions[t.vertex]), glm::dvec3(t.to));
    figures.moved += move > 0 ? 1 : 0;
    figures.greatest_move = std::max(figures.greatest_move, move);
    mesh.positions[t.vertex] = t.to;
  }
  figures.volume_after = mesh::measure_size(mesh).volume;
  return figures;
}

}  // namespace

Result<SeparationFigures> separate_touching_vertices(mesh::Mesh& mesh, double voxels, const glm::dmat3& voxel,
                                                     const Context& context) {
  const std::string what = mesh.name + ": the vertices at equal positions";
  const std::uint64_t vertices = mesh.positions.size();
  try {
    std::vector<TouchingVertex> touching;
    {
      const auto memory = TRY(context.reserve(mesh::CoincidentVertices::bytes(vertices), what));
      touching = list_touching(mesh.positions.span());
    }
    if (touching.empty()) return SeparationFigures();
    const auto memory =
        TRY(context.reserve(mesh::Adjacency::bytes(mesh.triangles.size(), vertices) +
                                touching.size() * (sizeof(TouchingVertex) + sizeof(std::span<TouchingVertex>)),
                            what));
    const SeparationFigures figures = move_apart(mesh, Separation(mesh, voxels, voxel), touching, context);
    TRY(context.check());
    return figures;
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
}

}  // namespace isoextract::edit
