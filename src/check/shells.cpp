#include "check/shells.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <new>
#include <string>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "base/no_memory.hpp"
#include "check/detail/triangle_boxes.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/exact_sign.hpp"

namespace isoextract::check {
namespace {

constexpr double kBoundless = std::numeric_limits<double>::infinity();

// The vertex of each component with the greatest x, the first of equals.
std::vector<std::uint32_t> rightmost_vertices(const mesh::Mesh& mesh, const mesh::Components& components) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> rightmost(components.count(), kNone);
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const std::uint32_t c = components.of_vertex(v);
    if (c == mesh::Components::kNone) continue;
    if (rightmost[c] == kNone || mesh.positions[v].x > mesh.positions[rightmost[c]].x) rightmost[c] = v;
  }
  return rightmost;
}

// Twice the triangle's area, along its normal.
glm::dvec3 area_vector(const mesh::Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a(mesh.positions[t.x]);
  return glm::cross(glm::dvec3(mesh.positions[t.y]) - a, glm::dvec3(mesh.positions[t.z]) - a);
}

// In the order of vertices and triangles, so that sums do not depend on threads.
std::vector<Component> measure_components(const mesh::Mesh& mesh, const mesh::Components& components,
                                          const MeshBorders& borders) {
  std::vector<Component> result(components.count());
  const std::vector<std::uint32_t> apexes = rightmost_vertices(mesh, components);
  for (std::size_t c = 0; c < result.size(); ++c) {
    result[c].edges = borders.components[c];
    result[c].bounds = {glm::dvec3(kBoundless), glm::dvec3(-kBoundless)};
  }
  for (const BorderLoop& loop : borders.loops) ++result[loop.component].loops;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const std::uint32_t c = components.of_vertex(v);
    if (c == mesh::Components::kNone) continue;
    Component& component = result[c];
    const glm::dvec3 place = mesh.position(v);
    ++component.vertices;
    component.bounds.min = glm::min(component.bounds.min, place);
    component.bounds.max = glm::max(component.bounds.max, place);
  }
  for (const glm::uvec3& t : mesh.triangles) {
    if (mesh::repeats_index(t)) continue;
    const std::uint32_t number = components.of_vertex(t.x);
    Component& component = result[number];
    ++component.triangles;
    // Relative to a vertex of the component, where little cancels.
    const glm::dvec3 apex(mesh.positions[apexes[number]]);
    const glm::dvec3 normal = area_vector(mesh, t);
    component.area += glm::length(normal) / 2;
    component.volume += glm::dot(glm::dvec3(mesh.positions[t.x]) - apex, normal) / 6;
  }
  for (Component& component : result) {
    const EdgeDefects& edges = component.edges;
    if (edges.nonmanifold + edges.misoriented + edges.nonmanifold_vertices == 0) {
      const auto edge_count = static_cast<std::int64_t>((3 * component.triangles + edges.open) / 2);
      const std::int64_t euler =
          static_cast<std::int64_t>(component.vertices) - edge_count + static_cast<std::int64_t>(component.triangles);
      component.genus = (2 - static_cast<std::int64_t>(component.loops) - euler) / 2;
    }
    if (!edges.none()) component.volume = 0;
  }
  return result;
}

// Whether the ray from p along x passes the triangle a, b, c. Where it meets a side or a corner, that belongs to one of
// the triangles that share it: points on a line count as right of it, and z as a little more than it is.
bool is_passed(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& p) {
  const glm::dvec2 at = mesh::along_axis(p, 0);
  int winding = 0;
  const auto add_side = [&](const glm::dvec3& from, const glm::dvec3& to) {
    const bool rises = from.z <= p.z && to.z > p.z;
    const bool falls = to.z <= p.z && from.z > p.z;
    if (!rises && !falls) return;
    const glm::dvec3& low = rises ? from : to;
    const glm::dvec3& high = rises ? to : from;
    if (mesh::turn_of(mesh::along_axis(low, 0), mesh::along_axis(high, 0), at) > 0) winding += rises ? 1 : -1;
  };
  add_side(a, b);
  add_side(b, c);
  add_side(c, a);
  return winding != 0 && mesh::side_of_plane(a, b, c, p) == -winding;
}

