#include "edit/detail/simplify_windows.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/parallel.hpp"
#include "edit/detail/sheet_collapse.hpp"
#include "edit/detail/simplifier.hpp"

namespace isoextract::edit {
namespace {

constexpr std::size_t kChunk = 1 << 12;  // triangles that share an interval
constexpr double kEverywhere = std::numeric_limits<double>::infinity();

struct Interval {
  double low = kEverywhere;
  double high = -kEverywhere;

  void add(const Interval& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
  [[nodiscard]] Interval widened(double by) const { return {low - by, high + by}; }
  [[nodiscard]] bool meets(const Interval& other) const { return low <= other.high && other.low <= high; }
  [[nodiscard]] bool contains(const Interval& other) const { return low <= other.low && other.high <= high; }
};

// Numbers a subset of the vertices in ascending order.
class VertexNumbers {
 public:
  explicit VertexNumbers(std::size_t vertices) : bits_((vertices + 63) / 64, 0), before_(bits_.size(), 0) {}

  void add(const glm::uvec3& t) {
    for (const std::uint32_t v : {t.x, t.y, t.z}) bits_[v / 64] |= std::uint64_t{1} << (v % 64);
  }
  // Call it after the last add(). Returns the vertices.
  [[nodiscard]] std::vector<std::uint32_t> list() {
    std::vector<std::uint32_t> vertices;
    for (std::size_t word = 0; word < bits_.size(); ++word) {
      before_[word] = static_cast<std::uint32_t>(vertices.size());
      for (std::uint64_t rest = bits_[word]; rest != 0; rest &= rest - 1) {
        vertices.push_back(static_cast<std::uint32_t>(64 * word + static_cast<std::size_t>(std::countr_zero(rest))));
      }
    }
    return vertices;
  }
  [[nodiscard]] std::uint32_t of(std::uint32_t v) const {
    const std::uint64_t lower = (std::uint64_t{1} << (v % 64)) - 1;
    return before_[v / 64] + static_cast<std::uint32_t>(std::popcount(bits_[v / 64] & lower));
  }
  [[nodiscard]] glm::uvec3 of(const glm::uvec3& t) const { return {of(t.x), of(t.y), of(t.z)}; }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t vertices) { return vertices / 4; }

 private:
  std::vector<std::uint64_t> bits_;
  std::vector<std::uint32_t> before_;  // vertices of the subset before each word of bits_
};

// The triangles and vertices of a window, with their numbers in the whole mesh. All lists are ascending.
struct Window {
  std::vector<std::uint32_t> originals;  // triangles whose originals the window has
  std::vector<std::uint32_t> present;    // triangles as they are now
  std::vector<std::uint32_t> triangles;  // both
  std::vector<std::uint32_t> vertices;
  std::optional<VertexNumbers> numbers;  // of `vertices`
  mesh::Mesh original;
  std::vector<glm::uvec3> corners;
  std::vector<char> gone, not_original, locked, wanted;  // as in CollapseStart
  std::vector<std::int8_t> sides;

  static constexpr std::uint64_t kTriangleBytes = 4 * sizeof(std::uint32_t) + 2 * sizeof(glm::uvec3) + 2;
  static constexpr std::uint64_t kVertexBytes = sizeof(std::uint32_t) + sizeof(glm::vec3) + 3;
};

class WindowedSimplifier {
 public:
  WindowedSimplifier(mesh::Mesh& mesh, const SimplifyOptions& options, SimplifyFigures& facts, const Context& context)
      : mesh_(mesh), options_(options), facts_(facts), context_(context), state_(mesh.triangles.size(), kUnchanged) {
    choose_axis();
  }

  Result<void> run(std::uint64_t slab_triangles) {
    const std::vector<double> planes = planes_of(slab_triangles);
    const std::size_t slabs = planes.size() + 1;
    facts_.windows = slabs;
    context_.progress().begin("simplifying", mesh_.triangles.size());
    const auto plane = [&](std::size_t i) {
      return i == 0 ? -kEverywhere : i > planes.size() ? kEverywhere : planes[i - 1];
    };
    for (std::size_t i = 0; i < slabs; ++i) {
      Interval window{plane(i), plane(i + 1)};
      const double two_below = plane(i < 2 ? 0 : i - 2);
      const double one_below = plane(i < 1 ? 0 : i - 1);
      if (i > 0) window.low = std::max(two_below, lowest_locked_at(plane(i)) - kMargin * options_.patch_size);
      forget_originals_below(two_below - reach());
      TRY(simplify(window, {one_below, plane(i)}));
      context_.progress().advance(mesh_.triangles.size() / slabs);
    }
    set_distance_lower();
    return {};
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

  // Distances within a window reach this far. Rounding of the coordinates is less than the rest.
  [[nodiscard]] double reach() const { return 1.001 * options_.max_distance; }

  [[nodiscard]] double along(std::uint32_t v) const { return glm::dot(axis_, glm::dvec3(mesh_.positions[v])); }

  [[nodiscard]] Interval interval_of(const glm::uvec3& t) const {
    const double a = along(t.x);
    const double b = along(t.y);
    const double c = along(t.z);
    return {std::min({a, b, c}), std::max({a, b, c})};
  }

  // Chooses the longest axis of the space of distances, and finds the interval of each chunk of triangles.
  void choose_axis() {
    const glm::dmat3 rows = glm::transpose(options_.to_metric);
    for (int i = 0; i < 3; ++i) {
      axis_ = rows[i];
      Interval all;
      for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) all.add({along(v), along(v)});
      if (all.high - all.low <= extent_.high - extent_.low) continue;
      extent_ = all;
      longest_ = rows[i];
    }
    axis_ = longest_;
    chunks_.resize((state_.size() + kChunk - 1) / kChunk);
    for_each_index(chunks_.size(), [&](std::size_t chunk) {
      for_each_of_chunk(chunk, [&](std::uint32_t t) { chunks_[chunk].add(interval_of(mesh_.triangles[t])); });
    });
  }

