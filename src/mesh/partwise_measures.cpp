#include "mesh/partwise_measures.hpp"

#include <algorithm>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

#include "base/allocation_error.hpp"
#include "base/parallel.hpp"
#include "mesh/buckets.hpp"
#include "mesh/detail/topology_part.hpp"
#include "mesh/detail/triangle_sums.hpp"

namespace isoextract::mesh {
namespace {

constexpr std::size_t kStarsTogether = 1 << 10;

// Appends the ends of the ranges into which reduce_ranges() splits [begin, end).
void add_range_ends(std::uint64_t begin, std::uint64_t end, std::vector<std::uint64_t>& ends) {
  if (end - begin <= kSizeGrain) {
    ends.push_back(end);
    return;
  }
  const std::uint64_t middle = begin + (end - begin) / 2;
  add_range_ends(begin, middle, ends);
  add_range_ends(middle, end, ends);
}

// Joins the sums of these ranges as reduce_ranges() does.
MeshSize join_ranges(std::uint64_t begin, std::uint64_t end, std::span<const MeshSize>& sums) {
  if (end - begin <= kSizeGrain) {
    const MeshSize sum = sums.front();
    sums = sums.subspan(1);
    return sum;
  }
  const std::uint64_t middle = begin + (end - begin) / 2;
  const MeshSize earlier = join_ranges(begin, middle, sums);
  return joined(earlier, join_ranges(middle, end, sums));
}

// Triangles that one thread sums: a range of reduce_ranges() or a chunk, or a piece of one that began or ends in
// another part. `begin` and `end` are numbers in the part.
struct Piece {
  std::size_t begin = 0;
  std::size_t end = 0;
  bool is_last = false;  // of its range or chunk
};

// Splits `count` triangles from number `first` on. next_end(t) returns the end of the range that contains triangle t.
template <class NextEnd>
std::vector<Piece> split(std::uint64_t first, std::uint64_t count, const NextEnd& next_end) {
  std::vector<Piece> pieces;
  for (std::uint64_t begin = 0; begin < count;) {
    const std::uint64_t range_end = next_end(first + begin) - first;
    const std::uint64_t end = std::min(range_end, count);
    pieces.push_back({begin, end, end == range_end});
    begin = end;
  }
  return pieces;
}

// Returns step(), or ErrorCode::out_of_memory if it throws std::bad_alloc.
template <class Step>
auto guarded(const std::string& what, const Step& step) -> decltype(step()) {
  try {
    return step();
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
}

}  // namespace

class PartwiseMeasures::State {
 public:
  State(const std::string& name, const Context& context, const glm::dmat3& to_metric, LookAtPart look_at)
      : what_(name + ": its figures"),
        context_(context),
        to_metric_(to_metric),
        look_at_(std::move(look_at)),
        parts_(name, what_, context) {}

  [[nodiscard]] PartwiseComponents& components() { return parts_; }

  [[nodiscard]] const std::string& what() const { return what_; }

  Result<void> begin(const MeshShape& shape) {
    memory_ = TRY(context_.reserve(shape.far_vertices.size() * sizeof(std::uint32_t), what_));
    shape_ = shape;
    add_range_ends(0, shape.triangles, size_ends_);
    return parts_.begin(shape);
  }

  Result<void> take(const MeshPart& part) {
    if (!is_summing_) return parts_.link(part);
    if (!space_.has_value() && !part.positions.empty()) set_apex(part.positions.front());
    bounds_.add(part.positions);
    return parts_.take(part, sum_);
  }

  Result<void> begin_sums() {
    is_summing_ = true;
    parts_.number();
    const std::uint64_t count = parts_.count();
    const auto threads = static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency());
    list_memory_ = TRY(context_.reserve(count * sizeof(ComponentFacts), what_));
    star_memory_ = TRY(context_.reserve((threads + 1) * (count + 1) * sizeof(Topology), what_));
    stars_.emplace([count] { return TopologyPart(std::max<std::size_t>(count, 1)); });
    facts_ = facts_without_triangles(count);
    return {};
  }

  Result<MeshMeasures> finish() {
    TRY(parts_.finish(sum_));
    TRY(look_at_far_vertices());
    if (!open_chunk_.empty()) add_chunk(facts_, open_chunk_, shape_.origin);
    MeshMeasures all;
    std::span<const MeshSize> sizes = sizes_;
    if (shape_.triangles > 0) all.size = join_ranges(0, shape_.triangles, sizes);
    const LocalBounds local = shape_.vertices > 0 ? bounds_.get() : LocalBounds();
    all.bounds = {shape_.origin + glm::dvec3(local.min), shape_.origin + glm::dvec3(local.max)};
    std::vector<Topology> topology(std::max<std::size_t>(facts_.size(), 1));
    for (const TopologyPart& star : *stars_) star.add_to(topology);
    add_up(topology, all.topology);
    stars_.reset();
    star_memory_.release();
    all.components = std::move(facts_);
    all.memory = std::move(list_memory_);
    return all;
  }