Buffer<std::uint32_t> triangles_of(const mesh::Mesh& mesh, const mesh::Components& components,
                                   const std::vector<bool>& chosen) {
  Buffer<std::uint32_t> numbers(mesh.triangles.size());
  std::size_t count = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& triangle = mesh.triangles[t];
    if (!mesh::repeats_index(triangle) && chosen[components.of_vertex(triangle.x)]) numbers[count++] = t;
  }
  Buffer<std::uint32_t> result(count);
  std::copy_n(numbers.begin(), count, result.begin());
  return result;
}

// Of each component the largest triangle at its given vertex.
std::vector<std::uint32_t> triangles_at(const std::vector<std::uint32_t>& vertices, const mesh::Mesh& mesh,
                                        const mesh::Components& components) {
  std::vector<std::uint32_t> largest(vertices.size(), 0);
  std::vector<double> areas(vertices.size(), -1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& triangle = mesh.triangles[t];
    if (mesh::repeats_index(triangle)) continue;
    const std::uint32_t c = components.of_vertex(triangle.x);
    if (triangle.x != vertices[c] && triangle.y != vertices[c] && triangle.z != vertices[c]) continue;
    const double area = glm::length(area_vector(mesh, triangle));
    if (!(area > areas[c])) continue;
    areas[c] = area;
    largest[c] = t;
  }
  return largest;
}

// A point on the side that the triangle faces away from, nearer to it than to what does not touch it.
glm::vec3 inside_material(const mesh::Mesh& mesh, std::uint32_t triangle) {
  constexpr double kDepth = 1e-4;  // of the triangle's size
  const glm::uvec3& t = mesh.triangles[triangle];
  const glm::dvec3 a(mesh.positions[t.x]);
  const glm::dvec3 b(mesh.positions[t.y]);
  const glm::dvec3 c(mesh.positions[t.z]);
  const glm::dvec3 vector = area_vector(mesh, t);
  const double length = glm::length(vector);
  const glm::dvec3 inward = length > 0 ? vector / -std::sqrt(length) : glm::dvec3(0);
  return glm::vec3((a + b + c) / 3.0 + kDepth * inward);
}

// The boxes of components, in a tree: which of them hold a point.
class ComponentBoxes {
 public:
  ComponentBoxes(const mesh::Mesh& mesh, const mesh::Components& components, const std::vector<bool>& chosen)
      : corners_(2 * components.count()), diagonals_(components.count()), numbers_(chosen_of(chosen)) {
    constexpr float kFar = std::numeric_limits<float>::infinity();
    for (std::uint32_t c = 0; c < diagonals_.size(); ++c) {
      corners_[2 * c] = glm::vec3(kFar);
      corners_[2 * c + 1] = glm::vec3(-kFar);
      diagonals_[c] = {2 * c, 2 * c + 1, 2 * c + 1};
    }
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      const std::uint32_t c = components.of_vertex(v);
      if (c == mesh::Components::kNone) continue;
      corners_[2 * c] = glm::min(corners_[2 * c], mesh.positions[v]);
      corners_[2 * c + 1] = glm::max(corners_[2 * c + 1], mesh.positions[v]);
    }
    tree_.emplace(corners_, diagonals_, numbers_);
  }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t components) {
    return components * (2 * sizeof(glm::vec3) + sizeof(glm::uvec3) + sizeof(std::uint32_t)) +
           TriangleBoxes::bytes(components);
  }

  // The greatest x of the components but `own` whose boxes hold the point: no other is around it. Nothing if none does.
  [[nodiscard]] std::optional<float> end_of_ray(const glm::vec3& p, std::uint32_t own) const {
    std::optional<float> end;
    tree_->for_each_near({p, p}, [&](std::uint32_t c) {
      if (c != own) end = std::max(end.value_or(p.x), corners_[2 * c + 1].x);
    });
    return end;
  }

 private:
  static std::vector<std::uint32_t> chosen_of(const std::vector<bool>& chosen) {
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t c = 0; c < chosen.size(); ++c) {
      if (chosen[c]) numbers.push_back(c);
    }
    return numbers;
  }

  std::vector<glm::vec3> corners_;
  std::vector<glm::uvec3> diagonals_;
  std::vector<std::uint32_t> numbers_;
  std::optional<TriangleBoxes> tree_;
};

