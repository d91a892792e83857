#include "edit/detail/simplifier.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include "base/parallel.hpp"
#include "edit/detail/intersection_guard.hpp"
#include "edit/detail/sheet_collapse.hpp"
#include "mesh/metrics.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::edit {
namespace {

constexpr double kOfVertices = 0.95;           // samples are nearer than the points between them
constexpr std::uint64_t kSweepWork = 1 << 20;  // progress units; the share of a round is a guess
constexpr char kBetweenPatches = 1;
constexpr char kOutside = 2;
constexpr std::uint64_t kPatchTriangleBytes =
    4 * 16 + sizeof(glm::uvec3) + 3 * sizeof(std::uint32_t) + 1 + IntersectionGuard::kTriangleBytes;
constexpr std::uint64_t kPatchVertexBytes = sizeof(glm::dvec3) + 14 * sizeof(double) + 5 * sizeof(std::uint32_t) + 26;

template <class Body>
void for_each_triangle(const CollapseState& state, const Body& body) {
  for_each_index(state.corners.size(), body, kTriangleGrain);
}

// Sets the entries of three vertices to 1. Several threads may do so at once.
void mark(std::vector<char>& vertices, const glm::uvec3& c) {
  for (const std::uint32_t v : {c.x, c.y, c.z}) std::atomic_ref(vertices[v]).store(1, std::memory_order_relaxed);
}

// Sorts triangles by their cells; those of a cell keep their order. Neighbors in the list are often in one cell, so it
// sorts runs of them.
std::vector<PatchTriangle> sorted_by_cell(const std::vector<PatchTriangle>& places) {
  struct Run {
    std::uint64_t cell;
    std::size_t begin, end;
  };
  const auto starts_run = [&](std::size_t i) { return i == 0 || places[i].cell != places[i - 1].cell; };
  std::size_t count = 0;
  for (std::size_t i = 0; i < places.size(); ++i) count += starts_run(i) ? 1 : 0;
  std::vector<Run> runs;
  runs.reserve(count);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (starts_run(i)) runs.push_back({places[i].cell, i, i});
    runs.back().end = i + 1;
  }
  tbb::parallel_sort(runs.begin(), runs.end(),
                     [](const Run& a, const Run& b) { return a.cell != b.cell ? a.cell < b.cell : a.begin < b.begin; });
  std::vector<PatchTriangle> sorted;
  sorted.reserve(places.size());
  for (const Run& run : runs) {
    const std::span<const PatchTriangle> of_run(&places[run.begin], run.end - run.begin);
    sorted.insert(sorted.end(), of_run.begin(), of_run.end());
  }
  return sorted;
}

}  // namespace

void add_counts(SimplifyFigures& sum, const SimplifyFigures& part) {
  sum.patches += part.patches;
  sum.collapses += part.collapses;
  sum.undone_collapses += part.undone_collapses;
  sum.refused_collapses += part.refused_collapses;
  sum.untangled_collapses += part.untangled_collapses;
  sum.rounds += part.rounds;
  sum.passes += part.passes;
  sum.windows += part.windows;
}

Simplifier::Simplifier(const mesh::Mesh& mesh, const Sheets& sheets, const SimplifyOptions& options,
                       SimplifyFigures& facts, const Context& context, const CollapseStart* start)
    : mesh_(mesh),
      options_(options),
      facts_(facts),
      context_(context),
      always_locked_(start != nullptr ? start->locked : std::span<const char>()),
      first_wanted_(start != nullptr ? start->wanted : std::span<const char>()),
      least_triangles_(start != nullptr ? start->least_triangles : 0),
      placed_(place_vertices()),
      state_(placed_.empty() ? mesh.positions.span() : std::span<const glm::vec3>(placed_), mesh.positions.span(),
             mesh.triangles.span(), sheets, start),
      locked_(mesh.positions.size(), 0),
      wanted_(mesh.positions.size(), 1),
      left_(state_.count_remaining()) {
  if (start != nullptr) slack_ = std::max(slack_, start->slack);
}

