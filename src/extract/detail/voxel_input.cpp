#include "extract/detail/voxel_input.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "extract/sparse_sites.hpp"

namespace isoextract::extract {
namespace {

field::IndexBox common_part(const field::IndexBox& a, const field::IndexBox& b) {
  return {glm::max(a.min, b.min), glm::min(a.max, b.max)};
}

// Calls f(origin) for the chunks at the faces of a box.
template <class F>
void for_each_skin_chunk(const field::IndexBox& box, const F& f) {
  if (box.empty()) return;
  const glm::ivec3 first = chunk_origin(box.min);
  const glm::ivec3 last = chunk_origin(box.max);
  for (int z = first.z; z <= last.z; z += kVoxelChunk.z) {
    for (int y = first.y; y <= last.y; y += kVoxelChunk.y) {
      const bool at_boundary = y == first.y || y == last.y || z == first.z || z == last.z;
      const int step = at_boundary ? kVoxelChunk.x : std::max(last.x - first.x, kVoxelChunk.x);
      for (int x = first.x; x <= last.x; x += step) f(glm::ivec3(x, y, z));
    }
  }
}

bool is_small(const field::SparseTile& tile) { return tile.size < kVoxelChunk.x; }

}  // namespace

field::IndexBox everywhere() {
  constexpr int kFar = field::kMaxSparseIndex + 2 * kVoxelChunk.x;
  return {glm::ivec3(-kFar), glm::ivec3(kFar)};
}

Result<field::IndexBox> voxel_region(const field::ScalarField& field, const field::IndexBox& box,
                                     const ExtractOptions& options) {
  if (!options.region) return box;
  const field::IndexBox region = common_part(box, *options.region);
  if (!region.empty()) return region;
  return fail(
      ErrorCode::input,
      fmt::format(
          "{}: the region contains no sample of the field; the samples have the indices ({}, {}, {}) to ({}, {}, {})",
          field.source, box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z),
      {{Remedy::check, Setting::region, "it has to overlap the box of the data, which 'isoextract info' prints"},
       {Remedy::leave_out, Setting::region}});
}

OutputPlacement voxel_placement(const field::ScalarField& field, const ExtractOptions& options,
                                const field::IndexBox& stored, const field::IndexBox& region) {
  // Voxels extend half a step beyond the samples, and a region closes them as a cap would.
  ExtractOptions closed = options;
  closed.cap = true;
  return output_placement(field, closed, {stored.min - 1, stored.max + 1}, {region.min - 1, region.max + 1});
}

Result<SparseBounds> sparse_bounds(const field::ScalarField& field, const field::SparseSamples& samples,
                                   const ExtractOptions& options, bool unbounded) {
  // Calls sparse_region() to check the index range only, without the region: it requires a cell, voxels need only a
  // sample. voxel_region() clips below.
  ExtractOptions whole = options;
  whole.region.reset();
  TRY(sparse_region(field, samples, whole));
  SparseBounds reach{stored_box(samples), everywhere()};
  if (!options.region) return reach;
  reach.region = TRY(voxel_region(field, unbounded ? everywhere() : reach.stored, options));
  return reach;
}

Result<SparseBounds> label_bounds(const field::ScalarField& field, const ExtractOptions& options) {
  const auto* sparse = std::get_if<field::SparseSamples>(&field.samples);
  const field::IndexBox stored = sparse != nullptr ? stored_box(*sparse) : field.extents();
  if (stored.empty()) return SparseBounds{{glm::ivec3(0), glm::ivec3(0)}, {glm::ivec3(0), glm::ivec3(0)}};
  if (sparse != nullptr) return sparse_bounds(field, *sparse, options, false);
  return SparseBounds{stored, TRY(voxel_region(field, stored, options))};
}

OutputPlacement sparse_voxel_placement(const field::ScalarField& field, const ExtractOptions& options,
                                       const SparseBounds& reach) {
  return voxel_placement(field, options, reach.stored, options.region ? reach.region : reach.stored);
}

ChunkBits bits_within(const glm::ivec3& origin, const field::IndexBox& box) {
  const auto below = [](int count) { return count >= 64 ? kAllBits : (std::uint64_t{1} << std::max(count, 0)) - 1; };
  const std::uint64_t along = below(box.max.x - origin.x + 1) & ~below(box.min.x - origin.x);
  ChunkBits bits{};
  for (int z = 0; z < kVoxelChunk.z; ++z) {
    for (int y = 0; y < kVoxelChunk.y; ++y) {
      const glm::ivec2 p(origin.y + y, origin.z + z);
      const bool holds = p.x >= box.min.y && p.x <= box.max.y && p.y >= box.min.z && p.y <= box.max.z;
      bits[chunk_row(y, z)] = holds ? along : 0;
    }
  }
  return bits;
}

Result<std::vector<glm::ivec3>> sparse_chunks(const field::ScalarField& field, const field::SparseSamples& samples,
                                              const field::IndexBox& region, bool unbounded,
                                              const std::vector<std::uint8_t>& tiles_inside, const Context& context,
                                              Reservation& memory) {
  const auto list_all = [&](const auto& add) {
    const auto add_touching = [&](const glm::ivec3& origin) {
      if (!common_part({origin, origin + kVoxelChunk - 1}, region).empty()) add(origin);
    };
    // Neighbors in the list usually share a chunk.
    glm::ivec3 last(1);
    for (const field::SparseBlock& block : samples.blocks) {
      const glm::ivec3 origin = chunk_origin(block.origin);
      if (origin != last) add_touching(origin);
      last = origin;
    }
    for (std::size_t t = 0; t < samples.tiles.size(); ++t) {
      const field::SparseTile& tile = samples.tiles[t];
      const field::IndexBox box{tile.origin, tile.origin + (tile.size - 1)};
      if (is_small(tile)) {
        for (int z = 0; z < tile.size; z += kVoxelChunk.z) {
          for (int y = 0; y < tile.size; y += kVoxelChunk.y) {
            add_touching(chunk_origin(tile.origin + glm::ivec3(0, y, z)));
          }
        }
      } else if ((tiles_inside[t] != 0) != unbounded) {
        for_each_skin_chunk(common_part(box, region), add_touching);
      }
    }
    if (unbounded && region != everywhere()) for_each_skin_chunk(region, add_touching);
  };
  std::uint64_t count = 0;
  list_all([&](const glm::ivec3&) { ++count; });
  constexpr std::uint64_t kAround = 7;
  memory = TRY(context.reserve(count * (unbounded ? kAround : 1) * sizeof(glm::ivec3),
                               fmt::format("{}: the list of its voxel chunks", field.source)));
  std::vector<glm::ivec3> origins;
  origins.reserve(count * (unbounded ? kAround : 1));
  list_all([&](const glm::ivec3& origin) {
    origins.push_back(origin);
    if (!unbounded) return;
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 step(0);
      step[axis] = kVoxelChunk[axis];
      origins.push_back(origin - step);
      origins.push_back(origin + step);
    }
  });
  std::ranges::sort(origins, {}, chunk_order);
  origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
  return origins;
}

}  // namespace isoextract::extract
