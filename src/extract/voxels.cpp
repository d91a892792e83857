#include "extract/voxels.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "extract/dense_input.hpp"
#include "extract/detail/voxel_input.hpp"
#include "extract/detail/voxel_mesh.hpp"
#include "extract/sparse_sites.hpp"

namespace isoextract::extract {
namespace {

constexpr const char* kChunkName = "64x8x8 voxels";

std::string chunks_text(const field::ScalarField& field) {
  return fmt::format("{}: the table of its voxel chunks", field.source);
}

// Builds chunks in parallel. fill(n, bits) writes the n-th of `count` chunks, at origin(n). Calls fill() a second time
// for chunks that are neither full nor empty, so that only these chunks need memory for bits.
template <class Fill, class Origin>
Result<VoxelChunks> fill_chunks(const field::ScalarField& field, std::size_t count, const Fill& fill,
                                const Origin& origin, VoxelChunks::Unlisted unlisted, const Context& context) {
  auto memory = TRY(context.reserve(VoxelChunks::bytes(count), chunks_text(field)));
  std::vector<VoxelChunk> chunks(count);
  for_each_index(count, [&](std::size_t n) {
    ChunkBits bits;
    fill(n, bits);
    const auto all = [&](std::uint64_t word) {
      return std::ranges::all_of(bits, [&](auto row) { return row == word; });
    };
    chunks[n] = {origin(n), all(0) ? &empty_chunk() : all(kAllBits) ? &full_chunk() : nullptr};
  });
  const auto is_mixed = [](const VoxelChunk& chunk) { return chunk.bits == nullptr; };
  const auto mixed = static_cast<std::size_t>(std::ranges::count_if(chunks, is_mixed));
  auto bits = TRY(make_reserved_buffer<ChunkBits>(mixed, context, chunks_text(field)));
  std::size_t next = 0;
  for (VoxelChunk& chunk : chunks) {
    if (is_mixed(chunk)) chunk.bits = &bits->values[next++];
  }
  for_each_index(count, [&](std::size_t n) {
    if (chunks[n].bits == &full_chunk() || chunks[n].bits == &empty_chunk()) return;
    fill(n, bits->values[static_cast<std::size_t>(chunks[n].bits - bits->values.data())]);
  });
  if (!unlisted) std::erase_if(chunks, [](const VoxelChunk& chunk) { return chunk.bits == &empty_chunk(); });
  return VoxelChunks(std::move(chunks), std::move(unlisted), std::move(bits), std::move(memory));
}

void count_chunks(ExtractStats& stats, std::uint64_t all, const VoxelChunks& voxels) {
  stats.brick = kChunkName;
  stats.bricks = all;
  stats.bricks_visited = static_cast<std::uint64_t>(std::ranges::count_if(voxels.chunks(), [](const VoxelChunk& chunk) {
    return chunk.bits != &full_chunk() && chunk.bits != &empty_chunk();
  }));
}

// Meshes the voxels in `bounds` (voxel indices; voxel 0 is sample `base`). All inside voxels are one label of the net.
Result<Extraction> mesh_in_bounds(const field::ScalarField& field, const VoxelChunks& voxels,
                                  const field::IndexBox& bounds, const glm::ivec3& base,
                                  const OutputPlacement& placement, const ExtractOptions& options,
                                  const ExtractStats& stats, const Context& context) {
  if (options.method != Method::surface_nets) {
    return mesh_voxels(field, voxels, base, placement, options, stats, context);
  }
  const Stopwatch watch;
  auto memory = TRY(context.reserve(LabelChunks::bytes(voxels.chunks().size()), chunks_text(field)));
  std::vector<LabelChunk> chunks(voxels.chunks().size());
  constexpr std::size_t kGrain = 256;
  for_each_index(
      chunks.size(),
      [&](std::size_t c) {
        const VoxelChunk& chunk = voxels.chunks()[c];
        chunks[c] = {0, chunk.origin, chunk.bits, rows_with_voxels(*chunk.bits)};
      },
      kGrain);
  const auto unlisted = [&](const glm::ivec3& origin) {
    return &voxels.at(origin) == &full_chunk() ? std::optional<std::int64_t>(0) : std::nullopt;
  };
  const LabelChunks inside(std::move(chunks), unlisted, bounds, std::move(memory));
  // Few masks need files: their faces and their mesh take more memory than the arrays of the net.
  NetMemory arrays(context, chunks_text(field));
  auto net = TRY(NetPoints::make(inside, options.relaxations, options.output_from_index.linear, arrays));
  ExtractStats with_net = stats;
  with_net.count += watch.elapsed();
  auto extraction = TRY(mesh_voxels(field, voxels, base, placement, options, with_net, context, &net));
  TRY(arrays.check());
  return extraction;
}

Result<Extraction> extract_dense_voxels(const field::ScalarField& field, const field::DenseSamples& samples,
                                        const ExtractOptions& options, const Context& context) {
  const auto region = TRY(voxel_region(field, {glm::ivec3(0), samples.dims - 1}, options));
  ExtractStats stats;
  const ChunkGrid grid(region);
  Result<VoxelChunks> voxels;
  {
    auto masks = TRY(make_masks(field, glm::ivec3(region.dims()), context));
    const auto classified = TRY(visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) -> Result<bool> {
      const DenseView<T> view = part_of(dense_view<T>(samples), region);
      const auto threshold = TRY(classify_dense(field, view, region.min, options, masks, stats, context));
      return threshold.has_value();
    }));
    if (!classified) {
      count_chunks(stats, grid.count(), {});
      return Extraction{{}, stats};
    }
    const glm::ivec3& dims = masks.dims();
    voxels = fill_chunks(
        field, grid.count(),
        [&](std::size_t n, ChunkBits& bits) {
          const glm::ivec3 origin = grid.origin(n);
          for (int z = 0; z < 8; ++z) {
            for (int y = 0; y < 8; ++y) {
              const bool there = origin.y + y < dims.y && origin.z + z < dims.z;
              bits[chunk_row(y, z)] = there ? masks.row(origin.y + y, origin.z + z)[origin.x / 64] : 0;
            }
          }
        },
        [&](std::size_t n) { return grid.origin(n); }, nullptr, context);
  }
  if (!voxels) return tl::unexpected(voxels.error());
  count_chunks(stats, grid.count(), *voxels);
  TRY(context.check());
  const OutputPlacement placement = voxel_placement(field, options, {glm::ivec3(0), samples.dims - 1}, region);
  const field::IndexBox bounds{glm::ivec3(0), region.max - region.min};
  return mesh_in_bounds(field, *voxels, bounds, region.min, placement, options, stats, context);
}

