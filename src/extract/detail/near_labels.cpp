#include "extract/detail/near_labels.hpp"

#include <algorithm>
#include <optional>
#include <span>

#include "extract/detail/voxel_input.hpp"

namespace isoextract::extract {
namespace {

// Returns the rows of corners that have voxels of chunk n (NearChunks) around them. `voxels`: the rows of chunk n that
// have voxels. The voxels around a corner have the corner's index or one less along each axis.
std::uint64_t corner_rows(int n, std::uint64_t voxels) {
  constexpr std::uint64_t kLastOfY = 0x8080808080808080U;
  std::uint64_t rows = (n & 2) != 0 ? voxels | (voxels & ~kLastOfY) << 1 : (voxels & kLastOfY) >> 7;
  rows = (n & 4) != 0 ? rows | rows << 8 : rows >> 56;
  return rows;
}

}  // namespace

NearLabels::NearLabels(const LabelChunks& labels, const glm::ivec3& origin) {
  for (int n = 0; n < 8; ++n) {
    const glm::ivec3 chunk = origin - chunk_step(7 - n);
    const std::span<const LabelChunk> listed = labels.at(chunk);
    for (const LabelChunk& part : listed) put(part, n);
    if (!listed.empty()) continue;
    if (const auto label = labels.unlisted(chunk)) put({*label, chunk, &full_chunk(), kAllBits}, n);
  }
}

std::uint64_t NearLabels::corners_between_labels(int y, int z) const {
  std::uint64_t found = 0;
  for_each_in_row(y, z, [&](const Entry& /*entry*/, const CornerWords& words) { found |= mixed(words); });
  return found;
}

void NearLabels::put(const LabelChunk& chunk, int n) {
  auto at = std::ranges::find(entries_, chunk.label, &Entry::label);
  if (at == entries_.end()) {
    Entry none{chunk.label, {}};
    none.near.fill(&empty_chunk());
    entries_.push_back(none);
    at = entries_.end() - 1;
  }
  at->near[static_cast<std::size_t>(n)] = chunk.bits;
  at->rows |= corner_rows(n, chunk.rows);
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
