#include "edit/detail/simplify_windows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/parallel.hpp"
#include "edit/detail/sheet_collapse.hpp"
#include "edit/detail/simplifier.hpp"
#include "edit/detail/window_mesh.hpp"
#include "mesh/distance_bound.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::edit {
namespace {

constexpr std::size_t kChunk = 1 << 12;  // triangles that share an interval

class WindowedSimplifier {
 public:
  WindowedSimplifier(mesh::Mesh& mesh, const SimplifyOptions& options, SimplifyFigures& facts, const Context& context)
      : mesh_(mesh), options_(options), facts_(facts), context_(context), state_(mesh.triangles.size(), kUnchanged) {
    choose_axis();
    if (options.to_metric != glm::dmat3(1.0)) slack_ = largest_slack();
  }

  // Returns whether any triangle changed.
  Result<bool> run(std::uint64_t slab_triangles) {
    std::vector<double> planes = planes_of(slab_triangles);
    planes.insert(planes.begin(), -kEverywhere);
    planes.push_back(kEverywhere);
    context_.progress().begin("simplifying", planes.size() - 1);
    for (std::size_t i = 0; i + 1 < planes.size();) {
      Interval window{planes[i], planes[i + 1]};
      const double two_below = planes[i < 2 ? 0 : i - 2];
      if (i > 0) window.low = std::max(two_below, lowest_locked_at(planes[i]) - kMargin * options_.patch_size);
      forget_originals_below(two_below - reach());
      const auto done = simplify(window, {planes[i < 1 ? 0 : i - 1], planes[i]});
      if (!done) {
        // Less of the mesh may fit. Nothing of the window has changed.
        const std::optional<double> between = middle_of(planes[i], planes[i + 1]);
        if (done.error().code != ErrorCode::out_of_memory || !between) return tl::unexpected(done.error());
        planes.insert(planes.begin() + static_cast<std::ptrdiff_t>(i) + 1, *between);
        continue;
      }
      context_.progress().advance(1);
      ++facts_.windows;
      ++i;
    }
    set_distance_lower();
    return std::ranges::any_of(state_, [](std::uint8_t state) { return state != kUnchanged; });
  }

  [[nodiscard]] std::uint64_t count_remaining() const {
    return static_cast<std::uint64_t>(std::ranges::count_if(state_, [](auto state) { return state != kRemoved; }));
  }

  // Keeps the remaining triangles in their order.
  void drop_removed_triangles() {
    std::size_t count = 0;
    for (std::size_t t = 0; t < state_.size(); ++t) {
      if (state_[t] != kRemoved) mesh_.triangles[count++] = mesh_.triangles[t];
    }
    state_ = {};
    saved_ = {};
    set_triangles(mesh_, mesh_.triangles.span().first(count));
  }

 private:
  enum State : std::uint8_t { kUnchanged, kChanged, kRemoved };
  struct Original {
    std::uint32_t triangle;
    glm::uvec3 corners;
  };
  // A lower bound of the distance, which holds while the triangle has these corners.
  struct FarTriangle {
    double lower;
    std::uint32_t triangle;
    glm::uvec3 corners;
  };

  // Distances within a window reach this far: less than options_.max_distance by the rounding error.
  [[nodiscard]] double reach() const { return 1.001 * options_.max_distance; }

  // Returns a bound for the rounding error of any window.
  [[nodiscard]] double largest_slack() const {
    float largest = 0;
    for (const glm::vec3& p : mesh_.positions) {
      const glm::vec3 placed(glm::abs(options_.to_metric * glm::dvec3(p)));
      largest = std::max({largest, placed.x, placed.y, placed.z});
    }
    const std::array<glm::vec3, 1> farthest{glm::vec3(largest)};
    return 2 * mesh::float32_resolution(farthest);
  }

  [[nodiscard]] double along(std::uint32_t v) const { return glm::dot(axis_, glm::dvec3(mesh_.positions[v])); }

  [[nodiscard]] Interval interval_of(const glm::uvec3& t) const {
    const double a = along(t.x);
    const double b = along(t.y);
    const double c = along(t.z);
    return {std::min({a, b, c}), std::max({a, b, c})};
  }

