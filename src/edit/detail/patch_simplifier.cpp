#include "edit/detail/patch_simplifier.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "mesh/adjacency.hpp"
#include "mesh/closest_point.hpp"

namespace isoextract::edit {
namespace {

// The sum of weighted squared distances to planes: p^T A p + 2 b^T p + c, and the sum of the weights.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  glm::dvec3 b{0.0};
  double c = 0;
  double weight = 0;

  void add_plane(const glm::dvec3& normal, const glm::dvec3& point, double area) {
    const double d = -glm::dot(normal, point);
    xx += area * normal.x * normal.x;
    xy += area * normal.x * normal.y;
    xz += area * normal.x * normal.z;
    yy += area * normal.y * normal.y;
    yz += area * normal.y * normal.z;
    zz += area * normal.z * normal.z;
    b += area * d * normal;
    c += area * d * d;
    weight += area;
  }
  void add(const Quadric& other) {
    xx += other.xx;
    xy += other.xy;
    xz += other.xz;
    yy += other.yy;
    yz += other.yz;
    zz += other.zz;
    b += other.b;
    c += other.c;
    weight += other.weight;
  }
  // The mean square of the distances of p.
  [[nodiscard]] double error(const glm::dvec3& p) const {
    const glm::dvec3 a(xx * p.x + xy * p.y + xz * p.z, xy * p.x + yy * p.y + yz * p.z, xz * p.x + yz * p.y + zz * p.z);
    const double sum = glm::dot(p, a) + 2 * glm::dot(b, p) + c;
    return weight > 0 ? std::max(sum, 0.0) / weight : 0;
  }
};

class PatchSimplifier {
 public:
  PatchSimplifier(std::span<const glm::vec3> positions, std::vector<Face> patch, double distance,
                  const FaceFilter& allowed)
      : mesh_positions_(positions),
        faces_(std::move(patch)),
        distance_squared_(distance * distance),
        allowed_(allowed) {
    number_vertices();
    look_around_vertices();
    sum_quadrics();
  }