 private:
  void set_apex(const glm::vec3& apex) {
    space_ = SumSpace{glm::dvec3(apex), to_metric_, glm::determinant(to_metric_) < 0 ? -1.0 : 1.0};
  }

  Result<void> sum(const LocalPart& part) {
    const auto memory = TRY(context_.reserve(
        Buckets<Corner>::bytes(3 * (shared_triangles_.size() + part.numbered.size()), part.own_positions.size()),
        what_));
    add_sums(part);
    TRY(look_at_vertices(part));
    TRY(keep_for_later_parts(part));
    return look_at_ ? look_at_(part) : Result<void>();
  }

  void add_sums(const LocalPart& part) {
    const std::span<const glm::uvec3> triangles = part.triangles;
    const auto of = [&](const Piece& piece) { return triangles.subspan(piece.begin, piece.end - piece.begin); };

    const auto ranges = split(part.first_triangle, triangles.size(),
                              [&](std::uint64_t t) { return *std::ranges::upper_bound(size_ends_, t); });
    std::vector<MeshSize> sizes(ranges.size());
    if (!sizes.empty()) sizes.front() = std::exchange(open_size_, {});
    for_each_index(ranges.size(), [&](std::size_t r) {
      sizes[r] = with_sizes(sizes[r], part.positions, of(ranges[r]), space_->apex);
    });
    for (std::size_t r = 0; r < ranges.size(); ++r) {
      if (ranges[r].is_last)
        sizes_.push_back(sizes[r]);
      else
        open_size_ = sizes[r];
    }

    const auto chunks = split(part.first_triangle, triangles.size(),
                              [](std::uint64_t t) { return (t / kComponentChunk + 1) * kComponentChunk; });
    std::vector<std::vector<ComponentSum>> sums(chunks.size());
    if (!sums.empty()) sums.front() = std::exchange(open_chunk_, {});
    for_each_index(chunks.size(), [&](std::size_t c) {
      add_triangles(sums[c], part.positions, of(chunks[c]), *space_,
                    [&](std::uint32_t vertex) { return part.components[vertex]; });
    });
    for (std::size_t c = 0; c < chunks.size(); ++c) {
      if (chunks[c].is_last)
        add_chunk(facts_, sums[c], shape_.origin);
      else
        open_chunk_ = std::move(sums[c]);
    }
  }

  // Looks at the vertices of the part, whose triangles are all in this part or in the part before it. Skips far
  // vertices, because triangles of the cap use them too.
  Result<void> look_at_vertices(const LocalPart& part) {
    const std::size_t count = part.own_positions.size();
    const std::vector<bool> is_far = far_marks(part, count);
    std::vector<glm::uvec3> triangles;
    const auto memory =
        TRY(context_.reserve((shared_triangles_.size() + part.numbered.size()) * sizeof(glm::uvec3), what_));
    triangles.reserve(shared_triangles_.size() + part.numbered.size());
    triangles.insert(triangles.end(), shared_triangles_.begin(), shared_triangles_.end());
    triangles.insert(triangles.end(), part.numbered.begin(), part.numbered.end());
    const Buckets<Corner> corners(triangles.size(), count, [&](std::size_t t, const auto& put) {
      for (int c = 0; c < 3; ++c) {
        const std::uint64_t place = triangles[t][c] - part.first_vertex;
        if (place < count && !is_far[place]) put(place, 3 * Corner{t} + static_cast<Corner>(c));
      }
    });
    for_each_range(count, kStarsTogether, [&](std::size_t begin, std::size_t end) {
      TopologyPart& star = stars_->local();
      for (std::size_t v = begin; v != end; ++v) {
        if (is_far[v]) continue;
        look_at(star, static_cast<std::uint32_t>(part.first_vertex + v), part.own_components[v], corners.at(v),
                triangles);
      }
    });
    for (std::size_t v = 0; v < count; ++v) {
      if (!is_far[v]) count_vertex(part.own_components[v]);
    }
    return {};
  }

  // Marks the far vertices among the `count` vertices that begin with the first vertex of the part.
  static std::vector<bool> far_marks(const LocalPart& part, std::size_t count) {
    std::vector<bool> marks(count);
    for (auto v = std::ranges::lower_bound(part.far, part.first_vertex);
         v != part.far.end() && *v < part.first_vertex + count; ++v) {
      marks[*v - part.first_vertex] = true;
    }
    return marks;
  }

  // Keeps the triangles of the part that later parts need.
  Result<void> keep_for_later_parts(const LocalPart& part) {
    const std::vector<bool> is_far = far_marks(part, part.near);
    std::vector<glm::uvec3> shared;
    const std::size_t known = far_triangles_.size();
    for (const glm::uvec3& t : part.numbered) {
      bool is_shared = false;
      bool has_far = false;
      for (int c = 0; c < 3; ++c) {
        const bool is_near = t[c] >= part.first_vertex;
        is_shared = is_shared || (is_near && t[c] - part.first_vertex >= part.own_positions.size());
        has_far = has_far || !is_near || is_far[t[c] - part.first_vertex];
      }
      if (is_shared) shared.push_back(t);
      if (has_far) far_triangles_.push_back(t);
    }
    shared_triangles_ = std::move(shared);
    memory_.take(TRY(context_.reserve((far_triangles_.size() - known) * sizeof(glm::uvec3), what_)));
    return {};
  }

