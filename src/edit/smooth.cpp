#include "edit/smooth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "base/allocation_error.hpp"
#include "base/parallel.hpp"
#include "edit/detail/smooth_signal.hpp"
#include "edit/detail/untangled_moves.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/components.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::edit {
namespace {

constexpr double kLambda = 0.5;

double taubin_mu(double pass_band) { return 1 / (pass_band - 1 / kLambda); }

Result<Buffer<glm::vec3>> taubin_moves(const Signal& signal, std::size_t vertices, const SmoothOptions& options,
                                       const Context& context) {
  Buffer<glm::vec3> moves = no_moves(vertices);
  Buffer<glm::vec3> next(vertices);
  const std::array<double, 2> steps{kLambda, taubin_mu(options.pass_band)};
  for (std::uint64_t pass = 0; pass < options.passes; ++pass) {
    for (const double step : steps) {
      for_each_vertex(vertices,
                      [&](std::size_t v) { next[v] = glm::dvec3(moves[v]) + step * signal.laplacian(moves, v); });
      std::swap(moves, next);
    }
    TRY(context.check());
    context.progress().advance(1);
  }
  return moves;
}

// Gives closed components the volume back that `moves` took: moves their vertices along the normals, by the weights.
// Leaves components with vertices that may not move freely. A component that lost nearly all its volume has no shape
// left to grow, so it does not move at all.
class VolumeRestorer {
 public:
  VolumeRestorer(const mesh::Mesh& mesh, const Signal& signal, std::span<const float> weights)
      : mesh_(mesh),
        weights_(weights),
        components_(mesh.triangles.span(), mesh.positions.size()),
        gradients_(mesh.positions.size()),
        is_free_(components_.count(), 1) {
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const std::uint32_t component = components_.of_vertex(v);
      if (component != mesh::Components::kNone && signal.constraints(v) != 0) is_free_[component] = 0;
    }
  }

  void restore(Buffer<glm::vec3>& moves) {
    const std::vector<double> wanted = measure(no_moves(moves.size()));
    reset_lost(wanted, measure(moves), moves);
    for (int step = 0; step < kSteps; ++step) {
      const std::vector<double> volumes = measure(moves);
      std::vector<double> gains(volumes.size(), 0);  // volume gained per unit of distance
      for (std::size_t v = 0; v < moves.size(); ++v) {
        const std::uint32_t component = components_.of_vertex(v);
        if (component != mesh::Components::kNone) gains[component] += weight(v) * glm::length(gradients_[v]);
      }
      for_each_vertex(moves.size(), [&](std::size_t v) {
        const std::uint32_t component = components_.of_vertex(v);
        if (component == mesh::Components::kNone || is_free_[component] == 0 || !(gains[component] > 0)) return;
        const double length = glm::length(gradients_[v]);
        if (!(length > 0)) return;
        const double distance = (wanted[component] - volumes[component]) / gains[component];
        moves[v] = glm::dvec3(moves[v]) + distance * weight(v) / length * gradients_[v];
      });
    }
  }

 private:
  static constexpr int kSteps = 4;             // the error of a step is quadratic in its length
  static constexpr double kLeastVolume = 0.2;  // fraction of the volume before smoothing

  void reset_lost(const std::vector<double>& wanted, const std::vector<double>& volumes, Buffer<glm::vec3>& moves) {
    for_each_vertex(moves.size(), [&](std::size_t v) {
      const std::uint32_t component = components_.of_vertex(v);
      if (component == mesh::Components::kNone || is_free_[component] == 0) return;
      // Both volumes have the same sign, negative for cavities.
      if (!(volumes[component] / wanted[component] >= kLeastVolume)) moves[v] = glm::vec3(0);
    });
  }

  [[nodiscard]] double weight(std::size_t v) const { return static_cast<double>(weights_[v]); }

  // Returns the volume of each component, and sets the gradients: how it grows with the position of a vertex.
  std::vector<double> measure(const Buffer<glm::vec3>& moves) {
    std::ranges::fill(gradients_, glm::dvec3(0));
    std::vector<double> volumes(components_.count(), 0);
    const auto at = [&](std::uint32_t v) { return glm::dvec3(mesh_.positions[v]) + glm::dvec3(moves[v]); };
    for (const glm::uvec3& t : mesh_.triangles) {
      if (mesh::has_repeated_index(t)) continue;
      const glm::dvec3 a = at(t.x);
      const glm::dvec3 normal = glm::cross(at(t.y) - a, at(t.z) - a);
      volumes[components_.of_vertex(t.x)] += glm::dot(a, normal) / 6;
      for (int corner = 0; corner < 3; ++corner) gradients_[t[corner]] += normal / 6.0;
    }
    return volumes;
  }

  const mesh::Mesh& mesh_;
  std::span<const float> weights_;
  mesh::Components components_;
  Buffer<glm::dvec3> gradients_;
  std::vector<std::uint8_t> is_free_;  // of each component
};

