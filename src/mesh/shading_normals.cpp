#include "mesh/shading_normals.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <new>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/parallel.hpp"
#include "mesh/adjacency.hpp"

namespace isoextract::mesh {
namespace {

constexpr std::size_t kVerticesAtATime = 1 << 12;
constexpr std::uint32_t kUngrouped = std::numeric_limits<std::uint32_t>::max();

// Returns a vector perpendicular to the triangle, of twice its area in length; 0 if the area is 0 or not finite.
glm::dvec3 area_vector(std::span<const glm::vec3> positions, const glm::uvec3& t) {
  const glm::dvec3 a(positions[t.x]);
  const glm::dvec3 across = glm::cross(glm::dvec3(positions[t.y]) - a, glm::dvec3(positions[t.z]) - a);
  const double length = glm::length(across);
  return length > 0 && std::isfinite(length) ? across : glm::dvec3(0);
}

double cosine(double degrees) { return std::cos(degrees * std::numbers::pi / 180); }

glm::dvec3 unit(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 ? v / length : glm::dvec3(0);
}

// Groups the triangles around one vertex at a time, and finds a normal for each group. Reuses its memory.
class ShadedStar {
 public:
  // `flat` has one byte per triangle, or is empty.
  ShadedStar(const Mesh& mesh, const ShadingOptions& options, const Adjacency& around,
             std::span<const std::uint8_t> flat)
      : mesh_(mesh),
        options_(options),
        around_(around),
        flat_(flat),
        crease_cosine_(options.crease_degrees ? cosine(*options.crease_degrees) : -2) {}

  // Returns false if the vertex keeps its normal.
  bool look_at(std::size_t vertex) {
    const auto corners = around_.corners(vertex);
    const bool has_normal = !mesh_.normals.empty();
    const bool in_a_plane = !options_.planes.empty() && std::ranges::any_of(corners, [&](Corner corner) {
      return options_.planes[triangle_of(corner)] != 0;
    });
    if (has_normal && !options_.crease_degrees && !in_a_plane) return false;
    faces_.clear();
    for (const Corner corner : corners) {
      const glm::dvec3 area = area_vector(mesh_.positions.span(), mesh_.triangles[triangle_of(corner)]);
      const bool is_flat = !flat_.empty() && flat_[triangle_of(corner)] != 0;
      faces_.push_back({area, unit(area), plane_of(corner), is_flat});
    }
    own_stored_ = has_normal ? mesh_.normals[vertex] : glm::vec3(0);
    own_ = unit(glm::dvec3(own_stored_));
    group_of_.assign(corners.size(), 0);
    normals_.clear();
    if (!options_.may_copy) {
      normals_.push_back(stored(mean(0)));
      return true;
    }
    group_across_edges(corners);
    assign_normals();
    return true;
  }

  // One per group, all different; empty for a vertex without triangles.
  [[nodiscard]] const std::vector<glm::vec3>& normals() const { return normals_; }
  // The group of each corner of the vertex.
  [[nodiscard]] const std::vector<std::uint32_t>& group_of() const { return group_of_; }

 private:
  struct Face {
    glm::dvec3 area;    // 0 for a degenerate triangle, which agrees with any normal
    glm::dvec3 normal;  // unit length, or 0
    std::uint8_t plane;
    bool flat;  // belongs to a flat part
  };

  static glm::vec3 stored(const glm::dvec3& normal) {
    return normal == glm::dvec3(0) ? glm::vec3(0, 0, 1) : glm::vec3(normal);
  }

  [[nodiscard]] std::uint8_t plane_of(Corner corner) const {
    return options_.planes.empty() ? std::uint8_t{0} : options_.planes[triangle_of(corner)];
  }

  [[nodiscard]] bool is_crease(const Face& a, const Face& b) const {
    if (a.plane != b.plane) return true;
    return a.plane == 0 && (a.flat || b.flat) && a.area != glm::dvec3(0) && b.area != glm::dvec3(0) &&
           glm::dot(a.normal, b.normal) < crease_cosine_;
  }

  std::uint32_t root_of(std::uint32_t face) {
    while (group_of_[face] != face) face = group_of_[face] = group_of_[group_of_[face]];
    return face;
  }

  // Sets group_of_ to the first face of each group.
  void group_across_edges(std::span<const Corner> corners) {
    star_.look_at(corners, mesh_.triangles.span());
    std::iota(group_of_.begin(), group_of_.end(), 0U);
    const auto sides = star_.sides();
    for (std::size_t first = 0; first < sides.size();) {
      std::size_t last = first + 1;
      while (last < sides.size() && sides[last].end == sides[first].end) ++last;
      const std::uint32_t a = sides[first].corner;
      const std::uint32_t b = sides[last - 1].corner;
      if (last - first == 2 && !is_crease(faces_[a], faces_[b])) {
        const std::uint32_t one = root_of(a);
        const std::uint32_t other = root_of(b);
        group_of_[std::max(one, other)] = std::min(one, other);
      }
      first = last;
    }
    for (std::uint32_t face = 0; face < group_of_.size(); ++face) group_of_[face] = root_of(face);
  }

