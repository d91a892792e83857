#include "mesh/partwise_components.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/buffer.hpp"
#include "base/packed_values.hpp"
#include "base/parallel.hpp"
#include "mesh/components.hpp"
#include "mesh/detail/linked_parts.hpp"
#include "mesh/detail/part_vertices.hpp"
#include "mesh/detail/rank_turns.hpp"

namespace isoextract::mesh {
namespace {

constexpr std::size_t kNumbersTogether = 1 << 14;
// Bytes of the component numbers of a vertex of a part: one here, one in Components and one in LinkedParts.
constexpr std::uint64_t kNumberBytes = 3 * sizeof(std::uint32_t);

}  // namespace

tl::unexpected<Error> changed_between_passes(const std::string& name) {
  return fail(ErrorCode::input, fmt::format("{}: the samples changed between two passes", name),
              "wait until the program that writes the input has finished");
}

class PartwiseComponents::State {
 public:
  State(std::string name, std::string what, const Context& context)
      : name_(std::move(name)), what_(std::move(what)), context_(context) {}

  Result<void> begin(const MeshShape& shape, Ranks* ranks) {
    ranks_ = ranks;
    const std::uint64_t bytes_of_far = 2 * sizeof(std::uint32_t) + sizeof(glm::vec3);
    memory_ = TRY(context_.reserve(shape.far_vertices.size() * bytes_of_far, what_));
    far_ = shape.far_vertices;
    far_positions_.resize(far_.size());
    parts_.emplace(far_, what_, context_);
    return {};
  }

  Result<void> link(const MeshPart& part) {
    const auto memory = TRY(context_.reserve(PartVertices::bytes(part.triangles.size()), what_));
    const PartVertices vertices(part.triangles, part.first_vertex, far_);
    const auto more = TRY(context_.reserve(kNumberBytes * vertices.size(), what_));
    return parts_->add(vertices, part.first_vertex, Components(vertices.triangles(), vertices.size()));
  }

  Result<void> number() { return parts_->number(ranks_); }
  [[nodiscard]] const LinkedParts& parts() const { return *parts_; }

  Result<void> take(const MeshPart& part, const Visit& visit) {
    TRY(show_waiting(part.positions, visit));
    // The vectors keep the room of their largest part; a larger part replaces it.
    const std::size_t most_vertices = std::max(part.positions.size(), positions_.capacity());
    const std::size_t most_triangles = std::max(part.triangles.size(), triangles_.capacity());
    const std::uint64_t bytes = most_vertices * sizeof(glm::vec3) + most_triangles * sizeof(glm::uvec3);
    if (bytes > waiting_memory_.bytes()) {
      waiting_memory_.take(TRY(context_.reserve(bytes - waiting_memory_.bytes(), what_)));
    }
    if (most_vertices > positions_.capacity()) positions_ = {};
    if (most_triangles > triangles_.capacity()) triangles_ = {};
    first_vertex_ = part.first_vertex;
    first_triangle_ = part.first_triangle;
    positions_.assign(part.positions.begin(), part.positions.end());
    triangles_.assign(part.triangles.begin(), part.triangles.end());
    for_each_own_far([&](std::size_t f, std::size_t own) { far_positions_[f] = positions_[own]; });
    return {};
  }

  Result<void> finish(const Visit& visit) {
    Reservation memory;
    const std::vector<glm::vec3> next = TRY(positions_of_next_rank(memory));
    TRY(show_waiting(next, visit));
    positions_.clear();
    triangles_.clear();
    first_vertex_ = first_triangle_ = 0;
    carried_.clear();
    part_ = 0;
    return {};
  }

 private:
  // Calls body(index in far_, place in the waiting part) for each far vertex of the waiting part.
  template <class Body>
  void for_each_own_far(const Body& body) const {
    for (auto v = std::ranges::lower_bound(far_, first_vertex_);
         v != far_.end() && *v < first_vertex_ + positions_.size(); ++v) {
      body(static_cast<std::size_t>(v - far_.begin()), static_cast<std::size_t>(*v - first_vertex_));
    }
  }

  // Returns the positions of the vertices of the next rank that the waiting part may use; empty without ranks.
  Result<std::vector<glm::vec3>> positions_of_next_rank(Reservation& memory) {
    std::vector<glm::vec3> next;
    if (ranks_ == nullptr) return next;
    const std::uint64_t own_end = first_vertex_ + positions_.size();
    const std::uint64_t first_far = far_.empty() ? 0 : far_.front();
    TRY(for_each_rank(*ranks_, Packer().put(first_far).put(bytes_of(far_positions_)).take(),
                      [&](int rank, std::string_view bytes) -> Result<void> {
                        Unpacker from(bytes);
                        if (rank <= ranks_->rank() || from.get<std::uint64_t>() != own_end || !next.empty()) return {};
                        memory = TRY(context_.reserve(2 * bytes.size(), what_));
                        next = values_of<glm::vec3>(from.get<std::string>());
                        return {};
                      }));
    return next;
  }

