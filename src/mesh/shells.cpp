#include "mesh/shells.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/spin_mutex.h>

#include "base/parallel.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/exact_sign.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::mesh {
namespace {

// The direction of the rays: not parallel to any line through two nearby grid points.
const glm::dvec3 kWay(8112, 4361, 3897);
// Ray coordinates: axes of length 0.5, so that projected coordinates stay finite in float.
const glm::dvec3 kAlong = 0.5 * glm::normalize(kWay);
const glm::dvec3 kAcross = 0.5 * glm::normalize(glm::cross(kWay, glm::dvec3(0, 0, 1)));
const glm::dvec3 kUp = 2.0 * glm::cross(kAlong, kAcross);

// Returns p in ray coordinates: two across the rays, one along them. Boxes in these coordinates only save work;
// rounding does not affect the result.
glm::vec3 seen(const glm::dvec3& p) { return {glm::dot(p, kAcross), glm::dot(p, kUp), glm::dot(p, kAlong)}; }

struct Ray {
  std::uint32_t component = 0;  // where the ray starts
  glm::vec3 start{0.0F};
  bool to_open = false;       // whether to look for open components
  bool touches = false;       // the start lies on another closed component
  bool is_undecided = false;  // the first start touched another component
  // The closed component of each triangle that the ray passes; reduce() removes pairs.
  std::vector<std::uint32_t> passed{};
  std::uint32_t open_triangle = 0;  // the first triangle of an open component
  double open_along = std::numeric_limits<double>::infinity();

  void pass(std::uint32_t closed) {
    if (passed.size() == passed.capacity()) {
      reduce();
      passed.reserve(2 * passed.size() + 8);
    }
    passed.push_back(closed);
  }
  // Keeps one entry of each component that was passed an odd number of times.
  void reduce() {
    std::ranges::sort(passed);
    std::size_t left = 0;
    for (const std::uint32_t closed : passed) {
      const bool is_again = left > 0 && passed[left - 1] == closed;
      if (is_again) {
        --left;
      } else {
        passed[left++] = closed;
      }
    }
    passed.resize(left);
  }
};

class ShellRays {
 public:
  ShellRays(const Mesh& mesh, const Components& components, const ShellQuery& question, const Context& context)
      : mesh_(mesh), components_(components), question_(question), context_(context) {
    look_at_vertices();
    Buffer<BoxTree::Item> items(components.count());
    std::size_t closed = 0;
    for (std::uint32_t c = 0; c < components.count(); ++c) {
      if (question.facing[c] == Facing::open) {
        open_end_ = std::max(open_end_, boxes_[c].max.z);
      } else {
        items[closed++] = {boxes_[c].center(), c};
      }
    }
    if (closed > 0) tree_.emplace(items.span().first(closed), [&](std::uint32_t c) { return boxes_[c]; });
  }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t components) {
    constexpr std::uint64_t kPassed = 16 * sizeof(std::uint32_t);
    return components * (sizeof(Surroundings) + 2 * sizeof(FloatBox) + sizeof(Ray) + kPassed + sizeof(tbb::spin_mutex) +
                         2 * sizeof(std::uint32_t) + sizeof(double)) +
           2 * BoxTree::bytes(components);
  }

  Result<std::vector<Surroundings>> run() {
    std::vector<Ray> rays;
    rays.reserve(components_.count());
    for (std::uint32_t c = 0; c < components_.count(); ++c) {
      const Facing facing = question_.facing[c];
      if (facing == Facing::inward || (facing == Facing::outward && question_.test_outward)) {
        rays.push_back({.component = c, .start = mesh_.positions[farthest_[c]]});
      }
    }
    shoot(rays);
    std::vector<Surroundings> found(components_.count());
    for (Ray& ray : rays) {
      found[ray.component].around = std::move(ray.passed);
      ray.to_open = question_.find_open && question_.facing[ray.component] == Facing::inward;
      ray.is_undecided = ray.touches;
    }
    std::erase_if(rays, [&](const Ray& ray) {
      return !ray.is_undecided && !(ray.to_open && found[ray.component].around.empty());
    });
    if (!rays.empty()) {
      move_starts_off_surface(rays);
      shoot(rays);
    }
    for (Ray& ray : rays) {
      Surroundings& of = found[ray.component];
      if (ray.is_undecided) of.around = std::move(ray.passed);
      if (of.around.empty() && std::isfinite(ray.open_along)) {
        of.open = components_.of_vertex(mesh_.triangles[ray.open_triangle].x);
      }
    }
    TRY(context_.check());
    return found;
  }

