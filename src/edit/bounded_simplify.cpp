#include "edit/bounded_simplify.hpp"

#include <algorithm>
#include <cstdint>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "base/allocation_error.hpp"
#include "base/parallel.hpp"
#include "edit/detail/collapse_state.hpp"
#include "edit/detail/patch_triangles.hpp"
#include "edit/detail/sheet_collapse.hpp"
#include "edit/detail/simplifier.hpp"
#include "edit/detail/simplify_windows.hpp"

namespace isoextract::edit {
namespace {

constexpr std::uint64_t kFarAbove = 2;  // windows keep this many times the target

// Returns the peak memory of collapse_sheets().
std::uint64_t whole_bytes(std::uint64_t vertices, std::uint64_t triangles, bool has_target) {
  return Simplifier::bytes(vertices, triangles, has_target) + triangles * (sizeof(glm::uvec3) + sizeof(MergedCorners));
}

// Returns the bytes that collapse_sheets() needs in all.
std::uint64_t needed_bytes(std::uint64_t vertices, std::uint64_t triangles, bool has_target) {
  return whole_bytes(vertices, triangles, has_target) + Simplifier::bytes_at_work(triangles, has_target);
}

// Returns the memory of the vertices that set_triangles() keeps.
std::uint64_t gathered_bytes(const mesh::Mesh& mesh) { return mesh.positions.size() * vertex_bytes(mesh); }

// Returns the memory that is left for simplifying if these vertices are kept.
std::uint64_t bytes_left(const mesh::Mesh& mesh, const Context& context) {
  const std::uint64_t left = context.memory().left();
  return left - std::min(left, gathered_bytes(mesh));
}

Result<void> simplify_whole(mesh::Mesh& mesh, const SimplifyOptions& options, SimplifyFigures& facts,
                            const Context& context) {
  const auto collapsed = TRY(collapse_sheets(mesh, Sheets(), options, facts, context));
  if (!collapsed.changed()) return {};
  std::vector<glm::uvec3> triangles;
  triangles.reserve(facts.triangles_after);
  for (std::size_t t = 0; t < collapsed.corners.size(); ++t) {
    if (collapsed.stays(t)) triangles.push_back(collapsed.corners[t]);
  }
  set_triangles(mesh, triangles);
  return {};
}

// Returns the triangles of a slab if the mesh must be simplified in windows; 0 if it fits into the memory as a whole,
// or no window would.
std::uint64_t slab_triangles(std::uint64_t vertices, std::uint64_t triangles, bool has_target, std::uint64_t left) {
  if (needed_bytes(vertices, triangles, has_target) <= left) return 0;
  return slab_triangles_for(vertices, triangles, left).value_or(0);
}

// Returns whether windows can bring a mesh near enough to its target for a simplification as a whole.
bool can_approach(std::uint64_t vertices, std::uint64_t triangles, std::uint64_t target, std::uint64_t left) {
  return kFarAbove * target < triangles &&
         needed_bytes(vertices * kFarAbove * target / triangles, kFarAbove * target, true) <= left;
}

// Simplifies a mesh with a target in windows, until the rest fits into the memory as a whole. Only the whole mesh knows
// which edges are the cheapest, so the distances are small, and all parts keep more triangles than the target needs.
// Returns an upper bound of the distance.
Result<double> approach_target(mesh::Mesh& mesh, const SimplifyOptions& options, SimplifyFigures& facts,
                               const Context& context) {
  constexpr double kFirst = 1.0 / 1600;  // fraction of the patch size: a fiftieth of a voxel
  constexpr double kSteps = 3;
  constexpr double kOfLimit = 1.0 / 8;
  double moved = 0;
  for (double distance = kFirst * options.patch_size; distance < options.patch_size; distance *= kSteps) {
    const std::uint64_t left = bytes_left(mesh, context);
    const std::uint64_t slab = slab_triangles(mesh.positions.size(), mesh.triangles.size(), true, left);
    const bool can_help = can_approach(mesh.positions.size(), mesh.triangles.size(), options.triangles, left) &&
                          moved + distance < kOfLimit * options.max_distance;
    if (slab == 0 || !can_help) break;
    SimplifyOptions step = options;
    step.max_distance = distance;
    step.triangles = kFarAbove * options.triangles;
    SimplifyFigures done;
    TRY(simplify_in_windows(mesh, step, slab, done, context));
    add_counts(facts, done);
    moved += done.distance_upper;
  }
  return moved;
}

Result<void> simplify_to_target(mesh::Mesh& mesh, const SimplifyOptions& options, SimplifyFigures& facts,
                                const Context& context) {
  const std::uint64_t before = mesh.triangles.size();
  const double moved = TRY(approach_target(mesh, options, facts, context));
  SimplifyOptions rest = options;
  rest.max_distance -= moved;
  SimplifyFigures done;
  TRY(simplify_whole(mesh, rest, done, context));
  add_counts(facts, done);
  facts.triangles_before = before;
  facts.triangles_after = done.triangles_after;
  facts.distance_lower = std::max(0.0, done.distance_lower - moved);
  facts.distance_upper = done.distance_upper + moved;
  return {};
}

Result<SimplifiedMesh> simplified(mesh::Mesh mesh, const SimplifyOptions& options, const Context& context) {
  const Stopwatch watch;
  SimplifiedMesh result;
  SimplifyFigures& facts = result.facts;
  if (options.triangles > 0) {
    TRY(simplify_to_target(mesh, options, facts, context));
  } else {
    const std::uint64_t slab =
        slab_triangles(mesh.positions.size(), mesh.triangles.size(), false, bytes_left(mesh, context));
    TRY(slab > 0 ? simplify_in_windows(mesh, options, slab, facts, context)
                 : simplify_whole(mesh, options, facts, context));
  }
  facts.time = watch.elapsed();
  mesh.memory.shrink(mesh.positions.size() * vertex_bytes(mesh) + mesh.triangles.size_bytes());
  result.mesh = std::move(mesh);
  return result;
}

}  // namespace

Result<CollapsedSheets> collapse_sheets(const mesh::Mesh& mesh, const Sheets& sheets, const SimplifyOptions& options,
                                        SimplifyFigures& facts, const Context& context) {
  facts.triangles_before = facts.triangles_after = mesh.triangles.size();
  if (mesh.triangles.empty()) return CollapsedSheets();
  const std::uint64_t bytes = whole_bytes(mesh.positions.size(), mesh.triangles.size(), options.triangles > 0);
  const auto memory = TRY(context.reserve(bytes + gathered_bytes(mesh), mesh.name + ": the buffers for simplifying"));
  Simplifier simplifier(mesh, sheets, options, facts, context);
  if (!TRY(simplifier.run())) return CollapsedSheets();
  CollapseState& state = simplifier.state();
  facts.triangles_after = state.count_remaining();
  CollapsedSheets result{std::move(state.corners), std::vector<MergedCorners>(state.gone.size())};
  const auto merge = [&](std::size_t t) {
    if (state.gone[t] == 0) return;
    const Collapse& collapse = find_collapse(state.changed_by[t], simplifier.logs());
    for (std::int8_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = result.corners[t][corner];
      if (vertex == collapse.vertex) result.merged[t].from = corner;
      if (vertex == collapse.to) result.merged[t].to = corner;
    }
  };
  for_each_index(state.gone.size(), merge, kTriangleGrain);
  return result;
}

void set_triangles(mesh::Mesh& mesh, std::span<const glm::uvec3> triangles) {
  constexpr std::uint32_t kUnused = ~0U;
  std::vector<std::uint32_t> number(mesh.positions.size(), kUnused);
  for (const glm::uvec3& t : triangles) number[t.x] = number[t.y] = number[t.z] = 0;
  std::vector<std::uint32_t> used;
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    if (number[v] == kUnused) continue;
    number[v] = static_cast<std::uint32_t>(used.size());
    used.push_back(v);
  }
  mesh.edges = {};
  Buffer<glm::uvec3> renumbered(triangles.size());
  std::transform(triangles.begin(), triangles.end(), renumbered.begin(),
                 [&](const glm::uvec3& t) { return glm::uvec3(number[t.x], number[t.y], number[t.z]); });
  gather_vertices(mesh, used);
  mesh.triangles = std::move(renumbered);
}

std::uint64_t simplified_at_once(std::uint64_t vertices, std::uint64_t triangles, std::uint64_t target,
                                 std::uint64_t left) {
  const bool has_target = target > 0;
  const std::uint64_t slab = slab_triangles(vertices, triangles, has_target, left);
  if (slab == 0 || (has_target && !can_approach(vertices, triangles, target, left))) return triangles;
  const std::uint64_t window = std::min(window_triangles(slab), triangles);
  const double fits = static_cast<double>(left) / static_cast<double>(needed_bytes(vertices, triangles, true));
  const auto whole = static_cast<std::uint64_t>(fits * static_cast<double>(triangles));
  return has_target ? std::max(window, std::min(whole, triangles)) : window;
}

Result<SimplifiedMesh> simplify_mesh(mesh::Mesh mesh, const SimplifyOptions& options, const Context& context) {
  const std::string name = mesh.name;
  try {
    return simplified(std::move(mesh), options, context);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(name + ": the buffers for simplifying need more memory than is available",
                                           {Remedy::use, Setting::parts}));
  }
}

}  // namespace isoextract::edit
