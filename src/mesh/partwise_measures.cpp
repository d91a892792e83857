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
#include "mesh/detail/linked_parts.hpp"
#include "mesh/detail/part_vertices.hpp"
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
  State(std::string name, const Context& context)
      : name_(std::move(name)), what_(name_ + ": its figures"), context_(context) {}

  [[nodiscard]] const std::string& what() const { return what_; }

  Result<void> begin(const MeshShape& shape) {
    const std::uint64_t bytes_of_far = 2 * sizeof(std::uint32_t) + sizeof(glm::vec3);
    memory_ = TRY(context_.reserve(shape.far_vertices.size() * bytes_of_far, what_));
    shape_ = shape;
    far_positions_.resize(shape_.far_vertices.size());
    add_range_ends(0, shape.triangles, size_ends_);
    parts_.emplace(shape_.far_vertices, what_, context_);
    return {};
  }

  Result<void> take(const MeshPart& part) { return is_summing_ ? sum(part) : link(part); }

  Result<void> begin_sums() {
    is_summing_ = true;
    parts_->number();
    const std::uint64_t count = parts_->count();
    const auto threads = static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency());
    list_memory_ = TRY(context_.reserve(count * sizeof(ComponentFacts), what_));
    memory_.take(TRY(context_.reserve((threads + 1) * (count + 1) * sizeof(Topology), what_)));
    stars_.emplace([count] { return TopologyPart(std::max<std::size_t>(count, 1)); });
    facts_ = facts_without_triangles(count);
    return {};
  }

  Result<MeshMeasures> finish() {
    TRY(sum_waiting({}));
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
    all.components = std::move(facts_);
    all.memory = std::move(list_memory_);
    return all;
  }

 private:
  Result<void> link(const MeshPart& part) {
    const auto memory = TRY(context_.reserve(PartVertices::bytes(part.triangles.size()), what_));
    const PartVertices vertices(part.triangles, part.first_vertex, shape_.far_vertices);
    const auto more = TRY(context_.reserve(kNumberBytes * vertices.size(), what_));
    return parts_->add(vertices, part.first_vertex, Components(vertices.triangles(), vertices.size()));
  }

  // Sums the waiting part, which needs the positions of `part`. Then `part` waits.
  Result<void> sum(const MeshPart& part) {
    if (!space_ && !part.positions.empty()) space_.emplace(SumSpace{.apex = glm::dvec3(part.positions.front())});
    TRY(sum_waiting(part.positions));
    bounds_.add(part.positions);
    // The vectors keep the room of their largest part; a larger part replaces it.
    const std::size_t most_vertices = std::max(part.positions.size(), positions_.capacity());
    const std::size_t most_triangles =
        std::max(shared_triangles_.size() + part.triangles.size(), triangles_.capacity());
    const std::uint64_t bytes = most_vertices * sizeof(glm::vec3) + most_triangles * sizeof(glm::uvec3);
    if (bytes > waiting_memory_.bytes()) {
      waiting_memory_.take(TRY(context_.reserve(bytes - waiting_memory_.bytes(), what_)));
    }
    if (most_vertices > positions_.capacity()) positions_ = {};
    if (most_triangles > triangles_.capacity()) triangles_ = {};
    triangles_.reserve(most_triangles);
    first_vertex_ = part.first_vertex;
    first_triangle_ = part.first_triangle;
    positions_.assign(part.positions.begin(), part.positions.end());
    triangles_.assign(shared_triangles_.begin(), shared_triangles_.end());
    triangles_.insert(triangles_.end(), part.triangles.begin(), part.triangles.end());
    const std::vector<std::uint32_t>& far = shape_.far_vertices;
    for (auto v = std::ranges::lower_bound(far, first_vertex_);
         v != far.end() && *v < first_vertex_ + positions_.size(); ++v) {
      far_positions_[static_cast<std::size_t>(v - far.begin())] = positions_[*v - first_vertex_];
    }
    return {};
  }

  // Bytes of the component numbers of a vertex of a part: one here, one in Components and one in LinkedParts.
  static constexpr std::uint64_t kNumberBytes = 3 * sizeof(std::uint32_t);

  [[nodiscard]] std::span<const glm::uvec3> own_triangles() const {
    return std::span(triangles_).subspan(shared_triangles_.size());
  }

  Result<void> sum_waiting(std::span<const glm::vec3> next) {
    const std::span<const glm::uvec3> own = own_triangles();
    const std::uint64_t bytes = PartVertices::bytes(own.size()) +
                                (positions_.size() + next.size() + far_positions_.size()) * sizeof(glm::vec3) +
                                Buckets<Corner>::bytes(3 * triangles_.size(), positions_.size());
    const auto memory = TRY(context_.reserve(bytes, what_));
    const PartVertices vertices(own, first_vertex_, shape_.far_vertices);
    const auto more = TRY(context_.reserve(kNumberBytes * vertices.size(), what_));
    const Components components(vertices.triangles(), vertices.size());
    std::span<const std::uint32_t> numbers;
    if (!own.empty()) numbers = parts_->of_part(part_++);
    if (components.count() != numbers.size() || vertices.near() > positions_.size() + next.size()) {
      return fail(ErrorCode::input, fmt::format("{}: the samples changed between two passes", name_),
                  "wait until the program that writes the input has finished");
    }
    const auto component_of = [&](std::size_t number) {
      const std::uint32_t component = components.of_vertex(number);
      return component == Components::kNone ? Components::kNone : numbers[component];
    };
    add_sums(vertices, next, component_of);
    look_at_vertices(vertices, component_of);
    return carry_over(vertices, component_of);
  }

  template <class ComponentOf>
  void add_sums(const PartVertices& vertices, std::span<const glm::vec3> next, const ComponentOf& component_of) {
    Buffer<glm::vec3> positions(vertices.size());
    for_each_range(positions.size(), kComponentChunk, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v != end; ++v) {
        positions[v] = v < positions_.size() && v < vertices.near() ? positions_[v]
                       : v < vertices.near()                        ? next[v - positions_.size()]
                                                                    : far_positions_[v - vertices.near()];
      }
    });
    const std::span<const glm::uvec3> triangles = vertices.triangles();
    const auto of = [&](const Piece& piece) { return triangles.subspan(piece.begin, piece.end - piece.begin); };

    const auto ranges = split(first_triangle_, triangles.size(),
                              [&](std::uint64_t t) { return *std::ranges::upper_bound(size_ends_, t); });
    std::vector<MeshSize> sizes(ranges.size());
    if (!sizes.empty()) sizes.front() = std::exchange(open_size_, {});
    for_each_index(ranges.size(), [&](std::size_t r) {
      sizes[r] = with_sizes(sizes[r], std::as_const(positions).span(), of(ranges[r]), space_->apex);
    });
    for (std::size_t r = 0; r < ranges.size(); ++r) {
      if (ranges[r].is_last)
        sizes_.push_back(sizes[r]);
      else
        open_size_ = sizes[r];
    }

    const auto chunks = split(first_triangle_, triangles.size(),
                              [](std::uint64_t t) { return (t / kComponentChunk + 1) * kComponentChunk; });
    std::vector<std::vector<ComponentSum>> sums(chunks.size());
    if (!sums.empty()) sums.front() = std::exchange(open_chunk_, {});
    for_each_index(chunks.size(), [&](std::size_t c) {
      add_triangles(sums[c], std::as_const(positions).span(), of(chunks[c]), *space_, component_of);
    });
    for (std::size_t c = 0; c < chunks.size(); ++c) {
      if (chunks[c].is_last)
        add_chunk(facts_, sums[c], shape_.origin);
      else
        open_chunk_ = std::move(sums[c]);
    }
  }

  // Looks at the vertices of the waiting part, whose triangles are all in this part or in the part before it. Skips far
  // vertices, because triangles of the cap use them too.
  template <class ComponentOf>
  void look_at_vertices(const PartVertices& vertices, const ComponentOf& component_of) {
    const std::size_t count = positions_.size();
    const std::vector<bool> is_far = far_marks(count);
    const Buckets<Corner> corners(triangles_.size(), count, [&](std::size_t t, const auto& put) {
      for (int c = 0; c < 3; ++c) {
        const std::uint64_t place = triangles_[t][c] - first_vertex_;
        if (place < count && !is_far[place]) put(place, 3 * Corner{t} + static_cast<Corner>(c));
      }
    });
    std::vector<std::uint32_t> numbers(count);
    for (std::size_t v = 0; v < count; ++v) {
      numbers[v] = v < vertices.near() ? component_of(v) : Components::kNone;
      const std::uint64_t place = first_vertex_ + v - carried_from_;
      if (numbers[v] == Components::kNone && place < carried_.size()) numbers[v] = carried_[place];
    }
    for_each_range(count, kStarsTogether, [&](std::size_t begin, std::size_t end) {
      TopologyPart& star = stars_->local();
      for (std::size_t v = begin; v != end; ++v) {
        if (is_far[v]) continue;
        look_at(star, static_cast<std::uint32_t>(first_vertex_ + v), numbers[v], corners.at(v), triangles_);
      }
    });
    for (std::size_t v = 0; v < count; ++v) {
      if (!is_far[v]) count_vertex(numbers[v]);
    }
  }

  // Marks the far vertices among the `count` vertices that begin with the first vertex of the waiting part.
  [[nodiscard]] std::vector<bool> far_marks(std::size_t count) const {
    const std::vector<std::uint32_t>& far = shape_.far_vertices;
    std::vector<bool> marks(count);
    for (auto v = std::ranges::lower_bound(far, first_vertex_); v != far.end() && *v < first_vertex_ + count; ++v) {
      marks[*v - first_vertex_] = true;
    }
    return marks;
  }

  // Keeps the triangles and component numbers of the waiting part that later parts need.
  template <class ComponentOf>
  Result<void> carry_over(const PartVertices& vertices, const ComponentOf& component_of) {
    carried_from_ = first_vertex_;
    carried_.resize(vertices.near());
    for (std::size_t v = 0; v < carried_.size(); ++v) carried_[v] = component_of(v);
    const std::vector<bool> is_far = far_marks(vertices.near());
    std::vector<glm::uvec3> shared;
    const std::size_t known = far_triangles_.size();
    for (const glm::uvec3& t : own_triangles()) {
      bool is_shared = false;
      bool has_far = false;
      for (int c = 0; c < 3; ++c) {
        const bool is_near = t[c] >= first_vertex_;
        is_shared = is_shared || (is_near && t[c] - first_vertex_ >= positions_.size());
        has_far = has_far || !is_near || is_far[t[c] - first_vertex_];
      }
      if (is_shared) shared.push_back(t);
      if (has_far) far_triangles_.push_back(t);
    }
    shared_triangles_ = std::move(shared);
    triangles_.clear();
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
      look_at(stars_->local(), far[f], parts_->of_far(f), corners.at(f), far_triangles_);
      count_vertex(parts_->of_far(f));
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

  std::string name_;
  std::string what_;  // starts messages about memory
  Context context_;
  MeshShape shape_;
  bool is_summing_ = false;  // in the second pass
  std::optional<LinkedParts> parts_;
  std::size_t part_ = 0;  // in `parts_`, of the next part with triangles

  std::vector<std::uint64_t> size_ends_;  // of the ranges of reduce_ranges()
  std::vector<MeshSize> sizes_;           // of completed ranges
  MeshSize open_size_;                    // of the range that continues in the next part
  std::vector<ComponentSum> open_chunk_;  // of the chunk that continues in the next part
  std::vector<ComponentFacts> facts_;     // `euler` counts vertices until finish()
  Reservation list_memory_;               // for the facts
  GrowingBounds bounds_;
  std::optional<SumSpace> space_;

  Reservation memory_;  // for these:
  std::optional<tbb::enumerable_thread_specific<TopologyPart>> stars_;
  std::vector<glm::vec3> far_positions_;
  std::vector<glm::uvec3> far_triangles_;  // triangles with far vertices

  // The part that waits for the vertices of the next one.
  Reservation waiting_memory_;
  std::uint64_t first_vertex_ = 0;
  std::uint64_t first_triangle_ = 0;
  std::vector<glm::vec3> positions_;
  std::vector<glm::uvec3> triangles_;  // `shared_triangles_` and the waiting part's triangles
  // Data of the part before the waiting part: its triangles with vertices of the waiting part, and the components of
  // its vertices from carried_from_ on.
  std::vector<glm::uvec3> shared_triangles_;
  std::uint64_t carried_from_ = 0;
  std::vector<std::uint32_t> carried_;
};

PartwiseMeasures::PartwiseMeasures(const std::string& name, const Context& context)
    : state_(std::make_unique<State>(name, context)) {}
PartwiseMeasures::~PartwiseMeasures() = default;

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