// Transposes 8x8 bits, whose rows are the bytes (Warren: Hacker's Delight, 7-3).
std::uint64_t turn_bits(std::uint64_t rows) {
  std::uint64_t t = (rows ^ rows >> 7) & 0x00AA00AA00AA00AAULL;
  rows ^= t ^ t << 7;
  t = (rows ^ rows >> 14) & 0x0000CCCC0000CCCCULL;
  rows ^= t ^ t << 14;
  t = (rows ^ rows >> 28) & 0x00000000F0F0F0F0ULL;
  return rows ^ t ^ t << 28;
}

// Copies the bits of a block, whose words run along x, to the rows of a chunk. The block is number `place` along x in
// the chunk.
void put_block(const BlockBits& block, int place, ChunkBits& bits) {
  for (int y = 0; y < kBlockSize; ++y) {
    std::uint64_t rows = 0;
    for (int x = 0; x < kBlockSize; ++x) rows |= (block[static_cast<std::size_t>(x)] >> 8 * y & 0xFF) << 8 * x;
    rows = turn_bits(rows);
    for (int z = 0; z < kBlockSize; ++z) bits[chunk_row(y, z)] |= (rows >> 8 * z & 0xFF) << 8 * place;
  }
}

Extraction no_voxels() {
  Extraction nothing;
  nothing.stats.brick = kChunkName;
  return nothing;
}

Result<Extraction> extract_sparse_voxels(const field::ScalarField& field, const field::SparseSamples& samples,
                                         const ExtractOptions& options, const Context& context) {
  if (stored_box(samples).empty()) return no_voxels();
  const bool unbounded = InsideRule{field.kind, options.iso}(field.scale(samples.background));
  const auto reach = TRY(sparse_bounds(field, samples, options, unbounded));
  ExtractStats stats;
  SparseSites samples_seen(field, samples, reach.region, options, context);
  TRY(samples_seen.compare(stats));
  const ConstantSides& sides = samples_seen.sides();
  Reservation list_memory;
  const auto origins =
      TRY(sparse_chunks(field, samples, reach.region, unbounded, sides.tiles_inside, context, list_memory));
  const field::SparseLookup& lookup = samples_seen.lookup();
  const auto voxels = TRY(fill_chunks(
      field, origins.size(),
      [&](std::size_t n, ChunkBits& bits) {
        const glm::ivec3& origin = origins[n];
        bits.fill(0);
        for (int place = 0; place < 8; ++place) {
          const std::int32_t stored = lookup.place(origin + glm::ivec3(8 * place, 0, 0));
          if (stored >= 0) {
            put_block(samples_seen.block_bits(static_cast<std::size_t>(stored)), place, bits);
          } else if (sides.inside(stored)) {
            for (std::uint64_t& row : bits) row |= std::uint64_t{0xFF} << 8 * place;
          }
        }
        const ChunkBits within = bits_within(origin, reach.region);
        for (std::size_t row = 0; row < bits.size(); ++row) bits[row] &= within[row];
      },
      [&](std::size_t n) { return (origins)[n]; },
      [&](const glm::ivec3& origin) { return is_in(reach.region, origin) && sides.inside(lookup.place(origin)); },
      context));
  count_chunks(stats, origins.size(), voxels);
  TRY(context.check());
  return mesh_in_bounds(field, voxels, reach.region, glm::ivec3(0), sparse_voxel_placement(field, options, reach),
                        options, stats, context);
}

}  // namespace

Result<Extraction> extract_voxels(const field::ScalarField& field, const ExtractOptions& options,
                                  const Context& context) {
  if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
    return extract_dense_voxels(field, *dense, options, context);
  }
  return extract_sparse_voxels(field, std::get<field::SparseSamples>(field.samples), options, context);
}

Result<Extraction> extract_surface_nets(const field::ScalarField& field, const ExtractOptions& options,
                                        const Context& context) {
  return extract_voxels(field, options, context);  // chooses by options.method
}

}  // namespace isoextract::extract
