#include "edit/detail/sheet_trees.hpp"

#include "base/parallel.hpp"

namespace isoextract::edit {

SheetTrees::SheetTrees(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles,
                       std::span<const char> left_out, const Sheets& sheets)
    : first_(sheets.count + 1, 0), trees_(sheets.count) {
  for (std::uint32_t t = 0; t < triangles.size(); ++t) first_[sheets.of(t) + 1] += left_out[t] == 0 ? 1 : 0;
  for (std::uint32_t s = 0; s < sheets.count; ++s) first_[s + 1] += first_[s];
  numbers_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (left_out[t] == 0) numbers_[next[sheets.of(t)]++] = t;
  }
  for_each_index(sheets.count, [&](std::uint32_t s) {
    if (first_[s] == first_[s + 1]) return;
    std::vector<glm::uvec3> own;
    own.reserve(first_[s + 1] - first_[s]);
    for (std::uint32_t i = first_[s]; i < first_[s + 1]; ++i) own.push_back(triangles[numbers_[i]]);
    trees_[s].emplace(positions, own);
  });
}

std::vector<std::uint32_t> SheetTrees::slots(std::size_t triangles) const {
  std::vector<std::uint32_t> slots(triangles, 0);
  for (std::uint32_t s = 0; s < trees_.size(); ++s) {
    if (!trees_[s]) continue;
    for (std::uint32_t slot = 0; slot < trees_[s]->size(); ++slot) slots[triangle(s, slot)] = slot;
  }
  return slots;
}

}  // namespace isoextract::edit