  // Returns the mean normal of the faces whose entry in group_of_ is `group`.
  [[nodiscard]] glm::dvec3 mean(std::uint32_t group) const {
    glm::dvec3 sum(0);
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (group_of_[f] == group) sum += faces_[f].area;
    }
    return unit(sum);
  }

  // Returns the smallest cosine between `normal` and the faces of a group; 1 if all are degenerate.
  [[nodiscard]] double least_cosine(std::uint32_t group, const glm::dvec3& normal) const {
    double least = 1;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (group_of_[f] == group && faces_[f].area != glm::dvec3(0)) {
        least = std::min(least, glm::dot(normal, faces_[f].normal));
      }
    }
    return least;
  }

  // Returns whether the vertex's own normal suits a group as well as the group's mean normal.
  [[nodiscard]] bool keeps_own(std::uint32_t group, bool in_plane, const glm::dvec3& mean, double least_of_mean) const {
    if (own_ == glm::dvec3(0) || !(least_cosine(group, own_) > 0)) return false;
    if (in_plane) return glm::dot(own_, mean) > 1 - 1e-6;  // the extractor's normal of a cap
    if (!options_.crease_degrees) return true;
    constexpr double kRounding = std::numbers::pi / 180;  // treats faces as flat if they differ by rounding only
    const double spread = std::acos(std::clamp(least_of_mean, -1.0, 1.0));
    return std::acos(std::clamp(glm::dot(own_, mean), -1.0, 1.0)) <= std::max(spread, kRounding);
  }

  // Numbers the groups from 0 in the order of their first faces; groups with equal normals become one.
  void assign_normals() {
    numbers_.assign(faces_.size(), kUngrouped);
    for (std::uint32_t first = 0; first < faces_.size(); ++first) {
      if (numbers_[first] != kUngrouped) continue;
      const std::uint32_t group = group_of_[first];
      const glm::dvec3 normal = mean(group);
      const double least = normal == glm::dvec3(0) ? -1 : least_cosine(group, normal);
      if (keeps_own(group, faces_[first].plane != 0, normal, least)) {
        number(group, own_stored_);
      } else if (least > 0) {
        number(group, stored(normal));
      } else {
        part(group);
      }
    }
    group_of_ = numbers_;
  }

  // Gives the unnumbered faces of the group the number of the normal.
  void number(std::uint32_t group, const glm::vec3& normal) {
    const std::uint32_t at = number_of(normal);
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (group_of_[f] == group && numbers_[f] == kUngrouped) numbers_[f] = at;
    }
  }

  std::uint32_t number_of(const glm::vec3& normal) {
    const auto found = std::ranges::find(normals_, normal);
    const auto at = static_cast<std::uint32_t>(found - normals_.begin());
    if (found == normals_.end()) normals_.push_back(normal);
    return at;
  }

  // Returns a normal that points against none of the faces `chosen`, or nothing if it finds none. Turns their mean
  // toward the worst face until all agree (the perceptron of Rosenblatt, 1958, which succeeds if there is a normal with
  // some margin).
  [[nodiscard]] std::optional<glm::dvec3> agreeing_normal(std::span<const std::uint32_t> chosen) const {
    constexpr int kMostSteps = 32;
    constexpr double kRoom = 0.25;  // required cosine
    glm::dvec3 sum(0);
    for (const std::uint32_t f : chosen) sum += faces_[f].area;
    glm::dvec3 normal = unit(sum);
    for (int step = 0; step <= kMostSteps; ++step) {
      double least = 1;
      glm::dvec3 worst(0);
      for (const std::uint32_t f : chosen) {
        const double along = glm::dot(normal, faces_[f].normal);
        if (along < least) {
          least = along;
          worst = faces_[f].normal;
        }
      }
      if (least > kRoom) return normal;
      normal = unit(normal + (kRoom - least) * worst);
    }
    return std::nullopt;
  }

  // Gives one normal to as many faces as can agree on it, the larger ones first, and repeats that with the rest.
  void part(std::uint32_t group) {
    left_.clear();
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      if (group_of_[f] == group && faces_[f].area != glm::dvec3(0)) left_.push_back(f);
    }
    std::ranges::stable_sort(left_, std::greater<>(), [&](std::uint32_t f) { return glm::length(faces_[f].area); });
    std::optional<glm::vec3> first_normal;
    while (!left_.empty()) {
      chosen_ = left_;
      auto normal = agreeing_normal(chosen_);
      if (!normal) {
        chosen_.clear();
        for (const std::uint32_t f : left_) {
          chosen_.push_back(f);
          if (const auto with = agreeing_normal(chosen_)) {
            normal = with;
          } else {
            chosen_.pop_back();
          }
        }
      }
      const std::uint32_t at = number_of(stored(*normal));
      if (!first_normal) first_normal = stored(*normal);
      for (const std::uint32_t f : chosen_) numbers_[f] = at;
      std::erase_if(left_, [&](std::uint32_t f) { return numbers_[f] != kUngrouped; });
    }
    number(group, first_normal.value_or(own_ == glm::dvec3(0) ? stored(own_) : own_stored_));
  }

  const Mesh& mesh_;
  const ShadingOptions& options_;
  const Adjacency& around_;
  std::span<const std::uint8_t> flat_;
  double crease_cosine_;
  VertexStar star_;
  std::vector<Face> faces_;
  glm::vec3 own_stored_{0.0F};  // the vertex's original normal; 0 if there is none
  glm::dvec3 own_{0.0};         // the same at unit length
  std::vector<std::uint32_t> group_of_;
  std::vector<std::uint32_t> numbers_;
  std::vector<std::uint32_t> left_;
  std::vector<std::uint32_t> chosen_;
  std::vector<glm::vec3> normals_;
};

