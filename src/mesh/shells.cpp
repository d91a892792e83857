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
  std::uint64_t open_triangle = 0;  // the first triangle of an open component, and that component
  std::uint32_t open_component = 0;
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

}  // namespace

class PartwiseShells::Rays {
 public:
  Rays(const std::string& name, const Context& context)
      : what_(name + ": its shells within shells"), context_(context) {}

  Result<void> begin(std::uint32_t components) {
    memory_ = TRY(context_.reserve(components * (sizeof(FloatBox) + sizeof(Farthest)), what_));
    boxes_.resize(components);
    farthest_.resize(components);
    return {};
  }

  Result<Step> begin_steps(ShellQuery question) {
    memory_.take(TRY(context_.reserve(ray_bytes(boxes_.size()), what_)));
    question_ = std::move(question);
    rounding_ = static_cast<float>(4 * resolution()) + 8 * std::numeric_limits<float>::denorm_min();
    Buffer<BoxTree::Item> items(boxes_.size());
    std::size_t closed = 0;
    for (std::uint32_t c = 0; c < boxes_.size(); ++c) {
      const Facing facing = question_.facing[c];
      if (facing == Facing::open) {
        open_end_ = std::max(open_end_, boxes_[c].max.z);
      } else {
        items[closed++] = {boxes_[c].center(), c};
      }
      if (facing == Facing::inward || (facing == Facing::outward && question_.test_outward)) {
        shot_.push_back({.component = c, .start = farthest_[c].position});
      }
    }
    if (closed > 0) tree_.emplace(items.span().first(closed), [&](std::uint32_t c) { return boxes_[c]; });
    found_.resize(boxes_.size());
    return begin_shooting();
  }

  Step end_step() {
    if (step_ == Step::move_starts) return begin_shooting();
    for (Ray& ray : shot_) ray.reduce();
    if (is_second_) {
      for (Ray& ray : shot_) {
        Surroundings& of = found_[ray.component];
        if (ray.is_undecided) of.around = std::move(ray.passed);
        if (of.around.empty() && std::isfinite(ray.open_along)) of.open = ray.open_component;
      }
      return step_ = Step::done;
    }
    for (Ray& ray : shot_) {
      found_[ray.component].around = std::move(ray.passed);
      ray.to_open = question_.find_open && question_.facing[ray.component] == Facing::inward;
      ray.is_undecided = ray.touches;
    }
    std::erase_if(shot_, [&](const Ray& ray) {
      return !ray.is_undecided && !(ray.to_open && found_[ray.component].around.empty());
    });
    if (shot_.empty()) return step_ = Step::done;
    is_second_ = true;
    ray_of_.assign(boxes_.size(), Components::kNone);
    for (std::uint32_t i = 0; i < shot_.size(); ++i) ray_of_[shot_[i].component] = i;
    most_.assign(shot_.size(), -std::numeric_limits<double>::infinity());
    return step_ = Step::move_starts;
  }

  void take(const LocalPart& part) {
    if (step_ == Step::shoot) shoot(part);
    if (step_ == Step::move_starts) move_starts_off_surface(part);
  }

  Result<std::vector<Surroundings>> finish() {
    TRY(context_.check());
    return std::move(found_);
  }

  // Finds the box of each component and its farthest vertex along the rays, the first of equals.
  void look_at(const LocalPart& part) {
    for (std::size_t v = 0; v < part.own_positions.size(); ++v) {
      const glm::vec3& position = part.own_positions[v];
      farthest_coordinate_ =
          std::max({farthest_coordinate_, std::abs(position.x), std::abs(position.y), std::abs(position.z)});
      const std::uint32_t c = part.own_components[v];
      if (c == Components::kNone) continue;
      const glm::dvec3 place(position);
      const glm::vec3 at = seen(place);
      boxes_[c] = boxes_[c].with({at, at});
      if (const double along = glm::dot(place, kAlong); along > farthest_[c].along) {
        farthest_[c] = {along, part.first_vertex + v, position};
      }
    }
  }

  [[nodiscard]] double resolution() const { return static_cast<double>(farthest_coordinate_) * 0x1p-23; }

 private:
  struct Farthest {
    double along = -std::numeric_limits<double>::infinity();
    std::uint64_t vertex = 0;
    glm::vec3 position{0.0F};
  };

  [[nodiscard]] static std::uint64_t ray_bytes(std::uint64_t components) {
    constexpr std::uint64_t kPassed = 16 * sizeof(std::uint32_t);
    return components * (sizeof(Surroundings) + sizeof(FloatBox) + sizeof(Ray) + kPassed + sizeof(tbb::spin_mutex) +
                         sizeof(std::uint32_t) + sizeof(double)) +
           2 * BoxTree::bytes(components);
  }