Result<bool> Simplifier::run() {
  const double enough = options_.max_distance - slack_;
  if (!(enough > 0) || left_ <= options_.triangles) return false;
  TRY(options_.triangles > 0 ? collapse_to_count(enough) : within(enough));
  // Alternates distance proof and intersection check, as undoing collapses for one can break the other. Ends because
  // each round leaves fewer collapses. Each check looks only near triangles that the other restored.
  ProvenDistances proven;
  for (;;) {
    facts_.distance_lower = 0;
    facts_.distance_upper = std::numeric_limits<double>::infinity();
    if (std::isfinite(enough)) {
      TRY(look(prove_distance(state_, logs_, proof_options(enough), proven, context_)));
    }
    UndoneIntersections undone = TRY(undo_new_intersections(proven.restored));
    if (undone.collapses == 0) break;
    proven.restored = std::move(undone.restored);
  }
  proven = {};
  if (options_.triangles > 0) {
    TRY(look(measure_distance(state_, context_)));
  }
  if (!is_changed()) return false;
  facts_.distance_upper += slack_;
  facts_.distance_lower = std::max(0.0, facts_.distance_lower - slack_);
  if (facts_.distance_upper > options_.max_distance) {  // because of rounding
    facts_.distance_lower = facts_.distance_upper = 0;
    return false;
  }
  return true;
}

bool Simplifier::is_changed() const {
  return std::ranges::any_of(state_.changed_by, [](std::uint32_t collapse) { return collapse != kNone; });
}

// `restored` lists the triangles restored since the last call or round. `is_guarded`: all rounds since the last call
// had the guard.
Result<UndoneIntersections> Simplifier::undo_new_intersections(std::span<const RestoredTriangle> restored,
                                                               bool is_guarded) {
  const SkippedPairs skipped = patches_are_checked_ ? SkippedPairs::without_restored_triangle
                               : is_guarded         ? SkippedPairs::within_a_patch
                                                    : SkippedPairs::none;
  UndoneIntersections undone = TRY(undo_intersections(state_, logs_, restored, skipped, mesh_.name, context_));
  patches_are_checked_ = true;
  state_.first_unchecked = static_cast<std::uint32_t>(numbers_);
  facts_.untangled_collapses += undone.collapses;
  if (undone.collapses > 0) {
    drop_restored_samples(state_);
    left_ = state_.count_remaining();
  }
  return undone;
}

// Adds the figures of a proof or measurement.
Result<void> Simplifier::look(const Result<Proof>& proof) {
  if (!proof) return tl::unexpected(proof.error());
  facts_.undone_collapses += proof->undone;
  facts_.passes += proof->passes;
  facts_.distance_lower = std::max(facts_.distance_lower, proof->lower);
  facts_.distance_upper = std::min(facts_.distance_upper, proof->upper);
  return {};
}

// Returns positions in the space of to_metric; empty if that is the identity. Sets slack_ to the rounding error.
std::vector<glm::vec3> Simplifier::place_vertices() {
  std::vector<glm::vec3> placed;
  if (options_.to_metric == glm::dmat3(1.0)) return placed;
  placed.resize(mesh_.positions.size());
  std::transform(mesh_.positions.begin(), mesh_.positions.end(), placed.begin(),
                 [&](const glm::vec3& p) { return glm::vec3(options_.to_metric * glm::dvec3(p)); });
  slack_ = 2 * mesh::float32_resolution(placed);  // rounding moves each surface by at most half an ulp per axis
  return placed;
}

// Sweeps with growing distances, so that all patches simplify flat regions before curved ones. A run with a larger
// limit begins with the same sweeps, so that it does not leave more triangles.
Result<void> Simplifier::within(double enough) {
  constexpr double kFirst = 1.0 / 320;  // fraction of the patch size: a tenth of a voxel
  constexpr double kSteps = 10;
  constexpr double kMuchLess = 0.5;
  std::vector<double> distances;
  for (double distance = kFirst * options_.patch_size; distance < kMuchLess * enough; distance *= kSteps) {
    distances.push_back(distance);
  }
  distances.push_back(enough);
  context_.progress().begin("simplifying", distances.size() * kSweepWork);
  for (const double distance : distances) {
    TRY(sweep(distance));
  }
  return {};
}