  // Chooses the axis of the space of distances along which the chunks of triangles are shortest, among those at least
  // half as long as the longest: windows then visit few chunks.
  void choose_axis() {
    constexpr double kOfLongest = 0.5;
    struct Axis {
      glm::dvec3 direction{0.0};
      std::vector<Interval> chunks;
      double length = 0;
      double of_chunks = 0;  // mean length of a chunk, relative to the axis
    };
    const glm::dmat3 rows = glm::transpose(options_.to_metric);
    std::array<Axis, 3> axes;
    for (int i = 0; i < 3; ++i) {
      Axis& axis = axes[static_cast<std::size_t>(i)];
      axis.direction = axis_ = rows[i];
      axis.chunks.resize((state_.size() + kChunk - 1) / kChunk);
      for_each_index(axis.chunks.size(), [&](std::size_t chunk) {
        for_each_of_chunk(chunk, [&](std::uint32_t t) { axis.chunks[chunk].add(interval_of(mesh_.triangles[t])); });
      });
      Interval all;
      for (const Interval& chunk : axis.chunks) {
        all.add(chunk);
        axis.of_chunks += chunk.high - chunk.low;
      }
      axis.length = all.high - all.low;
      axis.of_chunks /= axis.length > 0 ? axis.length : 1;
    }
    const double longest = std::ranges::max(axes, {}, &Axis::length).length;
    Axis* best = nullptr;
    for (Axis& axis : axes) {
      if (axis.length >= kOfLongest * longest && (best == nullptr || axis.of_chunks < best->of_chunks)) best = &axis;
    }
    axis_ = best->direction;
    chunks_ = std::move(best->chunks);
  }

  template <class Body>
  void for_each_of_chunk(std::size_t chunk, const Body& body) const {
    const std::size_t end = std::min((chunk + 1) * kChunk, state_.size());
    for (std::size_t t = chunk * kChunk; t < end; ++t) body(static_cast<std::uint32_t>(t));
  }

  // Returns planes, in ascending order, with about this number of triangles between two of them: quantiles of a sample.
  [[nodiscard]] std::vector<double> planes_of(std::uint64_t slab_triangles) const {
    constexpr std::size_t kMostSamples = 1 << 20;
    const std::size_t step = (state_.size() + kMostSamples - 1) / kMostSamples;
    std::vector<double> sample;
    for (std::size_t t = 0; t < state_.size(); t += step) sample.push_back(along(mesh_.triangles[t].x));
    std::ranges::sort(sample);
    const std::uint64_t slabs = (state_.size() + slab_triangles - 1) / slab_triangles;
    std::vector<double> planes;
    for (std::uint64_t slab = 1; slab < slabs; ++slab) {
      const double plane = sample[sample.size() * slab / slabs];
      if (plane > (planes.empty() ? sample.front() : planes.back())) planes.push_back(plane);
    }
    return planes;
  }

  // Returns a plane that divides the triangles between two planes; null if that would not help.
  [[nodiscard]] std::optional<double> middle_of(double low, double high) const {
    std::vector<double> inner;
    for (const std::uint32_t t : listed({low, high}, [&](std::uint32_t t) { return state_[t] == kUnchanged; })) {
      const double coordinate = along(mesh_.triangles[t].x);
      if (coordinate > low && coordinate < high) inner.push_back(coordinate);
    }
    if (inner.size() < kFewest) return std::nullopt;
    const auto middle = inner.begin() + static_cast<std::ptrdiff_t>(inner.size() / 2);
    std::ranges::nth_element(inner, middle);
    if (*middle == *std::ranges::min_element(inner)) return std::nullopt;
    return *middle;
  }

  // Returns the lowest coordinate of the triangles that meet an interval.
  [[nodiscard]] double lowest_at(const Interval& interval) const {
    double lowest = interval.low;
    for (const std::uint32_t t : listed(interval, [&](std::uint32_t t) { return state_[t] != kRemoved; })) {
      const Interval of_triangle = interval_of(mesh_.triangles[t]);
      if (of_triangle.meets(interval)) lowest = std::min(lowest, of_triangle.low);
    }
    return lowest;
  }

  // Returns the lowest coordinate of the triangles whose vertices a window below the plane had to lock: those that meet
  // the plane, and their neighbors.
  [[nodiscard]] double lowest_locked_at(double plane) const { return lowest_at({lowest_at({plane, plane}), plane}); }

  // The originals of triangles that later windows cannot reach.
  void forget_originals_below(double coordinate) {
    std::erase_if(saved_, [&](const Original& saved) { return interval_of(saved.corners).high < coordinate; });
  }

  // Returns the triangles, in ascending order, that are in chunks which meet the interval and satisfy `holds`.
  template <class Holds>
  [[nodiscard]] std::vector<std::uint32_t> listed(const Interval& interval, const Holds& holds) const {
    std::vector<std::vector<std::uint32_t>> found(chunks_.size());
    for_each_index(
        chunks_.size(),
        [&](std::size_t chunk) {
          if (!chunks_[chunk].meets(interval)) return;
          for_each_of_chunk(chunk, [&](std::uint32_t t) {
            if (holds(t)) found[chunk].push_back(t);
          });
        },
        1 << 4);
    std::vector<std::uint32_t> list;
    for (const auto& part : found) list.insert(list.end(), part.begin(), part.end());
    return list;
  }

