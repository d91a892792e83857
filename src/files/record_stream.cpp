#include "files/record_stream.hpp"

#include <algorithm>
#include <atomic>
#include <span>
#include <utility>
#include <vector>

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include "base/buffer.hpp"

namespace isoextract::files {

Result<void> write_records(OutputFile& file, std::size_t count, std::size_t max_record_bytes, const FillRecords& fill) {
  constexpr std::size_t kBlockBytes = std::size_t{1} << 20;  // small enough to be in the cache when the system copies
                                                             // it
  const std::size_t per_block = std::max<std::size_t>(1, kBlockBytes / max_record_bytes);
  const std::size_t block_count = (count + per_block - 1) / per_block;
  if (block_count == 0) return {};
  if (block_count == 1) {  // a pipeline costs more than a small mesh
    Buffer<char> bytes(count * max_record_bytes);
    const char* end = fill(0, count, bytes.data());
    return file.write(std::as_bytes(std::as_const(bytes).span().first(static_cast<std::size_t>(end - bytes.data()))));
  }

  struct Block {
    Buffer<char> bytes;
    std::size_t index = 0;
    std::size_t used = 0;
  };
  const std::size_t threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  std::vector<Block> blocks(std::min(block_count, 2 * threads));

  Result<void> written;              // used by write_block alone until all is done
  std::atomic<bool> failed = false;  // tells begin of a failure
  std::size_t next = 0;
  // At most blocks.size() blocks are in flight and end in order: block i is free again when i + size begins.
  const auto begin = [&](tbb::flow_control& control) -> Block* {
    if (next == block_count || failed) {
      control.stop();
      return nullptr;
    }
    Block& block = blocks[next % blocks.size()];
    block.index = next++;
    return &block;
  };
  const auto fill_block = [&](Block* block) {
    if (block->bytes.empty()) block->bytes = Buffer<char>(per_block * max_record_bytes);
    const std::size_t first = block->index * per_block;
    const char* end = fill(first, std::min(count, first + per_block), block->bytes.data());
    block->used = static_cast<std::size_t>(end - block->bytes.data());
    return block;
  };
  const auto write_block = [&](const Block* block) {
    if (!written) return;
    written = file.write(std::as_bytes(block->bytes.span().first(block->used)));
    failed = !written;
  };
  tbb::parallel_pipeline(blocks.size(),
                         tbb::make_filter<void, Block*>(tbb::filter_mode::serial_in_order, begin) &
                             tbb::make_filter<Block*, Block*>(tbb::filter_mode::parallel, fill_block) &
                             tbb::make_filter<Block*, void>(tbb::filter_mode::serial_in_order, write_block));
  return written;
}

Result<void> fill_records(const OutputFile& file, std::uint64_t place, std::size_t count, std::size_t record_bytes,
                          const FillRecords& fill) {
  constexpr std::size_t kBlockBytes = std::size_t{1} << 18;  // stays in the cache of the core
  const std::size_t per_block = std::min(count, std::max<std::size_t>(1, kBlockBytes / record_bytes));
  Buffer<char> block(per_block * record_bytes);
  for (std::size_t first = 0; first < count; first += per_block) {
    const std::size_t last = std::min(count, first + per_block);
    fill(first, last, block.data());
    TRY(file.fill(place + first * record_bytes,
                  std::as_bytes(std::as_const(block).span().first((last - first) * record_bytes))));
  }
  return {};
}

}  // namespace isoextract::files