// Small distances make few triangles intersect. So their first rounds have no guard, which saves much time. The next
// round tries again near undone collapses; where a whole patch was undone, patches do not grow. Every other round has
// patches of the same size half a width on: threads share most of the work that earlier patches left between them.
Result<void> Simplifier::sweep(double distance) {
  constexpr double kLargerPatches = 4;
  constexpr double kMostUnguarded = 1.0 / 300;  // fraction of the patch size
  constexpr int kUnguardedRounds = 2;           // later ones visit few triangles
  want_all();
  std::uint64_t work = kSweepWork;
  int unguarded = distance > kMostUnguarded * options_.patch_size ? 0 : kUnguardedRounds;  // still to come
  double size = options_.patch_size;
  for (int done = 1;; ++done) {
    const bool is_guarded = unguarded == 0;
    const std::uint64_t share = work - work / 4;  // later rounds visit few triangles
    const double least_part =
        static_cast<double>(least_triangles_) / static_cast<double>(std::max<std::size_t>(left_, 1));
    const std::size_t patches =
        TRY(round(size, {kOfVertices * distance, distance, is_guarded, 0}, {least_part, share}));
    work -= share;
    UndoneIntersections undone;
    if (!is_guarded) {
      unguarded = patches <= 1 ? 0 : unguarded - 1;
      if (unguarded == 0) undone = TRY(undo_new_intersections({}, is_guarded));
    }
    for (const RestoredTriangle& r : undone.restored) {
      mark(wanted_, r.corners);
      mark(wanted_, state_.corners[r.triangle]);
    }
    if (patches <= 1 && undone.collapses == 0) break;
    if (undone.patches == 0 && done % 2 == 1) size *= kLargerPatches;
  }
  context_.progress().advance(work);
  return {};
}

// Runs rounds with growing distances until few patches or triangles are left; then collapses the cheapest edges of
// the whole mesh first. Where samples underestimated a distance, undoes collapses for good and does others.
Result<void> Simplifier::collapse_to_count(double enough) {
  constexpr double kFirst = 1.0 / 2000;  // fraction of the patch size
  constexpr double kSteps = 1.5;
  constexpr double kAlmost = 1.5;
  constexpr std::size_t kFew = 8;
  const auto target = static_cast<double>(options_.triangles);
  constexpr double kLeastGrowth = 1.2;  // leaves few patches soon, even if topology blocks collapses
  const double farthest = std::min(enough, extent());
  double distance = kFirst * options_.patch_size;
  double size = options_.patch_size;
  std::size_t patches = kFew + 1;
  context_.progress().begin("simplifying", left_ - options_.triangles);
  while (patches > kFew && static_cast<double>(left_) > kAlmost * target && distance < farthest) {
    const auto before = static_cast<double>(left_);
    want_all();
    patches = TRY(round(size, {distance, enough, true, 0}, {.least_part = target / before}));
    distance *= kSteps;
    // Keeps the number of triangles in a patch.
    size *= std::max(std::sqrt(before / static_cast<double>(left_)), kLeastGrowth);
  }
  TRY(undo_new_intersections({}));
  TRY(cheapest(enough));
  return replace_worst(enough);
}