  Result<void> show_waiting(std::span<const glm::vec3> next, const Visit& visit) {
    if (positions_.empty() && triangles_.empty()) return {};
    const std::uint64_t bytes = PartVertices::bytes(triangles_.size()) +
                                (positions_.size() + next.size() + far_.size()) * sizeof(glm::vec3) +
                                positions_.size() * sizeof(std::uint32_t);
    const auto memory = TRY(context_.reserve(bytes, what_));
    const PartVertices vertices(triangles_, first_vertex_, far_);
    const auto more = TRY(context_.reserve(kNumberBytes * vertices.size(), what_));
    Buffer<std::uint32_t> of_vertex(vertices.size());
    {
      const Components components(vertices.triangles(), vertices.size());
      std::span<const std::uint32_t> numbers;
      if (!triangles_.empty()) numbers = parts_->of_part(part_++);
      if (components.count() != numbers.size() || vertices.near() > positions_.size() + next.size()) {
        return changed_between_passes(name_);
      }
      for_each_range(of_vertex.size(), kNumbersTogether, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v != end; ++v) {
          const std::uint32_t component = components.of_vertex(v);
          of_vertex[v] = component == Components::kNone ? Components::kNone : numbers[component];
        }
      });
    }
    Buffer<glm::vec3> positions(vertices.size());
    for_each_range(positions.size(), kNumbersTogether, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v != end; ++v) {
        positions[v] = v < positions_.size() && v < vertices.near() ? positions_[v]
                       : v < vertices.near()                        ? next[v - positions_.size()]
                                                                    : far_positions_[v - vertices.near()];
      }
    });
    const std::vector<std::uint32_t> own = own_components(of_vertex.span().first(vertices.near()));
    LocalPart part;
    part.first_vertex = first_vertex_;
    part.first_triangle = first_triangle_;
    part.own_positions = positions_;
    part.near = vertices.near();
    part.triangles = vertices.triangles();
    part.numbered = triangles_;
    part.positions = positions.span();
    part.components = of_vertex.span();
    part.own_components = own;
    part.far = far_;
    TRY(visit(part));
    carried_.assign(of_vertex.begin(), of_vertex.begin() + static_cast<std::ptrdiff_t>(vertices.near()));
    carried_from_ = first_vertex_;
    return {};
  }

  // Adds the components of vertices that only the part before or a cap uses. `near` are those of the waiting part.
  [[nodiscard]] std::vector<std::uint32_t> own_components(std::span<const std::uint32_t> near) const {
    std::vector<std::uint32_t> own(positions_.size(), Components::kNone);
    std::ranges::copy(near.first(std::min(near.size(), own.size())), own.begin());
    for (std::size_t v = 0; v < own.size(); ++v) {
      const std::uint64_t place = first_vertex_ + v - carried_from_;
      if (own[v] == Components::kNone && place < carried_.size()) own[v] = carried_[place];
    }
    for_each_own_far([&](std::size_t f, std::size_t v) {
      if (own[v] == Components::kNone) own[v] = parts_->of_far(f);
    });
    return own;
  }

  std::string name_;
  std::string what_;
  Context context_;
  Ranks* ranks_ = nullptr;
  Reservation memory_;  // for the far vertices
  std::vector<std::uint32_t> far_;
  std::vector<glm::vec3> far_positions_;
  std::optional<LinkedParts> parts_;
  std::size_t part_ = 0;  // in `parts_`, of the next part with triangles

  // The part that waits for the vertices of the next one.
  Reservation waiting_memory_;
  std::uint64_t first_vertex_ = 0;
  std::uint64_t first_triangle_ = 0;
  std::vector<glm::vec3> positions_;
  std::vector<glm::uvec3> triangles_;
  // The components of the vertices of the part before the waiting one, from carried_from_ on.
  std::uint64_t carried_from_ = 0;
  std::vector<std::uint32_t> carried_;
};

PartwiseComponents::PartwiseComponents(std::string name, std::string what, const Context& context)
    : state_(std::make_unique<State>(std::move(name), std::move(what), context)) {}
PartwiseComponents::~PartwiseComponents() = default;

Result<void> PartwiseComponents::begin(const MeshShape& shape, Ranks* ranks) { return state_->begin(shape, ranks); }
Result<void> PartwiseComponents::link(const MeshPart& part) { return state_->link(part); }
Result<void> PartwiseComponents::number() { return state_->number(); }
std::uint32_t PartwiseComponents::count() const { return state_->parts().count(); }
std::uint32_t PartwiseComponents::of_far(std::size_t index) const { return state_->parts().of_far(index); }
Result<void> PartwiseComponents::take(const MeshPart& part, const Visit& visit) { return state_->take(part, visit); }
Result<void> PartwiseComponents::finish(const Visit& visit) { return state_->finish(visit); }

}  // namespace isoextract::mesh