  // Lists the original triangles within reach of an interval.
  [[nodiscard]] std::vector<std::uint32_t> originals_near(const Interval& interval) const {
    const std::vector<std::uint32_t> unchanged = listed(interval, [&](std::uint32_t t) {
      return state_[t] == kUnchanged && interval_of(mesh_.triangles[t]).meets(interval);
    });
    std::vector<std::uint32_t> changed;
    for (const Original& saved : saved_) {
      if (interval_of(saved.corners).meets(interval)) changed.push_back(saved.triangle);
    }
    std::vector<std::uint32_t> all;
    all.reserve(unchanged.size() + changed.size());
    std::ranges::merge(unchanged, changed, std::back_inserter(all));
    return all;
  }

  [[nodiscard]] const Original* find_saved(std::uint32_t t) const {
    const auto at = std::ranges::lower_bound(saved_, t, {}, &Original::triangle);
    return at != saved_.end() && at->triangle == t ? &*at : nullptr;
  }

  [[nodiscard]] glm::uvec3 original_corners(std::uint32_t t) const {
    const Original* saved = state_[t] == kUnchanged ? nullptr : find_saved(t);
    return saved != nullptr ? saved->corners : mesh_.triangles[t];
  }

  // Collapses edges within `interval`. Triangles that reach above `old.high` are new; new triangles that do so reach
  // down to `old.low` at most. Without memory for the whole interval, leaves out the part below `old.low`.
  Result<void> simplify(Interval interval, const Interval& old) {
    TRY(context_.check());
    std::optional<Window> window = find(interval);
    if (!window) return {};
    const auto reserve = [&] {
      return context_.reserve(bytes_of(window->vertices.size(), window->triangles.size()),
                              mesh_.name + ": the buffers for simplifying a part of the mesh");
    };
    auto memory = reserve();
    if (!memory && interval.low < old.low) {
      interval.low = old.low;
      window = find(interval);
      if (!window) return {};
      memory = reserve();
    }
    if (!memory) return tl::unexpected(std::move(memory.error()));
    fill(*window);
    lock(*window, interval, old);
    CollapseStart start{window->corners,
                        window->gone,
                        window->not_original,
                        window->locked,
                        window->wanted,
                        window->sides,
                        least_triangles(*window, interval, old),
                        slack_};
    SimplifyOptions options = options_;
    options.triangles = 0;
    SimplifyFigures facts;
    const Context own = context_.beside();  // the progress is that of all windows
    Simplifier simplifier(window->original, Sheets(), options, facts, own, &start);
    const bool is_changed = TRY(simplifier.run());
    add(facts);
    if (is_changed) take_over(*window, simplifier.state());
    return {};
  }

  // Returns how many triangles a window keeps at least: all old ones, those that cross its end, and the share of its
  // new triangles in the target. So the target is a lower bound for the whole mesh.
  [[nodiscard]] std::size_t least_triangles(const Window& window, const Interval& interval, const Interval& old) const {
    if (options_.triangles == 0) return 0;
    std::size_t added = 0;
    for (const std::uint32_t t : window.present) {
      const Interval of_triangle = interval_of(mesh_.triangles[t]);
      added += of_triangle.high > old.high && interval.contains(of_triangle) ? 1 : 0;
    }
    const double share = static_cast<double>(options_.triangles) / static_cast<double>(state_.size());
    const auto kept = static_cast<std::size_t>(std::ceil(share * static_cast<double>(added)));
    return window.present.size() - added + kept;
  }

  // Lists the triangles and vertices of a window; null if there are none.
  [[nodiscard]] std::optional<Window> find(const Interval& interval) const {
    Window window;
    window.originals = originals_near(interval.widened(reach()));
    if (window.originals.empty()) return std::nullopt;
    Interval present_in = interval;
    for (const std::uint32_t t : window.originals) present_in.add(interval_of(original_corners(t)));
    present_in = present_in.widened(reach());
    window.present = listed(present_in, [&](std::uint32_t t) {
      return state_[t] != kRemoved && interval_of(mesh_.triangles[t]).meets(present_in);
    });
    std::ranges::set_union(window.originals, window.present, std::back_inserter(window.triangles));
    window.numbers.emplace(mesh_.positions.size());
    for (const std::uint32_t t : window.originals) window.numbers->add(original_corners(t));
    for (const std::uint32_t t : window.present) window.numbers->add(mesh_.triangles[t]);
    window.vertices = window.numbers->list();
    return window;
  }

