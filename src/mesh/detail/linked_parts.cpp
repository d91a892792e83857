#include "mesh/detail/linked_parts.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "base/disjoint_sets.hpp"
#include "base/packed_values.hpp"
#include "mesh/detail/rank_turns.hpp"

namespace isoextract::mesh {
namespace {

// A vertex of the next rank that triangles of this rank use, and their component.
struct UsedVertex {
  std::uint32_t vertex;
  std::uint32_t component;
};

}  // namespace

Result<void> LinkedParts::add(const PartVertices& vertices, std::uint64_t first_vertex, const Components& own) {
  constexpr std::uint64_t kSetBytes = 2 * sizeof(std::uint32_t);
  const auto base = static_cast<std::uint32_t>(sets_.size());
  const std::size_t end = sets_.size() + own.count();
  if (end > sets_.capacity()) {
    const std::size_t room = std::max(end, 2 * sets_.capacity());
    memory_.take(TRY(context_.reserve((room - sets_.capacity()) * kSetBytes, what_)));
    sets_.reserve(room);
    least_.reserve(room);
  }
  for (std::uint32_t set = base; set < end; ++set) sets_.push_back(set);
  least_.resize(end, Components::kNone);
  ends_.push_back(end);

  const DisjointSets sets(sets_, true);
  const auto set_of = [&](std::size_t number) {
    const std::uint32_t component = own.of_vertex(number);
    return component == Components::kNone ? Components::kNone : base + component;
  };
  const auto link = [&](std::uint32_t& known, std::uint32_t set) {
    if (set == Components::kNone) return;
    if (known == Components::kNone) known = set;
    sets.join(known, set);
  };
  for (std::size_t number = 0; number < vertices.size(); ++number) {
    const std::uint32_t set = set_of(number);
    if (set != Components::kNone) least_[set] = std::min(least_[set], vertices.global(number));
  }
  std::vector<std::uint32_t> next(vertices.near());
  for (std::size_t number = 0; number < next.size(); ++number) {
    next[number] = set_of(number);
    const std::uint64_t place = first_vertex + number - carried_from_;
    if (place < carried_.size()) link(carried_[place], next[number]);
  }
  const auto first_far = std::ranges::lower_bound(far_, first_vertex);
  for (auto far = first_far; far != far_.end() && *far < first_vertex + next.size(); ++far) {
    link(far_sets_[static_cast<std::size_t>(far - far_.begin())], next[*far - first_vertex]);
  }
  for (std::size_t f = 0; f < far_.size() && vertices.has_far(); ++f) link(far_sets_[f], set_of(vertices.near() + f));
  carried_ = std::move(next);
  carried_from_ = first_vertex;
  return {};
}

Result<void> LinkedParts::number(Ranks* ranks) {
  const std::vector<std::uint32_t> firsts = number_own();
  count_ = static_cast<std::uint32_t>(firsts.size());
  if (ranks != nullptr) TRY(number_all(firsts, *ranks));
  carried_ = {};
  return {};
}

std::vector<std::uint32_t> LinkedParts::number_own() {
  const DisjointSets sets(sets_, true);
  std::vector<std::uint32_t> roots;
  for (std::uint32_t set = 0; set < sets_.size(); ++set) {
    const std::uint32_t root = sets.root(set);
    if (root == set) roots.push_back(set);
    sets_[set] = root;
    least_[root] = std::min(least_[root], least_[set]);
  }
  std::ranges::sort(roots, {}, [&](std::uint32_t root) { return least_[root]; });
  std::vector<std::uint32_t> firsts;
  firsts.reserve(roots.size());
  for (const std::uint32_t root : roots) {
    const auto number = static_cast<std::uint32_t>(firsts.size());
    firsts.push_back(std::exchange(least_[root], number));
  }
  for (std::uint32_t& set : sets_) set = least_[set];
  for (std::vector<std::uint32_t>* of_vertices : {&far_sets_, &carried_}) {
    for (std::uint32_t& set : *of_vertices) {
      if (set != Components::kNone) set = sets_[set];
    }
  }
  least_ = {};
  return firsts;
}

Result<void> LinkedParts::number_all(const std::vector<std::uint32_t>& firsts, Ranks& ranks) {
  const auto told = TRY(ranks.gather(Packer().put(far_.empty() ? Components::kNone : far_.front()).put(count_).take()));
  std::vector<std::uint32_t> offsets;
  std::uint32_t all = 0;
  std::uint32_t end = Components::kNone;  // of the vertices of this rank
  for (std::size_t r = 0; r < told.size(); ++r) {
    Unpacker from(told[r]);
    const auto first_far = from.get<std::uint32_t>();
    if (static_cast<int>(r) > ranks.rank()) end = std::min(end, first_far);
    offsets.push_back(all);
    all += from.get<std::uint32_t>();
  }
  const auto memory = TRY(context_.reserve(4 * sizeof(std::uint32_t) * std::uint64_t{all}, what_));
  const std::uint32_t own = offsets[static_cast<std::size_t>(ranks.rank())];
  for (std::uint32_t& set : far_sets_) {
    if (set != Components::kNone) set += own;
  }
  const std::vector<Joint> joints = TRY(join_far(offsets, end, ranks));

  std::vector<std::uint32_t> parents(all);
  for (std::uint32_t set = 0; set < all; ++set) parents[set] = set;
  const DisjointSets sets(parents, true);
  std::vector<std::uint32_t> least;
  least.reserve(all);
  TRY(for_each_rank(ranks, Packer().put(bytes_of(firsts)).put(bytes_of(joints)).take(),
                    [&](int, std::string_view bytes) -> Result<void> {
                      Unpacker from(bytes);
                      const auto of_rank = values_of<std::uint32_t>(from.get<std::string>());
                      least.insert(least.end(), of_rank.begin(), of_rank.end());
                      for (const Joint& joint : values_of<Joint>(from.get<std::string>())) sets.join(joint.a, joint.b);
                      return {};
                    }));
  std::vector<std::uint32_t> roots;
  for (std::uint32_t set = 0; set < all; ++set) {
    const std::uint32_t root = sets.root(set);
    if (root == set) roots.push_back(set);
    least[root] = std::min(least[root], least[set]);
  }
  std::ranges::sort(roots, {}, [&](std::uint32_t root) { return least[root]; });
  count_ = 0;
  for (const std::uint32_t root : roots) least[root] = count_++;
  const auto number = [&](std::uint32_t set) { return least[sets.root(set)]; };
  for (std::uint32_t& set : sets_) set = number(own + set);
  for (std::uint32_t& set : far_sets_) {
    if (set != Components::kNone) set = number(set);
  }
  return {};
}

Result<std::vector<LinkedParts::Joint>> LinkedParts::join_far(std::span<const std::uint32_t> offsets, std::uint32_t end,
                                                              Ranks& ranks) {
  std::vector<UsedVertex> used;
  for (std::size_t v = 0; v < carried_.size(); ++v) {
    const std::uint64_t vertex = carried_from_ + v;
    if (vertex < end || carried_[v] == Components::kNone) continue;
    used.push_back({static_cast<std::uint32_t>(vertex), carried_[v]});
  }
  std::vector<Joint> joints;
  TRY(for_each_rank(ranks, bytes_of(used), [&](int rank, std::string_view bytes) -> Result<void> {
    if (rank >= ranks.rank()) return {};
    for (const UsedVertex& one : values_of<UsedVertex>(bytes)) {
      const auto far = std::ranges::lower_bound(far_, one.vertex);
      if (far == far_.end() || *far != one.vertex) continue;
      const std::uint32_t before = offsets[static_cast<std::size_t>(rank)] + one.component;
      std::uint32_t& here = far_sets_[static_cast<std::size_t>(far - far_.begin())];
      if (here == Components::kNone) here = before;
      const Joint joint{before, here};
      if (joints.empty() || joints.back() != joint) joints.push_back(joint);
    }
    return {};
  }));
  return joints;
}

}  // namespace isoextract::mesh