double Simplifier::extent() const {
  glm::vec3 low = state_.positions.front();
  glm::vec3 high = low;
  for (const glm::vec3& p : state_.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

// Collapses edges of all remaining triangles as one patch, down to options_.triangles.
Result<void> Simplifier::cheapest(double enough) {
  want_all();
  TRY(round(std::numeric_limits<double>::infinity(), {enough, enough, true, options_.triangles}, {}));
  return {};
}

Result<void> Simplifier::replace_worst(double enough) {
  constexpr int kTimes = 3;
  constexpr double kMuchMore = 2;
  constexpr double kLeast = 1.0 / 320;  // fraction of the patch size
  refused_.assign(mesh_.positions.size(), 0);
  const double distance = std::max(kMuchMore * std::sqrt(farthest_squared_), kLeast * options_.patch_size);
  for (int time = 0; time < kTimes && left_ <= options_.triangles && distance < enough; ++time) {
    DistanceProofOptions look = proof_options(distance);
    look.once = true;
    ProvenDistances proven;
    const auto proof = TRY(prove_distance(state_, logs_, look, proven, context_));
    if (proof.undone == 0) break;
    facts_.undone_collapses += proof.undone;
    ++facts_.passes;
    drop_restored_samples(state_);
    for (const std::uint32_t vertex : proof.refused) refused_[vertex] = 1;
    left_ = state_.count_remaining();
    TRY(undo_new_intersections(proven.restored));
    context_.progress().begin("simplifying", left_ - options_.triangles);
    TRY(cheapest(enough));
  }
  refused_.clear();
  return left_ > options_.triangles ? cheapest(enough) : Result<void>();
}

DistanceProofOptions Simplifier::proof_options(double distance) const {
  constexpr double kTrianglesOfPatch = 16;
  return {.enough = distance, .original_size = options_.patch_size / kTrianglesOfPatch};
}

// Collapses edges in patches of this size. Returns the number of patches.
Result<std::size_t> Simplifier::round(double size, const CollapseLimits& limits, const Share& share) {
  TRY(context_.check());
  std::vector<PatchTriangle> places = split(size);
  if (numbers_ + places.size() >= kNone) {
    return fail(ErrorCode::input,
                fmt::format("{}: the mesh is too large to simplify: the rounds of simplification would process {} "
                            "triangles in all; the limit is {}",
                            mesh_.name, numbers_ + places.size(), kNone - 1),
                {Remedy::use, Setting::parts});
  }
  std::vector<std::size_t> first;  // start of each patch, and the end
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i == 0 || places[i].cell != places[i - 1].cell) first.push_back(i);
  }
  const std::size_t patches = first.size();
  first.push_back(places.size());
  std::vector<std::uint32_t> triangles(places.size());
  for_each_index(
      places.size(), [&](std::size_t i) { triangles[i] = places[i].triangle; }, kTriangleGrain);
  lock_patch_borders(triangles, first);
  if (numbers_ == state_.first_unchecked) {
    std::ranges::fill(state_.first_patch, kNone);
    for_each_index(patches, [&](std::size_t p) {
      for (std::size_t i = first[p]; i < first[p + 1]; ++i) {
        state_.first_patch[triangles[i]] = static_cast<std::uint32_t>(numbers_ + first[p]);
      }
    });
  }
  places = {};
  std::size_t workers = 0;
  const auto memory = TRY(reserve_patches(first, workers));

  ++facts_.rounds;
  facts_.patches += patches;
  std::vector<CollapseLog> logs(patches);
  const auto work_up_to = [&](std::size_t triangle) {
    return static_cast<std::uint64_t>(static_cast<double>(share.work) * static_cast<double>(triangle) /
                                      static_cast<double>(std::max<std::size_t>(triangles.size(), 1)));
  };
  const auto collapse = [&](std::size_t p) {
    const std::span patch(triangles.data() + first[p], first[p + 1] - first[p]);
    CollapseLimits own = limits;
    if (share.least_part > 0)
      own.triangles = static_cast<std::size_t>(std::ceil(share.least_part * static_cast<double>(patch.size())));
    logs[p] = collapse_edges(state_, patch, {locked_, wanted_}, own, static_cast<std::uint32_t>(numbers_ + first[p]));
    const std::uint64_t done =
        share.work > 0 ? work_up_to(first[p + 1]) - work_up_to(first[p]) : std::uint64_t{logs[p].removed};
    context_.progress().advance(done);
  };
  // The largest patches first, so that no thread has one left when the others have ended.
  std::vector<std::size_t> order(patches);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t p) { return first[p + 1] - first[p]; });
  std::atomic<std::size_t> next{0};
  for_each_index(workers, [&](std::size_t /*worker*/) {
    for (std::size_t i = next++; i < patches && !context_.cancelled(); i = next++) collapse(order[i]);
  });
  TRY(context_.check());
  numbers_ += triangles.size();
  patches_are_checked_ = false;
  for (CollapseLog& log : logs) {
    facts_.collapses += log.collapses.size();
    facts_.refused_collapses += log.refused;
    left_ -= log.removed;
    farthest_squared_ = std::max(farthest_squared_, log.farthest_squared);
    if (!log.collapses.empty()) logs_.push_back(std::move(log));
  }
  want_patch_borders(triangles, first);
  return patches;
}

