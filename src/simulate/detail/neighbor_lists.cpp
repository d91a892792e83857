#include "simulate/detail/neighbor_lists.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "base/parallel.hpp"

namespace isoextract::simulate {
namespace {

constexpr std::size_t kBlockCells = 64;
constexpr const char* kWhat = "the neighbors of particles";

}  // namespace

bool NeighborLists::Block::make_room(std::size_t count, const Context& context) {
  if (neighbors.size() - used >= count) return true;
  const std::size_t wanted = std::max(used + count, 2 * neighbors.size());
  auto reserved = context.reserve(std::uint64_t{wanted} * sizeof(std::uint32_t), kWhat);
  if (!reserved) {
    error = reserved.error();
    return false;
  }
  Buffer<std::uint32_t> larger(wanted);
  std::copy_n(neighbors.begin(), used, larger.begin());
  neighbors = std::move(larger);
  memory = std::move(*reserved);
  return true;
}

void NeighborLists::fill(Block& block, std::size_t first_cell, std::size_t last_cell, const points::CellGrid& grid,
                         std::span<const glm::dvec3> positions, double reach, const Context& context) {
  const double reach2 = reach * reach;
  block.used = 0;
  block.error.reset();
  for (std::size_t c = first_cell; c != last_cell; ++c) {
    // Nine columns of cells; each is one run of spots.
    std::array<std::pair<std::size_t, std::size_t>, 9> runs;
    std::size_t run_count = 0;
    std::size_t candidates = 0;
    const points::CellGrid::Cell& cell = grid.cell(c);
    grid.for_each_run(cell.at - 1, cell.at + 1, [&](std::size_t first, std::size_t last) {
      runs[run_count] = {grid.cell(first).first, grid.cell_end(last - 1)};
      candidates += runs[run_count].second - runs[run_count].first;
      ++run_count;
    });
    for (std::size_t i = cell.first; i != grid.cell_end(c); ++i) {
      if (!block.make_room(candidates, context)) return;
      const glm::dvec3 position = positions[i];
      std::uint32_t* next = block.neighbors.data() + block.used;
      for (std::size_t r = 0; r < run_count; ++r) {
        for (std::size_t j = runs[r].first; j != runs[r].second; ++j) {
          const glm::dvec3 d = position - positions[j];
          // Always writes, to avoid a branch; there is room, as one candidate is i itself.
          *next = static_cast<std::uint32_t>(j);
          next += static_cast<std::size_t>(glm::dot(d, d) < reach2) & static_cast<std::size_t>(j != i);
        }
      }
      const std::size_t end = static_cast<std::size_t>(next - block.neighbors.data());
      lists_[i] = {block.neighbors.data() + block.used, end - block.used};
      block.used = end;
    }
  }
  // Growing may have moved the block's memory, so all lists are set again.
  const std::uint32_t* at = block.neighbors.data();
  for (std::size_t i = grid.cell(first_cell).first; i != grid.cell_end(last_cell - 1); ++i) {
    lists_[i] = {at, lists_[i].size()};
    at += lists_[i].size();
  }
}

Result<void> NeighborLists::make(const points::CellGrid& grid, std::span<const glm::dvec3> positions, double reach,
                                 const Context& context) {
  if (lists_.size() < positions.size()) {
    const std::size_t wanted = positions.size() + positions.size() / 4;
    lists_ = {};
    lists_memory_.release();
    lists_memory_ = TRY(context.reserve(std::uint64_t{wanted} * sizeof(std::span<const std::uint32_t>), kWhat));
    lists_ = Buffer<std::span<const std::uint32_t>>(wanted);
  }
  const std::size_t blocks = (grid.cell_count() + kBlockCells - 1) / kBlockCells;
  if (blocks_.size() < blocks) blocks_.resize(blocks);
  for_each_index(blocks, [&](std::size_t b) {
    fill(blocks_[b], b * kBlockCells, std::min(grid.cell_count(), (b + 1) * kBlockCells), grid, positions, reach,
         context);
  });
  for (std::size_t b = 0; b < blocks; ++b) {
    if (blocks_[b].error) return tl::unexpected(*blocks_[b].error);
  }
  return {};
}

}  // namespace isoextract::simulate