  static void look_at(TopologyPart& star, std::uint32_t vertex, std::uint32_t component,
                      std::span<const Corner> corners, std::span<const glm::uvec3> triangles) {
    star.look_at(vertex, component == Components::kNone ? 0 : component, corners, triangles);
  }

  void count_vertex(std::uint32_t component) {
    if (component != Components::kNone) ++facts_[component].topology.euler;
  }

  Result<void> look_at_far_vertices() {
    const std::vector<std::uint32_t>& far = shape_.far_vertices;
    const auto memory = TRY(context_.reserve(Buckets<Corner>::bytes(3 * far_triangles_.size(), far.size()), what_));
    const Buckets<Corner> corners(far_triangles_.size(), far.size(), [&](std::size_t t, const auto& put) {
      for (int c = 0; c < 3; ++c) {
        const auto found = std::ranges::lower_bound(far, far_triangles_[t][c]);
        if (found != far.end() && *found == far_triangles_[t][c]) {
          put(static_cast<std::size_t>(found - far.begin()), 3 * Corner{t} + static_cast<Corner>(c));
        }
      }
    });
    for (std::size_t f = 0; f < far.size(); ++f) {
      look_at(stars_->local(), far[f], parts_.of_far(f), corners.at(f), far_triangles_);
      count_vertex(parts_.of_far(f));
    }
    return {};
  }

  // Completes the topology of the components and of the whole mesh.
  void add_up(const std::vector<Topology>& parts, Topology& all) {
    std::uint64_t triangles = 0;
    for (std::size_t c = 0; c < parts.size(); ++c) {
      const Topology& part = parts[c];
      add_counts(part, all);
      if (c == facts_.size()) break;  // a mesh without components
      ComponentFacts& fact = facts_[c];
      const std::int64_t vertices = fact.topology.euler;
      fact.topology = part;
      fact.topology.unused_vertices = 0;
      fact.topology.components = 1;
      fact.topology.euler =
          vertices - static_cast<std::int64_t>(part.edges) + static_cast<std::int64_t>(fact.triangles);
      triangles += fact.triangles;
    }
    all.components = facts_.size();
    all.repeated_index_triangles = shape_.triangles - triangles;
    all.euler = static_cast<std::int64_t>(shape_.vertices - all.unused_vertices) -
                static_cast<std::int64_t>(all.edges) + static_cast<std::int64_t>(triangles);
  }

  std::string what_;  // starts messages about memory
  Context context_;
  glm::dmat3 to_metric_;
  LookAtPart look_at_;
  MeshShape shape_;
  bool is_summing_ = false;  // in the second pass
  PartwiseComponents parts_;
  PartwiseComponents::Visit sum_ = [this](const LocalPart& part) { return sum(part); };

  std::vector<std::uint64_t> size_ends_;  // of the ranges of reduce_ranges()
  std::vector<MeshSize> sizes_;           // of completed ranges
  MeshSize open_size_;                    // of the range that continues in the next part
  std::vector<ComponentSum> open_chunk_;  // of the chunk that continues in the next part
  std::vector<ComponentFacts> facts_;     // `euler` counts vertices until finish()
  Reservation list_memory_;               // for the facts
  GrowingBounds bounds_;
  std::optional<SumSpace> space_;

  Reservation star_memory_;  // for this:
  std::optional<tbb::enumerable_thread_specific<TopologyPart>> stars_;
  Reservation memory_;                        // for the far vertices and these:
  std::vector<glm::uvec3> far_triangles_;     // triangles with far vertices
  std::vector<glm::uvec3> shared_triangles_;  // of the last part, with vertices of the next part
};

PartwiseMeasures::PartwiseMeasures(const std::string& name, const Context& context, const glm::dmat3& to_metric,
                                   LookAtPart look_at)
    : state_(std::make_unique<State>(name, context, to_metric, std::move(look_at))) {}
PartwiseMeasures::~PartwiseMeasures() = default;

PartwiseComponents& PartwiseMeasures::components() { return state_->components(); }

Result<bool> PartwiseMeasures::begin(const MeshShape& shape) {
  return guarded(state_->what(), [&]() -> Result<bool> {
    TRY(state_->begin(shape));
    return true;
  });
}

std::vector<PartPass> PartwiseMeasures::passes() const {
  return {{.in_order = true, .positions = false, .normals = false}, {.in_order = true, .normals = false}};
}

Result<void> PartwiseMeasures::begin_pass(std::size_t pass) {
  return guarded(state_->what(), [&] { return pass == 0 ? Result<void>() : state_->begin_sums(); });
}

Result<void> PartwiseMeasures::take(const MeshPart& part) {
  return guarded(state_->what(), [&] { return state_->take(part); });
}

Result<MeshMeasures> PartwiseMeasures::finish() {
  return guarded(state_->what(), [&] { return state_->finish(); });
}

}  // namespace isoextract::mesh