class Shading {
 public:
  Shading(Mesh& mesh, const ShadingOptions& options, const std::string& source, const Context& context)
      : mesh_(mesh), options_(options), source_(source), context_(context), vertices_(mesh.positions.size()) {}

  Result<std::uint64_t> run() {
    const auto around_memory = TRY(reserve(Adjacency::bytes(mesh_.triangles.size(), vertices_) +
                                           (mesh_.normals.empty() ? vertices_ * sizeof(glm::vec3) : 0)));
    const Adjacency around(mesh_.triangles.span(), vertices_);
    const std::uint64_t flags = options_.crease_degrees ? mesh_.triangles.size() : 0;
    const auto flags_memory = TRY(reserve(flags));
    Buffer<std::uint8_t> flat(flags);
    if (flags > 0) find_flat_parts(around, flat.span());
    const bool had_normals = !mesh_.normals.empty();
    Buffer<glm::vec3> made(had_normals ? 0 : vertices_);
    std::vector<std::uint32_t> copies((vertices_ + kVerticesAtATime - 1) / kVerticesAtATime, 0);
    // Counts the copies of vertices that each range needs.
    for_ranges([&](std::size_t range, std::size_t first, std::size_t last) {
      ShadedStar star(mesh_, options_, around, flat.span());
      for (std::size_t v = first; v < last; ++v) {
        if (star.look_at(v) && !star.normals().empty()) {
          copies[range] += static_cast<std::uint32_t>(star.normals().size() - 1);
        }
      }
    });
    std::uint64_t all = 0;
    std::vector<std::uint64_t> offset;
    for (const std::uint32_t count : copies) {
      offset.push_back(all);
      all += count;
    }
    if (vertices_ + all > std::numeric_limits<std::uint32_t>::max()) {
      return fail(ErrorCode::input, fmt::format("{}: the surface has more vertices than 32-bit indices allow", source_),
                  {Remedy::use, Setting::parts});
    }
    const std::uint64_t row = vertex_bytes(mesh_) + (had_normals ? 0 : sizeof(glm::vec3));
    auto kept = TRY(reserve(all * row + (had_normals ? 0 : vertices_ * sizeof(glm::vec3))));
    const auto memory =
        TRY(reserve(all * (sizeof(std::uint32_t) + sizeof(glm::vec3)) +
                    (all > 0 ? mesh_.triangles.size_bytes() + vertices_ * (row + sizeof(std::uint32_t)) : 0)));
    Buffer<std::uint32_t> copied_from(all);
    Buffer<glm::vec3> normals_of_copies(all);
    Buffer<glm::uvec3> triangles(all > 0 ? mesh_.triangles.size() : 0);
    if (all > 0) std::copy(mesh_.triangles.begin(), mesh_.triangles.end(), triangles.begin());
    for_ranges([&](std::size_t range, std::size_t first, std::size_t last) {
      ShadedStar star(mesh_, options_, around, flat.span());
      std::uint64_t next = offset[range];
      for (std::size_t v = first; v < last; ++v) {
        const bool changes = star.look_at(v);
        if (star.normals().empty() || !changes) {
          if (!had_normals) made[v] = glm::vec3(0, 0, 1);
          continue;
        }
        (had_normals ? mesh_.normals[v] : made[v]) = star.normals().front();
        const auto corners = around.corners(v);
        for (std::size_t c = 0; c < corners.size(); ++c) {
          const std::uint32_t group = star.group_of()[c];
          if (group == 0) continue;
          triangles[triangle_of(corners[c])][static_cast<int>(corners[c] % 3)] =
              static_cast<std::uint32_t>(vertices_ + next + group - 1);
        }
        for (std::size_t g = 1; g < star.normals().size(); ++g, ++next) {
          copied_from[next] = static_cast<std::uint32_t>(v);
          normals_of_copies[next] = star.normals()[g];
        }
      }
    });
    if (!had_normals) mesh_.normals = std::move(made);
    if (all > 0) append(copied_from, normals_of_copies, std::move(triangles));
    mesh_.memory.take(std::move(kept));
    return all;
  }