// In how many other components of `boxes` a point of component `own` lies. Nothing where it is on one of them.
std::optional<std::uint32_t> count_around(const glm::vec3& start, std::uint32_t own, const mesh::Mesh& mesh,
                                          const mesh::Components& components, const ComponentBoxes& around,
                                          const TriangleBoxes& boxes) {
  const auto end = around.end_of_ray(start, own);
  if (!end) return 0;
  std::vector<std::uint32_t> passed;
  bool touches = false;
  const glm::dvec3 p(start);
  const FloatBox ray{start, {*end, start.y, start.z}};
  boxes.for_each_near(ray, [&](std::uint32_t t) {
    const glm::uvec3& triangle = mesh.triangles[t];
    const std::uint32_t other = components.of_vertex(triangle.x);
    if (other == own) return;
    const glm::dvec3 a(mesh.positions[triangle.x]);
    const glm::dvec3 b(mesh.positions[triangle.y]);
    const glm::dvec3 c(mesh.positions[triangle.z]);
    if (is_passed(a, b, c, p)) passed.push_back(other);
    const bool in_box = glm::all(glm::lessThanEqual(glm::min(a, glm::min(b, c)), p)) &&
                        glm::all(glm::lessThanEqual(p, glm::max(a, glm::max(b, c))));
    touches = touches || (in_box && mesh::side_of_plane(a, b, c, p) == 0);
  });
  if (touches) return std::nullopt;
  std::ranges::sort(passed);
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < passed.size();) {
    std::size_t last = i;
    while (last < passed.size() && passed[last] == passed[i]) ++last;
    count += static_cast<std::uint32_t>((last - i) % 2);
    i = last;
  }
  return count;
}

Shell shell_of(const Component& component) {
  if (!component.edges.none()) return Shell::open;
  if (component.within % 2 == 0) return component.volume < 0 ? Shell::inside_out : Shell::body;
  return component.volume < 0 ? Shell::hollow : Shell::nested;
}

}  // namespace

Result<std::vector<std::uint32_t>> count_surrounding_shells(const mesh::Mesh& mesh, const mesh::Components& components,
                                                            const std::vector<bool>& closed,
                                                            const std::vector<bool>& asked, const Context& context) {
  const std::string what = fmt::format("{}: its shells within shells", mesh.name);
  const std::uint64_t triangles = mesh.triangles.size();
  const auto memory = TRY(context.reserve(components.count() * (3 * sizeof(std::uint32_t) + sizeof(double)) +
                                              2 * triangles * sizeof(std::uint32_t) + TriangleBoxes::bytes(triangles) +
                                              ComponentBoxes::bytes(components.count()),
                                          what));
  try {
    const std::vector<std::uint32_t> rightmost = rightmost_vertices(mesh, components);
    const Buffer<std::uint32_t> chosen = triangles_of(mesh, components, closed);
    const TriangleBoxes boxes(mesh.positions.span(), mesh.triangles.span(), chosen.span());
    const ComponentBoxes around(mesh, components, closed);
    const std::vector<std::uint32_t> beside = triangles_at(rightmost, mesh, components);
    std::vector<std::uint32_t> within(components.count(), 0);
    context.progress().begin("looking for shells within shells", components.count());
    tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(components.count()), [&](std::uint32_t c) {
      context.progress().advance(1);
      if (!asked[c] || context.cancelled()) return;
      const auto count = count_around(mesh.positions[rightmost[c]], c, mesh, components, around, boxes);
      within[c] = count
                      ? *count
                      : count_around(inside_material(mesh, beside[c]), c, mesh, components, around, boxes).value_or(0);
    });
    TRY(context.check());
    return within;
  } catch (const std::bad_alloc&) {
    return tl::unexpected(no_memory(what + " need more memory than there is"));
  }
}

Result<std::vector<Component>> describe_components(const mesh::Mesh& mesh, const mesh::Components& components,
                                                   const MeshBorders& borders, const Context& context) {
  const std::string what = fmt::format("{}: its components", mesh.name);
  const auto memory = TRY(context.reserve(components.count() * (sizeof(Component) + sizeof(std::uint32_t)), what));
  try {
    std::vector<Component> all = measure_components(mesh, components, borders);
    std::vector<bool> closed(all.size());
    for (std::size_t c = 0; c < all.size(); ++c) closed[c] = all[c].edges.none();
    if (std::ranges::count(closed, true) > 1) {
      const auto within = TRY(count_surrounding_shells(mesh, components, closed, closed, context));
      for (std::size_t c = 0; c < all.size(); ++c) all[c].within = within[c];
    }
    for (Component& component : all) component.shell = shell_of(component);
    return all;
  } catch (const std::bad_alloc&) {
    return tl::unexpected(no_memory(what + " need more memory than there is"));
  }
}

}  // namespace isoextract::check