  template <class Body>
  void for_each_of_chunk(std::size_t chunk, const Body& body) const {
    const std::size_t end = std::min((chunk + 1) * kChunk, state_.size());
    for (std::size_t t = chunk * kChunk; t < end; ++t) body(static_cast<std::uint32_t>(t));
  }

  // Returns planes, in ascending order, with about this number of triangles between two of them.
  [[nodiscard]] std::vector<double> planes_of(std::uint64_t slab_triangles) const {
    constexpr std::size_t kBins = 1 << 16;
    const double width = (extent_.high - extent_.low) / kBins;
    std::vector<double> planes;
    if (!(width > 0)) return planes;
    std::vector<std::uint64_t> counts(kBins, 0);
    for (const glm::uvec3& t : mesh_.triangles) {
      const double bin = (along(t.x) - extent_.low) / width;
      ++counts[std::min(static_cast<std::size_t>(bin), kBins - 1)];
    }
    const std::uint64_t slabs = (state_.size() + slab_triangles - 1) / slab_triangles;
    const std::uint64_t even = (state_.size() + slabs - 1) / slabs;
    std::uint64_t count = 0;
    for (std::size_t bin = 0; bin + 1 < kBins; ++bin) {
      count += counts[bin];
      if (count < even) continue;
      planes.push_back(extent_.low + static_cast<double>(bin + 1) * width);
      count = 0;
    }
    if (count + counts.back() < even / 2 && !planes.empty()) planes.pop_back();
    return planes;
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
    CollapseStart start{window->corners, window->gone,  window->not_original,    window->locked,
                        window->wanted,  window->sides, least_triangles(*window)};
    SimplifyOptions options = options_;
    options.triangles = 0;
    SimplifyFigures facts;
    const Context own = context_.beside();  // the progress is that of all windows
    Simplifier simplifier(window->original, Sheets(), options, facts, own, &start);
    const bool is_changed = TRY(simplifier.run());
    add(facts);
    if (is_changed) take_over(*window, simplifier.state(), simplifier.slack());
    return {};
  }

  // Returns the share of a window in the triangles that stay.
  [[nodiscard]] std::size_t least_triangles(const Window& window) const {
    return options_.triangles * window.present.size() / state_.size();
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

  // `slack` is the rounding error of the distances of `state`.
  void take_over(const Window& window, const CollapseState& state, double slack) {
    const std::size_t known = saved_.size();
    std::vector<FarTriangle> far;
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
      far.push_back({state.known[i].lower - slack, t, corners});
    }
    std::inplace_merge(saved_.begin(), saved_.begin() + static_cast<std::ptrdiff_t>(known), saved_.end(),
                       [](const Original& a, const Original& b) { return a.triangle < b.triangle; });
    const std::size_t most = std::min<std::size_t>(far.size(), kFarTriangles);
    std::ranges::partial_sort(far, far.begin() + static_cast<std::ptrdiff_t>(most), std::ranges::greater(),
                              &FarTriangle::lower);
    far_.insert(far_.end(), far.begin(), far.begin() + static_cast<std::ptrdiff_t>(most));
  }

  void set_distance_lower() {
    for (const FarTriangle& far : far_) {
      if (state_[far.triangle] != kRemoved && mesh_.triangles[far.triangle] == far.corners) {
        facts_.distance_lower = std::max(facts_.distance_lower, far.lower);
      }
    }
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
  static constexpr double kMargin = 0.25;           // of the patch size: how far below a plane triangles change
  static constexpr std::size_t kFarTriangles = 64;  // of a window: later windows change few of the farthest

  mesh::Mesh& mesh_;
  const SimplifyOptions& options_;
  SimplifyFigures& facts_;
  const Context& context_;
  glm::dvec3 axis_{0.0};
  glm::dvec3 longest_{0.0};
  Interval extent_{0, 0};
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
    const std::uint64_t needed = WindowedSimplifier::bytes_of(of_window, window) + Simplifier::patch_bytes(window, 0) +
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
  const std::uint64_t gathered = mesh.positions.size() * vertex_bytes(mesh);
  const auto memory = TRY(context.reserve(lasting + gathered, mesh.name + ": the buffers for simplifying"));
  WindowedSimplifier windows(mesh, options, facts, context);
  TRY(windows.run(slab_triangles));
  windows.drop_removed_triangles();
  facts.triangles_after = mesh.triangles.size();
  return {};
}

}  // namespace isoextract::edit