 private:
  [[nodiscard]] Result<Reservation> reserve(std::uint64_t bytes) const {
    return context_.reserve(bytes, fmt::format("{}: normals", source_));
  }

  // Sets 1 for each triangle that is coplanar with a neighbor.
  void find_flat_parts(const Adjacency& around, std::span<std::uint8_t> flat) const {
    std::ranges::fill(flat, std::uint8_t{0});
    const double least = cosine(kFlatDegrees);
    for_ranges([&](std::size_t, std::size_t first, std::size_t last) {
      VertexStar star;
      for (std::size_t v = first; v < last; ++v) {
        const auto corners = around.corners(v);
        star.look_at(corners, std::as_const(mesh_.triangles).span());
        const auto sides = star.sides();
        for (std::size_t s = 0; s + 1 < sides.size(); ++s) {
          if (sides[s].end < v || sides[s].end != sides[s + 1].end) continue;
          const std::uint64_t a = triangle_of(corners[sides[s].corner]);
          const std::uint64_t b = triangle_of(corners[sides[s + 1].corner]);
          const glm::dvec3 normal = unit(area_vector(mesh_.positions.span(), mesh_.triangles[a]));
          if (!(glm::dot(normal, unit(area_vector(mesh_.positions.span(), mesh_.triangles[b]))) >= least)) continue;
          std::atomic_ref(flat[a]).store(1, std::memory_order_relaxed);
          std::atomic_ref(flat[b]).store(1, std::memory_order_relaxed);
        }
      }
    });
  }

  template <class Body>
  void for_ranges(const Body& body) const {
    const std::size_t ranges = (vertices_ + kVerticesAtATime - 1) / kVerticesAtATime;
    for_each_range(ranges, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t r = begin; r != end; ++r) {
        body(r, r * kVerticesAtATime, std::min<std::size_t>((r + 1) * kVerticesAtATime, vertices_));
      }
    });
  }

  void append(const Buffer<std::uint32_t>& copied_from, const Buffer<glm::vec3>& normals,
              Buffer<glm::uvec3> triangles) {
    Buffer<std::uint32_t> old_of_new(vertices_ + copied_from.size());
    std::iota(old_of_new.begin(), old_of_new.begin() + static_cast<std::ptrdiff_t>(vertices_), 0U);
    std::copy(copied_from.begin(), copied_from.end(), old_of_new.begin() + static_cast<std::ptrdiff_t>(vertices_));
    gather_vertices(mesh_, old_of_new.span());
    std::copy(normals.begin(), normals.end(), mesh_.normals.begin() + static_cast<std::ptrdiff_t>(vertices_));
    mesh_.triangles = std::move(triangles);
  }

  Mesh& mesh_;
  const ShadingOptions& options_;
  const std::string& source_;
  const Context& context_;
  std::uint64_t vertices_;
};

}  // namespace

Result<std::uint64_t> compute_shading_normals(Mesh& mesh, const ShadingOptions& options, const std::string& source,
                                              const Context& context) {
  try {
    return Shading(mesh, options, source, context).run();
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(fmt::format("{}: normals: there is not enough memory", source),
                                           {Remedy::use, Setting::parts}));
  }
}

NormalAgreement measure_normal_agreement(const Mesh& mesh) {
  return reduce_ranges(
      mesh.triangles.size(), kVerticesAtATime, NormalAgreement(),
      [&](std::size_t begin, std::size_t end, NormalAgreement sum) {
        for (std::size_t t = begin; t != end; ++t) {
          const glm::dvec3 area = area_vector(mesh.positions.span(), mesh.triangles[t]);
          if (area == glm::dvec3(0)) continue;
          sum.pairs += 3;
          for (int corner = 0; corner < 3; ++corner) {
            sum.against += glm::dot(area, glm::dvec3(mesh.normals[mesh.triangles[t][corner]])) < 0 ? 1U : 0U;
          }
        }
        return sum;
      },
      [](const NormalAgreement& a, const NormalAgreement& b) {
        return NormalAgreement{a.pairs + b.pairs, a.against + b.against};
      });
}

}  // namespace isoextract::mesh
