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
#include "base/packed_values.hpp"
#include "base/parallel.hpp"
#include "mesh/buckets.hpp"
#include "mesh/detail/rank_turns.hpp"
#include "mesh/detail/sums_of_parts.hpp"
#include "mesh/detail/topology_part.hpp"
#include "mesh/detail/triangle_sums.hpp"

namespace isoextract::mesh {
namespace {

constexpr std::size_t kStarsTogether = 1 << 10;

// The counts of one component that a rank found. `counts.euler` is the number of vertices.
struct CountsOfComponent {
  std::uint32_t component = 0;
  Topology counts;
};

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
  State(const std::string& name, const Context& context, const glm::dmat3& to_metric, LookAtPart look_at, Ranks* ranks)
      : what_(name + ": its figures"),
        context_(context),
        to_metric_(to_metric),
        look_at_(std::move(look_at)),
        ranks_(ranks),
        parts_(name, what_, context) {}

  [[nodiscard]] Ranks* ranks() const { return ranks_ != nullptr && ranks_->is_shared() ? ranks_ : nullptr; }

  [[nodiscard]] PartwiseComponents& components() { return parts_; }

  [[nodiscard]] const std::string& what() const { return what_; }

  Result<void> begin(const MeshShape& shape) {
    memory_ = TRY(context_.reserve(shape.far_vertices.size() * sizeof(std::uint32_t), what_));
    shape_ = shape;
    sums_.emplace(shape.triangles, ranks() != nullptr, what_, context_);
    return parts_.begin(shape, ranks());
  }

  Result<void> take(const MeshPart& part) {
    if (!is_summing_) return parts_.link(part);
    if (!space_.has_value() && !part.positions.empty()) TRY(set_apex(part.first_vertex, part.positions.front()));
    bounds_.add(part.positions);
    return parts_.take(part, sum_);
  }

  Result<void> begin_sums() {
    is_summing_ = true;
    TRY(parts_.number());
    const std::uint64_t count = parts_.count();
    const auto threads = static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency());
    list_memory_ = TRY(context_.reserve(count * sizeof(ComponentFacts), what_));
    star_memory_ = TRY(context_.reserve((threads + 1) * (count + 1) * sizeof(Topology), what_));
    stars_.emplace([count] { return TopologyPart(std::max<std::size_t>(count, 1)); });
    facts_ = facts_without_triangles(count);
    return {};
  }

  Result<MeshMeasures> finish() {
    Ranks* const sharing = ranks();
    if (sharing != nullptr && !space_) TRY(set_apex(kNoVertex, {}));  // other ranks wait for it
    TRY(parts_.finish(sum_));
    if (sharing != nullptr) TRY(take_triangles_of_rank_before(*sharing));
    TRY(look_at_far_vertices());
    std::vector<Topology> topology(std::max<std::size_t>(facts_.size(), 1));
    for (const TopologyPart& star : *stars_) star.add_to(topology);
    if (sharing != nullptr) TRY(join_ranks(*sharing, topology));
    MeshMeasures all;
    all.size = sums_->finish(shape_.origin, facts_);
    const LocalBounds local = shape_.vertices > 0 ? bounds_.get() : LocalBounds();
    all.bounds = {shape_.origin + glm::dvec3(local.min), shape_.origin + glm::dvec3(local.max)};
    add_up(topology, all.topology);
    stars_.reset();
    star_memory_.release();
    all.components = std::move(facts_);
    all.memory = std::move(list_memory_);
    return all;
  }

 private:
  static constexpr std::uint64_t kNoVertex = ~std::uint64_t{0};

  // Sets the space of the sums. The apex is the first vertex of the mesh; if ranks share it, the first one of any rank.
  Result<void> set_apex(std::uint64_t vertex, glm::vec3 apex) {
    if (Ranks* const sharing = ranks(); sharing != nullptr) {
      for (const std::string& told : TRY(sharing->gather(Packer().put(vertex).put(apex).take()))) {
        Unpacker from(told);
        const auto other = from.get<std::uint64_t>();
        if (other >= vertex) continue;
        vertex = other;
        apex = from.get<glm::vec3>();
      }
    }
    space_ = SumSpace{glm::dvec3(apex), to_metric_, glm::determinant(to_metric_) < 0 ? -1.0 : 1.0};
    return {};
  }