  // Sets the mesh of a window.
  void fill(Window& window) const {
    const VertexNumbers& numbers = *window.numbers;
    const std::size_t count = window.triangles.size();
    window.original.name = mesh_.name;
    window.original.positions = Buffer<glm::vec3>(window.vertices.size());
    for_each_index(
        window.vertices.size(),
        [&](std::size_t v) { window.original.positions[v] = mesh_.positions[window.vertices[v]]; }, kChunk);
    window.original.triangles = Buffer<glm::uvec3>(count);
    window.corners.resize(count);
    window.gone.resize(count);
    window.not_original.resize(count);
    for_each_index(
        count,
        [&](std::size_t i) {
          const std::uint32_t t = window.triangles[i];
          const bool is_original = std::ranges::binary_search(window.originals, t);
          const bool is_present = std::ranges::binary_search(window.present, t);
          const glm::uvec3 corners = numbers.of(is_present ? mesh_.triangles[t] : original_corners(t));
          window.corners[i] = corners;
          window.original.triangles[i] = is_original ? numbers.of(original_corners(t)) : corners;
          window.gone[i] = is_present ? 0 : 1;
          window.not_original[i] = is_original ? 0 : 1;
        },
        kChunk);
  }

  // Locks the vertices of triangles that leave the interval, and wants those of triangles that reach above `old`.
  void lock(Window& window, const Interval& interval, const Interval& old) const {
    window.locked.assign(window.vertices.size(), 0);
    window.wanted.assign(window.vertices.size(), 0);
    window.sides.resize(window.vertices.size());
    for (std::size_t v = 0; v < window.vertices.size(); ++v) {
      const double coordinate = along(window.vertices[v]);
      window.sides[v] = coordinate < old.low ? -1 : coordinate > old.high ? 1 : 0;
    }
    for (std::size_t i = 0; i < window.triangles.size(); ++i) {
      if (window.gone[i] != 0) continue;
      const Interval of_triangle = interval_of(mesh_.triangles[window.triangles[i]]);
      const bool leaves = !interval.contains(of_triangle);
      const bool is_new = of_triangle.high > old.high;
      const glm::uvec3& c = window.corners[i];
      for (const std::uint32_t v : {c.x, c.y, c.z}) {
        if (leaves) window.locked[v] = 1;
        if (is_new) window.wanted[v] = 1;
      }
    }
  }

  void add(const SimplifyFigures& facts) {
    facts_.distance_upper = std::max(facts_.distance_upper, facts.distance_upper);
    add_counts(facts_, facts);
  }

  void take_over(const Window& window, const CollapseState& state) {
    const std::size_t known = saved_.size();
    struct Changed {
      double upper;  // of the distance
      std::uint32_t number;
    };
    std::vector<Changed> far;
    for (std::uint32_t i = 0; i < window.triangles.size(); ++i) {
      if (state.changed_by[i] == kNone) continue;
      const std::uint32_t t = window.triangles[i];
      glm::uvec3& corners = mesh_.triangles[t];
      if (state_[t] == kUnchanged) saved_.push_back({t, corners});
      if (state.gone[i] != 0) {
        state_[t] = kRemoved;
        continue;
      }
      const glm::uvec3& c = state.corners[i];
      corners = {window.vertices[c.x], window.vertices[c.y], window.vertices[c.z]};
      state_[t] = kChanged;
      chunks_[t / kChunk].add(interval_of(corners));
      far.push_back({state.known[i].upper, i});
    }
    std::inplace_merge(saved_.begin(), saved_.begin() + static_cast<std::ptrdiff_t>(known), saved_.end(),
                       [](const Original& a, const Original& b) { return a.triangle < b.triangle; });
    const std::size_t most = std::min<std::size_t>(far.size(), kFarTriangles);
    std::ranges::partial_sort(far, far.begin() + static_cast<std::ptrdiff_t>(most), std::ranges::greater(),
                              &Changed::upper);
    const std::size_t before = far_.size();
    far_.resize(before + most);
    for_each_index(most, [&](std::size_t i) {
      const std::uint32_t t = window.triangles[far[i].number];
      far_[before + i] = {measure_lower(state, far[i].number) - slack_, t, mesh_.triangles[t]};
    });
  }