  std::vector<Face> run() {
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) push(v);
    while (!queue_.empty()) {
      const Candidate candidate = queue_.top();
      queue_.pop();
      if (candidate.version == version_[candidate.vertex]) try_to_remove(candidate.vertex);
    }
    std::vector<Face> left;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (gone_[f] != 0) continue;
      const glm::uvec3& t = corners_[f];
      left.push_back({{vertices_[t.x], vertices_[t.y], vertices_[t.z]}, std::move(faces_[f].represents)});
    }
    return left;
  }

 private:
  struct Candidate {
    double cost;
    std::uint32_t vertex;
    std::uint32_t version;
    bool operator<(const Candidate& other) const {  // std::priority_queue has the greatest on top
      return cost != other.cost ? cost > other.cost : vertex > other.vertex;
    }
  };
  using Corners = glm::uvec3;

  // Numbers from 0, and coordinates relative to one vertex, so that products of them keep their digits.
  void number_vertices() {
    for (const Face& face : faces_) {
      vertices_.insert(vertices_.end(), {face.corners.x, face.corners.y, face.corners.z});
    }
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    const auto number = [&](std::uint32_t vertex) {
      return static_cast<std::uint32_t>(std::lower_bound(vertices_.begin(), vertices_.end(), vertex) -
                                        vertices_.begin());
    };
    origin_ = mesh_positions_[vertices_[vertices_.size() / 2]];
    for (const std::uint32_t vertex : vertices_) places_.push_back(place_of(vertex));
    for (const Face& face : faces_) {
      const Corners& t = face.corners;
      corners_.emplace_back(number(t.x), number(t.y), number(t.z));
    }
    gone_.assign(faces_.size(), 0);
    version_.assign(vertices_.size(), 0);
  }

  [[nodiscard]] glm::dvec3 place_of(std::uint32_t mesh_vertex) const {
    return glm::dvec3(mesh_positions_[mesh_vertex]) - origin_;
  }

  // The fixed ones are those of the border, and those where the patch is no manifold: what is not one closed fan.
  void look_around_vertices() {
    const mesh::Adjacency adjacency(corners_, vertices_.size());
    star_.resize(vertices_.size());
    fixed_.assign(vertices_.size(), 0);
    mesh::VertexStar star;
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      const auto corners = adjacency.corners(v);
      star.look_at(corners, corners_);
      fixed_[v] = star.is_closed_fan() ? 0 : 1;
      star_[v].resize(corners.size());
      std::ranges::transform(corners, star_[v].begin(),
                             [](mesh::Corner c) { return static_cast<std::uint32_t>(mesh::triangle_of(c)); });
    }
  }

  void sum_quadrics() {
    quadrics_.resize(vertices_.size());
    for (const Corners& t : corners_) {
      const glm::dvec3 cross = cross_product(t);
      const double length = glm::length(cross);
      if (!(length > 0)) continue;
      for (int corner = 0; corner < 3; ++corner) {
        quadrics_[t[corner]].add_plane(cross / length, places_[t.x], length / 2);
      }
    }
  }

  [[nodiscard]] glm::dvec3 cross_product(const Corners& t) const {
    return glm::cross(places_[t.y] - places_[t.x], places_[t.z] - places_[t.x]);
  }

  // The edge of face f that v is not on, in the direction of the face.
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> opposite(std::uint32_t f, std::uint32_t v) const {
    const Corners& t = corners_[f];
    if (t.x == v) return {t.y, t.z};
    if (t.y == v) return {t.z, t.x};
    return {t.x, t.y};
  }

  [[nodiscard]] double cost(std::uint32_t from, std::uint32_t to) const {
    Quadric sum = quadrics_[from];
    sum.add(quadrics_[to]);
    return sum.error(places_[to]);
  }

  // The neighbours of a vertex that is not fixed: where its ring's edges start.
  void push(std::uint32_t v) {
    ++version_[v];
    if (fixed_[v] != 0 || star_[v].empty()) return;
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t f : star_[v]) least = std::min(least, cost(v, opposite(f, v).first));
    if (least <= distance_squared_) queue_.push({least, v, version_[v]});
  }

  void try_to_remove(std::uint32_t v) {
    // The best first; what is tried in vain is tried again only when something around has changed.
    constexpr std::size_t kTries = 2;
    std::vector<std::pair<double, std::uint32_t>> targets;
    for (const std::uint32_t f : star_[v]) {
      const std::uint32_t to = opposite(f, v).first;
      targets.emplace_back(cost(v, to), to);
    }
    const std::size_t tries = std::min(kTries, targets.size());
    std::partial_sort(targets.begin(), targets.begin() + static_cast<std::ptrdiff_t>(tries), targets.end());
    for (std::size_t i = 0; i < tries && targets[i].first <= distance_squared_; ++i) {
      if (keeps_topology(v, targets[i].second) && keeps_shape(v, targets[i].second) &&
          keeps_distance(v, targets[i].second) && new_faces_allowed()) {
        collapse(v, targets[i].second);
        return;
      }
    }
  }

  [[nodiscard]] bool joined(std::uint32_t a, std::uint32_t b) const {
    return std::any_of(star_[a].begin(), star_[a].end(), [&](std::uint32_t f) {
      const Corners& t = corners_[f];
      return t.x == b || t.y == b || t.z == b;
    });
  }

  // The link condition: v and `to` have the two neighbours in common that face their edge, and no more; and they are
  // not two vertices of a tetrahedron. And no new edge joins two fixed vertices.
  [[nodiscard]] bool keeps_topology(std::uint32_t v, std::uint32_t to) const {
    std::array<std::uint32_t, 2> apex{};
    std::size_t apexes = 0;
    for (const std::uint32_t f : star_[v]) {
      const auto [from, next] = opposite(f, v);
      if (from == to) apex[apexes++ % 2] = next;
      if (next == to) apex[apexes++ % 2] = from;
    }
    if (apexes != 2 || apex[0] == apex[1]) return false;
    for (const std::uint32_t f : star_[v]) {
      const std::uint32_t neighbour = opposite(f, v).first;
      if (neighbour == to || neighbour == apex[0] || neighbour == apex[1]) continue;
      if (fixed_[neighbour] != 0 && fixed_[to] != 0) return false;
      if (joined(neighbour, to)) return false;
    }
    return std::none_of(star_[to].begin(), star_[to].end(), [&](std::uint32_t f) {
      const auto [from, next] = opposite(f, to);
      return (from == apex[0] && next == apex[1]) || (from == apex[1] && next == apex[0]);
    });
  }

  // Face f with `to` in the place of v.
  [[nodiscard]] Corners moved(std::uint32_t f, std::uint32_t v, std::uint32_t to) const {
    const auto [from, next] = opposite(f, v);
    return {to, from, next};
  }

  // No triangle turns by more than some 75 degrees, or becomes all but a line. One that is all but a line has no
  // direction of its own: what comes of it is held against all faces around.
  [[nodiscard]] bool keeps_shape(std::uint32_t v, std::uint32_t to) const {
    constexpr double kLeastCosine = 0.25;
    constexpr double kThin = 1e-2;
    constexpr double kThinnest = 1e-3;
    glm::dvec3 around(0.0);
    for (const std::uint32_t f : star_[v]) around += cross_product(corners_[f]);
    for (const std::uint32_t f : star_[v]) {
      const auto [from, next] = opposite(f, v);
      if (from == to || next == to) continue;
      const Corners t = moved(f, v, to);
      if (!(thickness(t) > kThinnest)) return false;
      const glm::dvec3 before = thickness(corners_[f]) > kThin ? cross_product(corners_[f]) : around;
      const glm::dvec3 after = cross_product(t);
      if (!(glm::dot(before, after) > kLeastCosine * glm::length(before) * glm::length(after))) return false;
    }
    return true;
  }

  // Height to longest side.
  [[nodiscard]] double thickness(const Corners& t) const {
    double longest = 0;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 edge = places_[t[(corner + 1) % 3]] - places_[t[corner]];
      longest = std::max(longest, glm::dot(edge, edge));
    }
    return longest > 0 ? glm::length(cross_product(t)) / longest : 0;
  }

  // Finds, for each vertex that the faces around v represent and for v itself, which new face is nearest to it.
  bool keeps_distance(std::uint32_t v, std::uint32_t to) {
    new_faces_.clear();
    for (const std::uint32_t f : star_[v]) {
      const auto [from, next] = opposite(f, v);
      if (from != to && next != to) new_faces_.emplace_back(f, moved(f, v, to));
    }
    attached_.clear();
    const auto attach = [&](std::uint32_t mesh_vertex) {
      const glm::dvec3 p = place_of(mesh_vertex);
      double least = std::numeric_limits<double>::infinity();
      std::uint32_t nearest = 0;
      for (const auto& [f, t] : new_faces_) {
        const glm::dvec3 way = p - mesh::closest_on_triangle(p, places_[t.x], places_[t.y], places_[t.z]);
        const double squared = glm::dot(way, way);
        if (squared < least) {
          least = squared;
          nearest = f;
        }
      }
      attached_.emplace_back(nearest, mesh_vertex);
      return least <= distance_squared_;
    };
    if (!attach(vertices_[v])) return false;
    for (const std::uint32_t f : star_[v]) {
      for (const std::uint32_t mesh_vertex : faces_[f].represents) {
        if (!attach(mesh_vertex)) return false;
      }
    }
    return true;
  }

  [[nodiscard]] bool new_faces_allowed() const {
    return std::all_of(new_faces_.begin(), new_faces_.end(), [&](const auto& face) {
      const Corners& t = face.second;
      return allowed_({vertices_[t.x], vertices_[t.y], vertices_[t.z]});
    });
  }

  // After keeps_distance(v, to).
  void collapse(std::uint32_t v, std::uint32_t to) {
    for (const std::uint32_t f : star_[v]) {
      faces_[f].represents.clear();
      const auto [from, next] = opposite(f, v);
      if (from != to && next != to) continue;
      gone_[f] = 1;
      for (const std::uint32_t other : {from, next}) std::erase(star_[other], f);
    }
    for (const auto& [f, t] : new_faces_) {
      corners_[f] = t;
      star_[to].push_back(f);
    }
    for (const auto& [f, mesh_vertex] : attached_) faces_[f].represents.push_back(mesh_vertex);
    star_[v].clear();
    ++version_[v];
    quadrics_[to].add(quadrics_[v]);
    push(to);
    for (const std::uint32_t f : star_[to]) {
      const auto [from, next] = opposite(f, to);
      push(from);
      if (fixed_[to] != 0) push(next);  // its ring is open: the last vertex starts no edge
    }
  }

  std::span<const glm::vec3> mesh_positions_;
  std::vector<Face> faces_;
  double distance_squared_;
  const FaceFilter& allowed_;
  std::vector<std::uint32_t> vertices_;  // their numbers in the mesh, rising
  glm::dvec3 origin_{0.0};
  std::vector<glm::dvec3> places_;
  std::vector<Corners> corners_;                  // of the faces, in the patch's numbers
  std::vector<char> gone_;                        // faces
  std::vector<std::vector<std::uint32_t>> star_;  // the faces around each vertex
  std::vector<char> fixed_;                       // vertices that stay
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> version_;  // of what is around a vertex: candidates of older ones do not count
  std::priority_queue<Candidate> queue_;
  std::vector<std::pair<std::uint32_t, Corners>> new_faces_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> attached_;  // face, vertex of the mesh
};

}  // namespace

std::vector<Face> simplify_patch(std::span<const glm::vec3> positions, std::vector<Face> patch, double distance,
                                 const FaceFilter& allowed) {
  if (patch.empty()) return patch;
  return PatchSimplifier(positions, std::move(patch), distance, allowed).run();
}

}  // namespace isoextract::edit