Result<Buffer<glm::vec3>> weighted_moves(const mesh::Mesh& mesh, const Signal& signal, const SmoothOptions& options,
                                         const Context& context) {
  const std::size_t vertices = mesh.positions.size();
  Buffer<glm::vec3> moves = no_moves(vertices);
  Buffer<glm::vec3> next(vertices);
  for (std::uint64_t pass = 0; pass < options.passes; ++pass) {
    for_each_vertex(vertices, [&](std::size_t v) {
      next[v] = glm::dvec3(moves[v]) + static_cast<double>(options.weights[v]) * signal.laplacian(moves, v);
    });
    std::swap(moves, next);
    TRY(context.check());
    context.progress().advance(1);
  }
  VolumeRestorer(mesh, signal, options.weights).restore(moves);
  return moves;
}

// Returns the sum of Chebyshev polynomials at cos(angle).
double chebyshev_sum(const std::vector<double>& coefficients, double angle) {
  double sum = 0;
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    sum += coefficients[i] * std::cos(static_cast<double>(i) * angle);
  }
  return sum;
}

double angle_of(double frequency) { return std::acos(1 - frequency / 2); }

// Returns the coefficients of a step at `angle`, normalized so that a constant signal does not change.
std::vector<double> step_coefficients(std::uint64_t degree, double angle) {
  std::vector<double> coefficients{angle / std::numbers::pi};
  for (std::uint64_t i = 1; i <= degree; ++i) {
    const auto n = static_cast<double>(i);
    const double window = 0.54 + 0.46 * std::cos(n * std::numbers::pi / static_cast<double>(degree + 1));
    coefficients.push_back(window * 2 * std::sin(n * angle) / (n * std::numbers::pi));
  }
  const double sum = chebyshev_sum(coefficients, 0);
  for (double& c : coefficients) c /= sum;
  return coefficients;
}

// Returns the step nearest to the pass band that passes all of it to within a thousandth.
std::vector<double> sinc_coefficients(const SmoothOptions& options) {
  const double band = angle_of(options.pass_band);
  constexpr int kSteps = 1000;
  std::vector<double> coefficients;
  for (int i = 0; i <= kSteps; ++i) {
    const double shift = (std::numbers::pi - band) * i / kSteps;
    coefficients = step_coefficients(options.passes, band + shift);
    if (chebyshev_sum(coefficients, band) >= 0.999) break;
  }
  return coefficients;
}

// Computes T_n of the positions minus the positions: T_n = 2 X T_(n-1) - T_(n-2), with X = I + L / 2.
Result<Buffer<glm::vec3>> sinc_moves(const Signal& signal, std::size_t vertices, const SmoothOptions& options,
                                     const Context& context) {
  const std::vector<double> coefficients = sinc_coefficients(options);
  Buffer<glm::vec3> before = no_moves(vertices);
  Buffer<glm::vec3> now(vertices);
  Buffer<glm::vec3> moves(vertices);
  for_each_vertex(vertices, [&](std::size_t v) {
    now[v] = 0.5 * signal.laplacian(before, v);
    moves[v] = coefficients[1] * glm::dvec3(now[v]);
  });
  for (std::size_t n = 2; n < coefficients.size(); ++n) {
    for_each_vertex(vertices, [&](std::size_t v) {
      before[v] = 2.0 * glm::dvec3(now[v]) + signal.laplacian(now, v) - glm::dvec3(before[v]);
      moves[v] = glm::dvec3(moves[v]) + coefficients[n] * glm::dvec3(before[v]);
    });
    std::swap(before, now);
    TRY(context.check());
    context.progress().advance(1);
  }
  return moves;
}

Result<Buffer<glm::vec3>> moves_of(const mesh::Mesh& mesh, const Signal& signal, const SmoothOptions& options,
                                   const Context& context) {
  switch (options.method) {
    case SmoothMethod::taubin: return taubin_moves(signal, mesh.positions.size(), options, context);
    case SmoothMethod::sinc: return sinc_moves(signal, mesh.positions.size(), options, context);
    case SmoothMethod::weighted: break;
  }
  return weighted_moves(mesh, signal, options, context);
}

void renew_normals(mesh::Mesh& mesh) {
  const mesh::Adjacency adjacency(mesh.triangles.span(), mesh.positions.size());
  for_each_vertex(mesh.positions.size(), [&](std::size_t v) {
    glm::dvec3 sum(0);
    for (const mesh::Corner corner : adjacency.corners(v)) {
      const glm::uvec3& t = mesh.triangles[mesh::triangle_of(corner)];
      const auto c = static_cast<int>(corner % 3);
      const glm::dvec3 here(mesh.positions[t[c]]);
      const glm::dvec3 a = glm::dvec3(mesh.positions[t[(c + 1) % 3]]) - here;
      const glm::dvec3 b = glm::dvec3(mesh.positions[t[(c + 2) % 3]]) - here;
      const glm::dvec3 normal = glm::cross(a, b);
      const double length = glm::length(normal);
      if (length > 0) sum += normal / length * std::atan2(length, glm::dot(a, b));
    }
    // A vertex without a normal keeps its old one.
    if (const double length = glm::length(sum); length > 0) mesh.normals[v] = sum / length;
  });
}

