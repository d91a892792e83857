#include "extract/detail/near_labels.hpp"

#include <algorithm>
#include <optional>
#include <span>

#include "extract/detail/voxel_input.hpp"

namespace isoextract::extract {

NearLabels::NearLabels(const LabelChunks& labels, const glm::ivec3& origin) {
  for (int n = 0; n < 8; ++n) {
    const glm::ivec3 chunk = origin - chunk_step(7 - n);
    const std::span<const LabelChunk> listed = labels.at(chunk);
    for (const LabelChunk& part : listed) put(part.label, n, part.bits);
    if (!listed.empty()) continue;
    if (const auto label = labels.unlisted(chunk)) put(*label, n, &full_chunk());
  }
}

std::uint64_t NearLabels::used(int y, int z) const {
  std::uint64_t found = 0;
  for (const Entry& entry : entries_) {
    found |= mixed(corner_words(entry.near, y, z));
  }
  return found;
}

void NearLabels::put(std::int64_t label, int n, const ChunkBits* bits) {
  auto at = std::ranges::find(entries_, label, &Entry::label);
  if (at == entries_.end()) {
    Entry none{label, {}};
    none.near.fill(&empty_chunk());
    entries_.push_back(none);
    at = entries_.end() - 1;
  }
  at->near[static_cast<std::size_t>(n)] = bits;
}

NearRest::NearRest(const LabelChunks& labels, const NearLabels& near, const glm::ivec3& origin) {
  for (std::size_t n = 0; n < 8; ++n) {
    const ChunkBits within = bits_within(origin - chunk_step(7 - static_cast<int>(n)), labels.bounds());
    for (std::size_t row = 0; row < within.size(); ++row) {
      std::uint64_t labeled = 0;
      for (const NearLabels::Entry& entry : near.entries()) labeled |= (*entry.near[n])[row];
      unlabeled_[n][row] = within[row] & ~labeled;
      beyond_[n][row] = ~within[row];
    }
  }
}

std::array<NearChunks, 2> NearRest::near() const {
  std::array<NearChunks, 2> found{};
  for (std::size_t n = 0; n < 8; ++n) found[0][n] = &unlabeled_[n];
  for (std::size_t n = 0; n < 8; ++n) found[1][n] = &beyond_[n];
  return found;
}

}  // namespace isoextract::extract