  // Starts each ray beside the middle of a triangle at the farthest vertex, on the triangle's back side. Chooses the
  // triangle that faces most along the rays, or against them for the shell of a cavity. If another wall is closer than
  // the start is to the triangle, the start may be beyond that wall: for shells so close either answer is possible.
  void move_starts_off_surface(const LocalPart& part) {
    for (const glm::uvec3& t : part.triangles) {
      if (has_repeated_index(t)) continue;
      const std::uint32_t c = part.components[t.x];
      const std::uint32_t ray = ray_of_[c];
      if (ray == Components::kNone) continue;
      const std::uint64_t start = farthest_[c].vertex;
      if (part.number(t.x) != start && part.number(t.y) != start && part.number(t.z) != start) continue;
      const Corners at = corners(part, t);
      const glm::dvec3 normal = glm::cross(at.b - at.a, at.c - at.a);
      const double length = glm::length(normal);
      const double faces = length > 0 ? glm::dot(normal, kAlong) / length : 0;
      const double score = question_.facing[c] == Facing::inward ? -faces : faces;
      if (!(score > most_[ray])) continue;
      most_[ray] = score;
      const glm::dvec3 middle = (at.a + at.b + at.c) / 3.0;
      const glm::dvec3 inward = length > 0 ? normal / -std::sqrt(length) : glm::dvec3(0);
      // Rounding may move the start to the other side.
      for (double depth = 1e-4; depth < 1; depth *= 2) {
        shot_[ray].start = glm::vec3(middle + depth * inward);
        if (orientation_3d(at.a, at.b, at.c, glm::dvec3(shot_[ray].start)) < 0) break;
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

  // Prepares to intersect the rays with all triangles. Nothing is left to do if no ray can meet any.
  Step begin_shooting() {
    ray_boxes_.assign(shot_.size(), {});
    is_met_.assign(boxes_.size(), 0);
    if (std::ranges::any_of(shot_, &Ray::to_open)) {
      for (std::size_t c = 0; c < is_met_.size(); ++c) is_met_[c] = question_.facing[c] == Facing::open ? 1 : 0;
    }
    for_each_index(shot_.size(), [&](std::size_t i) { ray_boxes_[i] = box_of(shot_[i], is_met_); });
    Buffer<BoxTree::Item> items(shot_.size());
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < shot_.size(); ++i) {
      const FloatBox& box = ray_boxes_[i];
      // Sorts by the position across the rays, because the boxes overlap along them.
      if (box.min.x <= box.max.x) items[count++] = {{box.min.x, box.min.y, 0}, i};
    }
    step_ = Step::shoot;
    if (count == 0) return end_step();
    ray_tree_.emplace(items.span().first(count), [&](std::uint32_t i) { return ray_boxes_[i]; });
    locks_ = std::vector<tbb::spin_mutex>(shot_.size());
    return step_;
  }

  // Intersects all rays with the triangles of the part.
  void shoot(const LocalPart& part) {
    for_each_range(part.triangles.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t != end && !context_.cancelled(); ++t) {
        const glm::uvec3& triangle = part.triangles[t];
        if (has_repeated_index(triangle) || is_met_[part.components[triangle.x]] == 0) continue;
        const Corners at = corners(part, triangle);
        const FloatBox box = box_around(seen(at.a), seen(at.b), seen(at.c));
        ray_tree_->for_each_near(box, [&](std::uint32_t i) {
          if (ray_boxes_[i].meets(box)) {
            meet(shot_[i], ray_boxes_[i], locks_[i], part.components[triangle.x], part.first_triangle + t, at);
          }
        });
      }
    });
  }

  struct Corners {
    glm::dvec3 a, b, c;
  };
  static Corners corners(const LocalPart& part, const glm::uvec3& t) {
    return {glm::dvec3(part.positions[t.x]), glm::dvec3(part.positions[t.y]), glm::dvec3(part.positions[t.z])};
  }

  void meet(Ray& ray, FloatBox start, tbb::spin_mutex& lock, std::uint32_t component, std::uint64_t triangle,
            const Corners& at) const {
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
      ray.open_component = component;
    }
  }

  std::string what_;
  Context context_;
  Reservation memory_;
  ShellQuery question_;
  Step step_ = Step::done;
  bool is_second_ = false;       // rays are shot for the second time
  std::vector<FloatBox> boxes_;  // of each component, in ray coordinates
  std::vector<Farthest> farthest_;
  float farthest_coordinate_ = 0;
  float rounding_ = 0;  // an upper bound for the rounding error of ray coordinates
  float open_end_ = -std::numeric_limits<float>::infinity();  // the end of all open components along the rays
  std::optional<BoxTree> tree_;                               // of closed components
  std::vector<Surroundings> found_;

  std::vector<Ray> shot_;
  std::vector<FloatBox> ray_boxes_;
  std::vector<std::uint8_t> is_met_;  // components that rays can meet
  std::optional<BoxTree> ray_tree_;
  std::vector<tbb::spin_mutex> locks_;
  // While starts move: the ray of each component, and the score of the best triangle of each ray.
  std::vector<std::uint32_t> ray_of_;
  std::vector<double> most_;
};

PartwiseShells::PartwiseShells(const std::string& name, const Context& context)
    : rays_(std::make_unique<Rays>(name, context)) {}
PartwiseShells::~PartwiseShells() = default;

Result<void> PartwiseShells::begin(std::uint32_t components) { return rays_->begin(components); }
void PartwiseShells::look_at(const LocalPart& part) { rays_->look_at(part); }
double PartwiseShells::resolution() const { return rays_->resolution(); }
Result<PartwiseShells::Step> PartwiseShells::begin_steps(ShellQuery question) {
  return rays_->begin_steps(std::move(question));
}
PartwiseShells::Step PartwiseShells::end_step() { return rays_->end_step(); }
void PartwiseShells::take(const LocalPart& part) { rays_->take(part); }
Result<std::vector<Surroundings>> PartwiseShells::finish() { return rays_->finish(); }

Result<std::vector<Surroundings>> find_enclosing_shells(const Mesh& mesh, const Components& components,
                                                        const ShellQuery& question, const Context& context) {
  PartwiseShells shells(mesh.name, context);
  TRY(shells.begin(components.count()));
  LocalPart all;
  all.near = mesh.positions.size();
  all.triangles = all.numbered = mesh.triangles.span();
  all.positions = all.own_positions = mesh.positions.span();
  all.components = all.own_components = components.of_vertices();
  context.progress().begin("looking for shells within shells", 0);
  shells.look_at(all);
  for (auto step = TRY(shells.begin_steps(question)); step != PartwiseShells::Step::done; step = shells.end_step()) {
    shells.take(all);
  }
  return shells.finish();
}

}  // namespace isoextract::mesh
