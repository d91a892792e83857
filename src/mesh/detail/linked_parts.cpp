#include "mesh/detail/linked_parts.hpp"

#include <algorithm>

#include "base/disjoint_sets.hpp"

namespace isoextract::mesh {

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

void LinkedParts::number() {
  const DisjointSets sets(sets_, true);
  std::vector<std::uint32_t> roots;
  for (std::uint32_t set = 0; set < sets_.size(); ++set) {
    const std::uint32_t root = sets.root(set);
    if (root == set) roots.push_back(set);
    sets_[set] = root;
    least_[root] = std::min(least_[root], least_[set]);
  }
  std::ranges::sort(roots, {}, [&](std::uint32_t root) { return least_[root]; });
  for (const std::uint32_t root : roots) least_[root] = count_++;
  for (std::uint32_t& set : sets_) set = least_[set];
  for (std::uint32_t& set : far_sets_) {
    if (set != Components::kNone) set = sets_[set];
  }
  carried_ = {};
  least_ = {};
}

}  // namespace isoextract::mesh