 private:
  // Finds the box of each component and its farthest vertex along the rays, the first of equals.
  void look_at_vertices() {
    boxes_.resize(components_.count());
    farthest_.resize(components_.count(), Components::kNone);
    std::vector<double> along(components_.count(), -std::numeric_limits<double>::infinity());
    for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) {
      const std::uint32_t c = components_.of_vertex(v);
      if (c == Components::kNone) continue;
      const glm::dvec3 place(mesh_.positions[v]);
      const glm::vec3 at = seen(place);
      boxes_[c] = boxes_[c].with({at, at});
      if (const double far = glm::dot(place, kAlong); far > along[c]) {
        along[c] = far;
        farthest_[c] = v;
      }
    }
    rounding_ = static_cast<float>(4 * float32_resolution(mesh_.positions.span())) +
                8 * std::numeric_limits<float>::denorm_min();
  }

  // Starts each ray beside the middle of a triangle at the farthest vertex, on the triangle's back side. Chooses the
  // triangle that faces most along the rays, or against them for the shell of a cavity. If another wall is closer than
  // the start is to the triangle, the start may be beyond that wall: for shells so close either answer is possible.
  void move_starts_off_surface(std::vector<Ray>& rays) const {
    std::vector<std::uint32_t> ray_of(components_.count(), Components::kNone);
    for (std::uint32_t i = 0; i < rays.size(); ++i) ray_of[rays[i].component] = i;
    std::vector<double> most(rays.size(), -std::numeric_limits<double>::infinity());
    for (const glm::uvec3& t : mesh_.triangles) {
      if (has_repeated_index(t)) continue;
      const std::uint32_t c = components_.of_vertex(t.x);
      const std::uint32_t ray = ray_of[c];
      if (ray == Components::kNone || (t.x != farthest_[c] && t.y != farthest_[c] && t.z != farthest_[c])) continue;
      const Corners at = corners(t);
      const glm::dvec3 normal = glm::cross(at.b - at.a, at.c - at.a);
      const double length = glm::length(normal);
      const double faces = length > 0 ? glm::dot(normal, kAlong) / length : 0;
      const double score = question_.facing[c] == Facing::inward ? -faces : faces;
      if (!(score > most[ray])) continue;
      most[ray] = score;
      const glm::dvec3 middle = (at.a + at.b + at.c) / 3.0;
      const glm::dvec3 inward = length > 0 ? normal / -std::sqrt(length) : glm::dvec3(0);
      // Rounding may move the start to the other side.
      for (double depth = 1e-4; depth < 1; depth *= 2) {
        rays[ray].start = glm::vec3(middle + depth * inward);
        if (orientation_3d(at.a, at.b, at.c, glm::dvec3(rays[ray].start)) < 0) break;
      }
    }
  }

  // Returns the ray's box, empty if there is nothing to meet. It reaches from the start to the end of the boxes of all
  // closed components that contain the start (marked in is_met). If the ray looks for open components, it reaches to
  // their end too.
  [[nodiscard]] FloatBox box_of(const Ray& ray, std::vector<std::uint8_t>& is_met) const {
    const glm::vec3 at = seen(glm::dvec3(ray.start));
    FloatBox box{at - rounding_, at + rounding_};
    float end = ray.to_open ? open_end_ : -std::numeric_limits<float>::infinity();
    tree_->for_each_near(box, [&](std::uint32_t c) {
      if (c == ray.component || !boxes_[c].meets(box)) return;
      std::atomic_ref(is_met[c]).store(1, std::memory_order_relaxed);
      end = std::max(end, boxes_[c].max.z);
    });
    if (end < box.min.z) return {};
    box.max.z = std::max(box.max.z, end + rounding_);
    return box;
  }

  // Intersects all rays with all triangles.
  void shoot(std::vector<Ray>& rays) const {
    std::vector<FloatBox> boxes(rays.size());
    std::vector<std::uint8_t> is_met(boxes_.size(), 0);
    if (std::ranges::any_of(rays, &Ray::to_open)) {
      for (std::size_t c = 0; c < is_met.size(); ++c) is_met[c] = question_.facing[c] == Facing::open ? 1 : 0;
    }
    for_each_index(rays.size(), [&](std::size_t i) { boxes[i] = box_of(rays[i], is_met); });
    Buffer<BoxTree::Item> items(rays.size());
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
      // Sorts by the position across the rays, because the boxes overlap along them.
      if (boxes[i].min.x <= boxes[i].max.x) items[count++] = {{boxes[i].min.x, boxes[i].min.y, 0}, i};
    }
    if (count == 0) return;
    const BoxTree tree(items.span().first(count), [&](std::uint32_t i) { return boxes[i]; });
    std::vector<tbb::spin_mutex> locks(rays.size());
    context_.progress().begin("looking for shells within shells", mesh_.triangles.size());
    for_each_range(mesh_.triangles.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
      context_.progress().advance(end - begin);
      for (std::size_t t = begin; t != end && !context_.cancelled(); ++t) {
        const glm::uvec3& triangle = mesh_.triangles[t];
        if (has_repeated_index(triangle) || is_met[components_.of_vertex(triangle.x)] == 0) continue;
        const Corners at = corners(triangle);
        const FloatBox box = box_around(seen(at.a), seen(at.b), seen(at.c));
        tree.for_each_near(box, [&](std::uint32_t i) {
          if (boxes[i].meets(box)) meet(rays[i], boxes[i], locks[i], static_cast<std::uint32_t>(t), at);
        });
      }
    });
    for (Ray& ray : rays) ray.reduce();
  }

  struct Corners {
    glm::dvec3 a, b, c;
  };
  [[nodiscard]] Corners corners(const glm::uvec3& t) const {
    return {glm::dvec3(mesh_.positions[t.x]), glm::dvec3(mesh_.positions[t.y]), glm::dvec3(mesh_.positions[t.z])};
  }

  void meet(Ray& ray, FloatBox start, tbb::spin_mutex& lock, std::uint32_t triangle, const Corners& at) const {
    const std::uint32_t component = components_.of_vertex(mesh_.triangles[triangle].x);
    const bool is_open = question_.facing[component] == Facing::open;
    if (component == ray.component || (is_open && !ray.to_open)) return;
    // The ray may end within a component that does not contain its start.
    start.max.z = start.min.z + 2 * rounding_;
    if (!is_open && !boxes_[component].meets(start)) return;
    const auto& [a, b, c] = at;
    const glm::dvec3 p(ray.start);
    const int turn = side_of_line(kWay, a, b, p);
    const bool is_through = turn != 0 && turn == side_of_line(kWay, b, c, p) && turn == side_of_line(kWay, c, a, p);
    const bool in_box = glm::all(glm::lessThanEqual(glm::min(a, glm::min(b, c)), p)) &&
                        glm::all(glm::lessThanEqual(p, glm::max(a, glm::max(b, c))));
    if (!is_through && !in_box) return;
    const int side = orientation_3d(a, b, c, p);
    const bool touches = side == 0 && in_box && !is_open;
    const bool passes = is_through && side == -turn;
    if (!touches && !passes) return;
    const tbb::spin_mutex::scoped_lock hold(lock);
    ray.touches = ray.touches || touches;
    if (!passes) return;
    if (!is_open) {
      ray.pass(component);
      return;
    }
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double along = glm::dot(normal, a - p) / glm::dot(normal, kAlong);
    if (along < ray.open_along || (along == ray.open_along && triangle < ray.open_triangle)) {
      ray.open_along = along;
      ray.open_triangle = triangle;
    }
  }

  const Mesh& mesh_;
  const Components& components_;
  const ShellQuery& question_;
  const Context& context_;
  std::vector<FloatBox> boxes_;  // of each component, in ray coordinates
  std::vector<std::uint32_t> farthest_;
  float rounding_ = 0;  // an upper bound for the rounding error of ray coordinates
  float open_end_ = -std::numeric_limits<float>::infinity();  // the end of all open components along the rays
  std::optional<BoxTree> tree_;                               // of closed components
};

}  // namespace

Result<std::vector<Surroundings>> find_enclosing_shells(const Mesh& mesh, const Components& components,
                                                        const ShellQuery& question, const Context& context) {
  const auto memory = TRY(
      context.reserve(ShellRays::bytes(components.count()), fmt::format("{}: its shells within shells", mesh.name)));
  return ShellRays(mesh, components, question, context).run();
}

}  // namespace isoextract::mesh