  // Returns a lower bound of the distance from a triangle to the original mesh. The proof of the upper bound often
  // finds none.
  [[nodiscard]] static double measure_lower(const CollapseState& state, std::uint32_t t) {
    const glm::uvec3& c = state.corners[t];
    const mesh::DistanceLimits limits{.tolerance = 0.05, .max_parts = 256};
    const mesh::TriangleBound found =
        mesh::bound_distance({state.positions[c.x], state.positions[c.y], state.positions[c.z]}, state.original_tree(t),
                             limits, 0, state.original_slot[t]);
    return std::max(found.lower, state.known[t].lower);
  }

  void set_distance_lower() {
    for (const FarTriangle& far : far_) {
      if (state_[far.triangle] != kRemoved && mesh_.triangles[far.triangle] == far.corners) {
        facts_.distance_lower = std::max(facts_.distance_lower, far.lower);
      }
    }
    facts_.distance_lower = std::min(facts_.distance_lower, facts_.distance_upper);  // both are rounded
  }

 public:
  [[nodiscard]] static std::uint64_t bytes_of(std::uint64_t vertices, std::uint64_t triangles) {
    return Simplifier::bytes(vertices, triangles, false) + triangles * Window::kTriangleBytes +
           vertices * Window::kVertexBytes;
  }
  // Bytes for the whole mesh, and for the saved originals of windows of this size.
  [[nodiscard]] static std::uint64_t lasting_bytes(std::uint64_t vertices, std::uint64_t triangles,
                                                   std::uint64_t of_window) {
    return triangles + 2 * VertexNumbers::bytes(vertices) + 2 * of_window * sizeof(Original);
  }

 private:
  static constexpr std::size_t kFewest = 1 << 10;   // new triangles of a window
  static constexpr double kMargin = 0.25;           // of the patch size: how far below a plane triangles change
  static constexpr std::size_t kFarTriangles = 64;  // of a window: later windows change few of the farthest

  mesh::Mesh& mesh_;
  const SimplifyOptions& options_;
  SimplifyFigures& facts_;
  const Context& context_;
  glm::dvec3 axis_{0.0};
  double slack_ = 0;                 // rounding error of distances
  std::vector<std::uint8_t> state_;  // of each triangle
  std::vector<Interval> chunks_;     // encloses the original and the present triangles of each chunk
  std::vector<Original> saved_;      // of changed and removed triangles near the next window; ascending
  std::vector<FarTriangle> far_;
};

}  // namespace

std::uint64_t window_triangles(std::uint64_t slab_triangles) { return slab_triangles * 7 / 2; }

std::optional<std::uint64_t> slab_triangles_for(std::uint64_t vertices, std::uint64_t triangles, std::uint64_t bytes) {
  constexpr std::uint64_t kMost = 1 << 21;
  constexpr std::uint64_t kFewest = 1 << 14;
  for (std::uint64_t slab = kMost; slab >= kFewest; slab /= 2) {
    const std::uint64_t window = window_triangles(slab);
    const std::uint64_t of_window = window * vertices / std::max<std::uint64_t>(triangles, 1);
    const std::uint64_t needed = WindowedSimplifier::bytes_of(of_window, window) +
                                 Simplifier::bytes_at_work(window, false) +
                                 WindowedSimplifier::lasting_bytes(vertices, triangles, window);
    if (needed <= bytes) return slab;
  }
  return std::nullopt;
}

Result<void> simplify_in_windows(mesh::Mesh& mesh, const SimplifyOptions& options, std::uint64_t slab_triangles,
                                 SimplifyFigures& facts, const Context& context) {
  facts.triangles_before = facts.triangles_after = mesh.triangles.size();
  const std::uint64_t lasting =
      WindowedSimplifier::lasting_bytes(mesh.positions.size(), mesh.triangles.size(), window_triangles(slab_triangles));
  auto memory = TRY(context.reserve(lasting, mesh.name + ": the buffers for simplifying"));
  WindowedSimplifier windows(mesh, options, facts, context);
  if (!TRY(windows.run(slab_triangles))) return {};
  memory.release();
  facts.triangles_after = windows.count_remaining();
  // The list of triangles, and the numbers and copies of the vertices.
  const std::uint64_t vertices = std::min<std::uint64_t>(mesh.positions.size(), 3 * facts.triangles_after);
  memory = TRY(context.reserve(facts.triangles_after * sizeof(glm::uvec3) +
                                   mesh.positions.size() * 2 * sizeof(std::uint32_t) + vertices * vertex_bytes(mesh),
                               mesh.name + ": the vertices and triangles of the simplified mesh"));
  windows.drop_removed_triangles();
  mesh.memory.shrink(mesh.positions.size() * vertex_bytes(mesh) + mesh.triangles.size_bytes());
  return {};
}

}  // namespace isoextract::edit