  // Adds the triangles of other ranks at the far vertices, which are vertices of this rank.
  Result<void> take_triangles_of_rank_before(Ranks& ranks) {
    const std::vector<std::uint32_t>& far = shape_.far_vertices;
    std::vector<glm::uvec3> found;
    TRY(for_each_rank(ranks, bytes_of(shared_triangles_), [&](int rank, std::string_view bytes) -> Result<void> {
      if (rank >= ranks.rank() || far.empty()) return {};
      const auto memory = TRY(context_.reserve(bytes.size(), what_));
      for (const glm::uvec3& t : values_of<glm::uvec3>(bytes)) {
        if (std::max({t.x, t.y, t.z}) >= far.front() && std::min({t.x, t.y, t.z}) <= far.back()) found.push_back(t);
      }
      memory_.take(TRY(context_.reserve(found.size() * sizeof(glm::uvec3), what_)));
      return {};
    }));
    far_triangles_.insert(far_triangles_.begin(), found.begin(), found.end());
    return {};
  }

  // Replaces the figures of this rank by those of all.
  Result<void> join_ranks(Ranks& ranks, std::vector<Topology>& topology) {
    SumsOfParts sums(shape_.triangles, true, what_, context_);
    TRY(for_each_rank(ranks, sums_->packed(),
                      [&](int, std::string_view bytes) { return sums.append(bytes, *space_, shape_.origin, facts_); }));
    sums_.emplace(std::move(sums));

    GrowingBounds bounds;
    for (const std::string& told : TRY(ranks.gather(Packer().put(bounds_).take()))) {
      bounds.add(Unpacker(told).get<GrowingBounds>());
    }
    bounds_ = bounds;

    std::vector<CountsOfComponent> own;
    for (std::uint32_t c = 0; c < topology.size(); ++c) {
      CountsOfComponent one{c, std::exchange(topology[c], {})};
      if (c < facts_.size()) one.counts.euler = std::exchange(facts_[c].topology.euler, 0);
      if (one.counts.edges > 0 || one.counts.unused_vertices > 0 || one.counts.euler > 0) own.push_back(one);
    }
    const auto memory = TRY(context_.reserve(own.size() * sizeof(CountsOfComponent), what_));
    return for_each_rank(ranks, bytes_of(own), [&](int, std::string_view bytes) -> Result<void> {
      const auto more = TRY(context_.reserve(bytes.size(), what_));
      for (const CountsOfComponent& one : values_of<CountsOfComponent>(bytes)) {
        add_counts(one.counts, topology[one.component]);
        if (one.component < facts_.size()) facts_[one.component].topology.euler += one.counts.euler;
      }
      return {};
    });
  }

  Result<void> sum(const LocalPart& part) {
    const auto memory = TRY(context_.reserve(
        Buckets<Corner>::bytes(3 * (shared_triangles_.size() + part.numbered.size()), part.own_positions.size()),
        what_));
    TRY(sums_->add(part, *space_, shape_.origin, facts_));
    TRY(look_at_vertices(part));
    TRY(keep_for_later_parts(part));
    return look_at_ ? look_at_(part) : Result<void>();
  }

  // Looks at the vertices of the part, whose triangles are all in this part or in the part before it. Skips far
  // vertices, because triangles of the cap or of another rank use them too.
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
  Ranks* ranks_;
  MeshShape shape_;
  bool is_summing_ = false;  // in the second pass
  PartwiseComponents parts_;
  PartwiseComponents::Visit sum_ = [this](const LocalPart& part) { return sum(part); };

  std::optional<SumsOfParts> sums_;
  std::vector<ComponentFacts> facts_;  // `euler` counts vertices until finish()
  Reservation list_memory_;            // for the facts
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
    : state_(std::make_unique<State>(name, context, to_metric, std::move(look_at), nullptr)) {}
PartwiseMeasures::PartwiseMeasures(const std::string& name, const Context& context, Ranks* ranks)
    : state_(std::make_unique<State>(name, context, glm::dmat3(1.0), LookAtPart(), ranks)) {}
PartwiseMeasures::~PartwiseMeasures() = default;

PartwiseComponents& PartwiseMeasures::components() { return state_->components(); }

Ranks* PartwiseMeasures::ranks() const { return state_->ranks(); }

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