// Wants all vertices that the caller does.
void Simplifier::want_all() {
  if (first_wanted_.empty()) {
    std::fill(wanted_.begin(), wanted_.end(), 1);
  } else {
    std::ranges::copy(first_wanted_, wanted_.begin());
  }
}

// Returns the wanted triangles and some rings around them, sorted by the grid cell of their centroids.
std::vector<PatchTriangle> Simplifier::split(double size) const {
  std::vector<char> near = wanted_;
  constexpr int kRings = 2;
  const bool all = std::all_of(near.begin(), near.end(), [](char w) { return w != 0; });
  for (int ring = 0; ring < kRings && !all; ++ring) {
    const std::vector<char> inner = near;
    for_each_triangle(state_, [&](std::size_t t) {
      const glm::uvec3& c = state_.corners[t];
      if (state_.gone[t] == 0 && (inner[c.x] | inner[c.y] | inner[c.z]) != 0) mark(near, c);
    });
  }
  std::vector<PatchTriangle> places =
      remaining_triangles(state_, [&](const glm::uvec3& c) { return (near[c.x] & near[c.y] & near[c.z]) != 0; });
  const CornerBox box = box_of_first_corners(state_, places);
  constexpr double kMostCells = 1 << 20;  // per side
  const glm::dvec3 extent = box.high - box.low;
  const double largest = std::max({extent.x, extent.y, extent.z});
  if (!(size < largest)) return places;
  const double side = std::max(size, largest / kMostCells);
  // Alternates by half a cell between rounds; above 0, so that cells of centroids outside the box are not negative.
  const double shift = facts_.rounds % 2 == 0 ? 1.0 : 1.5;
  const auto place = [&](std::size_t i) {
    const glm::uvec3& c = state_.corners[places[i].triangle];
    const glm::dvec3 center =
        (glm::dvec3(state_.positions[c.x]) + glm::dvec3(state_.positions[c.y]) + glm::dvec3(state_.positions[c.z])) /
        3.0;
    const glm::dvec3 cell = glm::floor(glm::max((center - box.low) / side + shift, 0.0));
    places[i].cell = (static_cast<std::uint64_t>(cell.z) << 42U) + (static_cast<std::uint64_t>(cell.y) << 21U) +
                     static_cast<std::uint64_t>(cell.x);
  };
  for_each_index(places.size(), place, kTriangleGrain);
  return sorted_by_cell(places);
}

// Locks vertices that several patches share, vertices with triangles outside all patches, and refused_ vertices.
void Simplifier::lock_patch_borders(const std::vector<std::uint32_t>& triangles,
                                    const std::vector<std::size_t>& first) {
  patch_of_.assign(mesh_.positions.size(), kNone);
  if (always_locked_.empty()) {
    std::fill(locked_.begin(), locked_.end(), 0);
  } else {
    std::ranges::transform(always_locked_, locked_.begin(), [](char locked) { return locked != 0 ? kOutside : 0; });
  }
  for (std::size_t v = 0; v < refused_.size(); ++v) {
    if (refused_[v] != 0) locked_[v] = kOutside;
  }
  std::vector<char> in_patch(state_.corners.size(), 0);
  for_each_index(static_cast<std::uint32_t>(first.size() - 1), [&](std::uint32_t p) {
    for (std::size_t i = first[p]; i < first[p + 1]; ++i) {
      in_patch[triangles[i]] = 1;
      const glm::uvec3& c = state_.corners[triangles[i]];
      for (const std::uint32_t v : {c.x, c.y, c.z}) {
        // Any patch may claim a vertex first; a second patch locks it.
        const std::atomic_ref of_vertex(patch_of_[v]);
        std::uint32_t patch = of_vertex.load(std::memory_order_relaxed);
        if (patch == kNone && of_vertex.compare_exchange_strong(patch, p, std::memory_order_relaxed)) continue;
        if (patch != p) std::atomic_ref(locked_[v]).store(kBetweenPatches, std::memory_order_relaxed);
      }
    }
  });
  for_each_triangle(state_, [&](std::size_t t) {
    if (in_patch[t] != 0 || state_.gone[t] != 0) return;
    const glm::uvec3& c = state_.corners[t];
    for (const std::uint32_t v : {c.x, c.y, c.z}) {
      std::atomic_ref(locked_[v]).fetch_or(kOutside, std::memory_order_relaxed);
    }
  });
}

