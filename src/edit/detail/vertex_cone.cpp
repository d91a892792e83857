#include "edit/detail/vertex_cone.hpp"

#include <algorithm>
#include <cmath>

namespace isoextract::edit {
namespace {

// Returns the shortest vector in the convex hull of the vectors, by steps to the vector that is least along the current
// one (E. G. Gilbert, An iterative procedure for computing the minimum of a quadratic form on a convex set. SIAM J.
// Control 4(1), 1966). For unit vectors, it has the direction whose smallest cosine to them is largest.
glm::dvec3 shortest_in_hull(std::span<const glm::dvec3> vectors, glm::dvec3 start) {
  constexpr int kMostSteps = 200;
  glm::dvec3 p = start;
  for (int step = 0; step < kMostSteps; ++step) {
    const glm::dvec3 least =
        *std::ranges::min_element(vectors, {}, [&](const glm::dvec3& v) { return glm::dot(v, p); });
    const glm::dvec3 way = least - p;
    const double gain = -glm::dot(p, way);
    const double squared = glm::dot(way, way);
    if (!(gain > 1e-4 * glm::dot(p, p)) || !(squared > 0)) break;
    p += std::min(gain / squared, 1.0) * way;
  }
  return p;
}

}  // namespace

VertexCone::VertexCone(const mesh::Mesh& mesh, std::span<const mesh::Corner> corners, const glm::dmat3& to_metric) {
  for (const mesh::Corner corner : corners) {
    const glm::uvec3& t = mesh.triangles[mesh::triangle_of(corner)];
    const int at = static_cast<int>(corner % 3);
    const glm::dvec3 apex(mesh.positions[t[at]]);
    const glm::dvec3 first = to_metric * (glm::dvec3(mesh.positions[t[(at + 1) % 3]]) - apex);
    const glm::dvec3 second = to_metric * (glm::dvec3(mesh.positions[t[(at + 2) % 3]]) - apex);
    const glm::dvec3 normal = glm::cross(first, second);
    const double area = glm::length(normal);
    if (!(area > 0)) continue;
    const double angle = std::atan2(area, glm::dot(first, second));
    sectors_.push_back({glm::normalize(first), glm::normalize(second), normal / area, angle});
    normal_ += angle * sectors_.back().normal;
  }
}

double VertexCone::signed_distance(const glm::dvec3& direction) const {
  constexpr double kTie = 1e-9;
  double least = 2;
  glm::dvec3 normal(0.0);
  const auto consider = [&](double distance, const glm::dvec3& n) {
    if (distance > least + kTie) return;
    if (distance < least - kTie) normal = glm::dvec3(0.0);
    least = std::min(least, distance);
    normal += n;
  };
  for (const Sector& s : sectors_) {
    const double height = glm::dot(s.normal, direction);
    const bool is_over = glm::dot(glm::cross(s.first, direction), s.normal) >= 0 &&
                         glm::dot(glm::cross(direction, s.second), s.normal) >= 0;
    if (is_over) {
      consider(std::abs(height), s.normal);
      continue;
    }
    const double along = std::max({glm::dot(s.first, direction), glm::dot(s.second, direction), 0.0});
    if (along > 0) consider(std::sqrt(std::max(1 - along * along, 0.0)), s.normal);
  }
  if (least > 1) return std::copysign(1.0, glm::dot(normal_, direction));  // the vertex is closest
  return std::copysign(least, glm::dot(normal, direction));
}

double VertexCone::side_of(const VertexCone& other) const {
  double farthest = 0;
  for (const Sector& s : other.sectors_) {
    const glm::dvec3 middle = s.first + s.second;
    const double length = glm::length(middle);
    if (!(length > 0)) continue;
    const double distance = signed_distance(middle / length);
    if (std::abs(distance) > std::abs(farthest)) farthest = distance;
  }
  return farthest;
}

bool VertexCone::has_edge(const glm::dvec3& direction) const {
  constexpr double kSame = 1e-12;
  const auto same = [&](const glm::dvec3& d) { return glm::dot(d - direction, d - direction) < kSame; };
  return std::ranges::any_of(sectors_, [&](const Sector& s) { return same(s.first) || same(s.second); });
}

std::optional<glm::dvec3> VertexCone::way_off(double sign, double least_slope,
                                              std::span<const VertexCone> others) const {
  std::vector<glm::dvec3> normals;
  glm::dvec3 mean(0.0);
  double angles = 0;
  for (const Sector& s : sectors_) {
    const bool counts = others.empty() || std::ranges::any_of(others, [&](const VertexCone& other) {
                          return &other != this && (other.has_edge(s.first) || other.has_edge(s.second));
                        });
    if (!counts) continue;
    normals.push_back(sign * s.normal);
    mean += s.angle * normals.back();
    angles += s.angle;
  }
  if (normals.empty()) return std::nullopt;
  const glm::dvec3 way = shortest_in_hull(normals, mean / angles);
  const double length = glm::length(way);
  if (!(length > 0)) return std::nullopt;
  const glm::dvec3 unit = way / length;
  double slope = 1;
  for (const glm::dvec3& n : normals) slope = std::min(slope, glm::dot(n, unit));
  return slope >= least_slope ? std::optional(unit) : std::nullopt;
}

std::optional<glm::dvec3> VertexCone::mean_way(double sign) const {
  const double length = glm::length(normal_);
  return length > 0 ? std::optional(sign * normal_ / length) : std::nullopt;
}

}  // namespace isoextract::edit
