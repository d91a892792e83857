#include "extract/detail/net_grid.hpp"

#include <algorithm>
#include <utility>

#include <tbb/parallel_sort.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "extract/detail/near_labels.hpp"

namespace isoextract::extract {

Result<NetGrid> NetGrid::make(const LabelChunks& labels, NetMemory& memory) {
  const Context& context = memory.context();
  const std::string& what = memory.what();
  NetGrid grid;
  auto list_memory = TRY(context.reserve(8 * labels.chunks().size() * sizeof(glm::ivec3), what));
  std::vector<glm::ivec3> candidates;
  candidates.reserve(8 * labels.chunks().size());
  for (std::size_t c = 0; c < labels.chunks().size(); ++c) {
    const glm::ivec3& origin = labels.chunks()[c].origin;
    if (c > 0 && origin == labels.chunks()[c - 1].origin) continue;
    for (int n = 0; n < 8; ++n) candidates.push_back(origin + chunk_step(n));
  }
  tbb::parallel_sort(candidates.begin(), candidates.end(),
                     [](const glm::ivec3& a, const glm::ivec3& b) { return chunk_order(a) < chunk_order(b); });
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());

  auto flags = TRY(make_reserved_buffer<std::uint8_t>(candidates.size(), context, what));
  memory.for_each_chunk(candidates.size(), [&](std::size_t c) {
    const NearLabels near(labels, candidates[c]);
    std::uint64_t used = 0;
    for (int row = 0; row < 64 && used == 0; ++row) used = near.corners_between_labels(row & 7, row >> 3);
    flags->values[c] = used != 0 ? 1 : 0;
  });
  TRY(context.check());
  const auto chunks = static_cast<std::size_t>(std::count(flags->values.begin(), flags->values.end(), std::uint8_t{1}));
  grid.memory_ = TRY(context.reserve(index_bytes(chunks), what));
  if (prefers_files(chunks, context)) memory.use_files();
  grid.origins_.reserve(chunks);
  grid.index_ = field::OriginIndex(chunks);
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    if (flags->values[c] == 0) continue;
    grid.index_.insert(candidates[c], static_cast<std::int32_t>(grid.origins_.size()));
    grid.origins_.push_back(candidates[c]);
  }
  grid.near_ = TRY(memory.make<NearChunkNumbers>(chunks));
  memory.for_each_chunk(chunks, [&](std::size_t c) {
    for (int n = 0; n < 27; ++n) {
      const glm::ivec3 steps = glm::ivec3(n % 3, n / 3 % 3, n / 9) - 1;
      grid.near_[c][static_cast<std::size_t>(n)] = grid.find(grid.origins_[c] + kVoxelChunk * steps);
    }
  });
  grid.used_ = TRY(memory.make<ChunkBits>(chunks));
  grid.first_ = TRY(memory.make<RowBases>(chunks));
  memory.for_each_chunk(chunks, [&](std::size_t c) {
    const NearLabels near(labels, grid.origins_[c]);
    for (int z = 0; z < 8; ++z) {
      for (int y = 0; y < 8; ++y) {
        const std::uint64_t used = near.corners_between_labels(y, z);
        grid.used_[c][chunk_row(y, z)] = used;
        grid.first_[c][chunk_row(y, z)] = static_cast<std::uint32_t>(count_bits(used));
      }
    }
  });
  TRY(context.check());
  // Turns counts into first numbers.
  memory.for_each_run_of(grid.first_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      for (std::uint32_t& first : grid.first_[c]) {
        const std::uint32_t count = first;
        first = static_cast<std::uint32_t>(grid.points_);
        grid.points_ += count;
      }
    }
  });
  TRY(context.check());
  TRY(memory.check());
  if (grid.points_ > ~std::uint32_t{0}) {
    return fail(ErrorCode::input,
                what + ": the faces between labels have " + std::to_string(grid.points_) + " corners; the limit is " +
                    std::to_string(~std::uint32_t{0}),
                {Remedy::use, Setting::parts});
  }
  return grid;
}

}  // namespace isoextract::extract