// Marks the vertices between patches and their neighbors for the next round: locks kept their edges from collapsing.
void Simplifier::want_patch_borders(const std::vector<std::uint32_t>& triangles,
                                    const std::vector<std::size_t>& first) {
  std::fill(wanted_.begin(), wanted_.end(), 0);
  const auto want = [&](std::size_t i) {
    if (state_.gone[triangles[i]] != 0) return;
    const glm::uvec3& c = state_.corners[triangles[i]];
    if (((locked_[c.x] | locked_[c.y] | locked_[c.z]) & kBetweenPatches) != 0) mark(wanted_, c);
  };
  for_each_index(first.back(), want, kTriangleGrain);
}

std::uint64_t Simplifier::bytes(std::uint64_t vertices, std::uint64_t triangles, bool has_target) {
  constexpr std::uint64_t kLog = sizeof(Collapse) + 6 * sizeof(CollapseLog::Record);
  constexpr std::uint64_t kPlaces = 2 * sizeof(PatchTriangle) + 3 * sizeof(std::uint64_t);  // sorted_by_cell()
  constexpr std::uint64_t kVertex = CollapseState::kVertexBytes + sizeof(glm::vec3) + 2 * sizeof(std::uint32_t) + 5;
  const std::uint64_t tree = mesh::TriangleTree::bytes(triangles) + triangles * sizeof(std::uint32_t);
  const std::uint64_t proof = tree + triangles * kProofTriangleBytes;
  const std::uint64_t measurement =
      has_target ? tree + triangles * kMeasureTriangleBytes + vertices * kMeasureVertexBytes : 0;
  return tree + triangles * (CollapseState::kTriangleBytes + kLog) + vertices * kVertex +
         std::max({triangles * kPlaces, proof, measurement});
}

std::uint64_t Simplifier::bytes_at_work(std::uint64_t triangles, bool has_target) {
  constexpr std::uint64_t kPatchTriangles = 1 << 14;  // patches are seldom larger, but the last one of a target
  const std::uint64_t largest = has_target ? triangles : std::min(triangles, kPatchTriangles);
  return std::max(largest * (kPatchTriangleBytes + kPatchVertexBytes * 5 / 8), intersection_search_bytes(triangles));
}

// Reserves the memory of the largest patches, for as many threads as it allows, at least one: `workers`. `first` are
// the starts of the patches in a list, and its end.
Result<Reservation> Simplifier::reserve_patches(std::span<const std::size_t> first, std::size_t& workers) const {
  std::vector<std::size_t> sizes;
  for (std::size_t p = 0; p + 1 < first.size(); ++p) sizes.push_back(first[p + 1] - first[p]);
  std::ranges::sort(sizes, std::ranges::greater());
  // A patch has about half as many vertices as triangles, like the mesh; near holes a few more.
  const double vertices_of_triangle =
      1.25 * static_cast<double>(mesh_.positions.size()) / static_cast<double>(mesh_.triangles.size());
  for (workers = std::min(sizes.size(), static_cast<std::size_t>(usable_threads()));; --workers) {
    const auto end = sizes.begin() + static_cast<std::ptrdiff_t>(workers);
    const std::uint64_t triangles = std::accumulate(sizes.begin(), end, std::uint64_t{0});
    const auto vertices = static_cast<std::uint64_t>(vertices_of_triangle * static_cast<double>(triangles));
    const std::uint64_t bytes = triangles * kPatchTriangleBytes + vertices * kPatchVertexBytes;
    auto memory = context_.reserve(bytes, mesh_.name + ": the buffers for simplifying a patch");
    if (memory || workers <= 1) return memory;
  }
}

}  // namespace isoextract::edit