// Averages each normal with its neighbors' normals. Vertices of boundaries, caps and cuts keep their normals.
void average_normals(mesh::Mesh& mesh, const Signal& signal, std::span<const float> weights) {
  Buffer<glm::vec3> next(mesh.normals.size());
  for (int pass = 0; pass < kNormalPasses; ++pass) {
    for_each_vertex(mesh.normals.size(), [&](std::size_t v) {
      next[v] = mesh.normals[v];
      const auto near = signal.neighbors(v);
      if (signal.constraints(v) != 0 || near.empty()) return;
      glm::dvec3 mean(0);
      for (const std::uint32_t n : near) mean += glm::dvec3(mesh.normals[n]);
      mean = glm::mix(glm::dvec3(mesh.normals[v]), mean / static_cast<double>(near.size()),
                      static_cast<double>(weights[v]));
      if (const double length = glm::length(mean); length > 0) next[v] = mean / length;
    });
    std::swap(mesh.normals, next);
  }
}

Result<SmoothFigures> smooth_mesh(mesh::Mesh& mesh, const SmoothOptions& options, const Context& context) {
  const Stopwatch watch;
  SmoothFigures facts;
  const std::size_t vertices = mesh.positions.size();
  facts.vertices = vertices;
  const mesh::MeshSize before = measure_size(mesh);
  facts.volume_before = before.volume;
  facts.zero_area_before = before.zero_area_triangles;
  if (options.method == SmoothMethod::weighted && vertices > 0) {
    facts.mean_weight =
        std::accumulate(options.weights.begin(), options.weights.end(), 0.0) / static_cast<double>(vertices);
  }
  {
    const Signal signal(mesh, options);
    context.progress().begin("smoothing", options.passes);
    const Buffer<glm::vec3> moves = TRY(moves_of(mesh, signal, options, context));
    const UntangledMoves moved = TRY(move_untangled(mesh, moves, context));
    facts.held_vertices = moved.held_vertices;
    const glm::dvec2 most = reduce_ranges(
        vertices, kVerticesAtATime, glm::dvec2(0),
        [&](std::size_t begin, std::size_t end, glm::dvec2 so_far) {
          for (std::size_t v = begin; v != end; ++v) {
            const glm::dvec3 move = glm::dvec3(mesh.positions[v]) - glm::dvec3(moved.before[v]);
            so_far = glm::max(so_far, {glm::length(options.to_metric * move), glm::length(move)});
          }
          return so_far;
        },
        [](const glm::dvec2& x, const glm::dvec2& y) { return glm::max(x, y); });
    facts.greatest_move = most.x;
    facts.greatest_move_world = most.y;
    for (std::size_t v = 0; v < vertices; ++v) {
      facts.boundary_vertices += signal.constraints(v) == kFixed ? 1 : 0;
      facts.wall_vertices += signal.constraints(v) != kFixed && signal.constraints(v) != 0 ? 1 : 0;
    }
    if (!mesh.normals.empty() && options.method == SmoothMethod::weighted) {
      renew_normals(mesh);
      average_normals(mesh, signal, options.weights);
    }
  }
  mesh.edges = {};
  if (!mesh.normals.empty() && options.method != SmoothMethod::weighted) renew_normals(mesh);
  const mesh::MeshSize after = measure_size(mesh);
  facts.volume_after = after.volume;
  facts.zero_area_after = after.zero_area_triangles;
  facts.time = watch.elapsed();
  return facts;
}

}  // namespace

double smoothing_gain(const SmoothOptions& options, double frequency) {
  if (options.method == SmoothMethod::sinc) return chebyshev_sum(sinc_coefficients(options), angle_of(frequency));
  if (options.method == SmoothMethod::weighted) return std::pow(1 - frequency, static_cast<double>(options.passes));
  const double pass = (1 - kLambda * frequency) * (1 - taubin_mu(options.pass_band) * frequency);
  return std::pow(pass, static_cast<double>(options.passes));
}

Result<SmoothFigures> smooth(mesh::Mesh& mesh, const SmoothOptions& options, const Context& context) {
  const std::uint64_t vertices = mesh.positions.size();
  const std::uint64_t triangles = mesh.triangles.size();
  const std::string what = mesh.name + ": smoothing the surface";
  const std::uint64_t filtering =
      2 * Neighbors::bytes(3 * triangles, vertices) + vertices * (4 * sizeof(glm::vec3) + 1);
  const std::uint64_t shading = mesh.normals.empty() ? 0 : mesh::Adjacency::bytes(triangles, vertices);
  std::uint64_t together = std::max(filtering, shading);
  if (options.method == SmoothMethod::weighted) {
    // Memory for the volumes, and for averaging normals while the neighbors still exist.
    const std::uint64_t restoring = mesh::Components::bytes(vertices) + vertices * sizeof(glm::dvec3);
    const std::uint64_t averaging = shading > 0 ? shading + vertices * sizeof(glm::vec3) : 0;
    together = filtering + std::max(restoring, averaging);
  }
  const auto memory = TRY(context.reserve(together, what));
  try {
    return smooth_mesh(mesh, options, context);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(
        allocation_error(what + " needs more memory than is available", {Remedy::use, Setting::parts}));
  }
}

}  // namespace isoextract::edit
