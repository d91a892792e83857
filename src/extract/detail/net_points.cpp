#include "extract/detail/net_points.hpp"

#include <algorithm>
#include <utility>

#include "base/parallel.hpp"
#include "extract/detail/corner_fans.hpp"
#include "extract/detail/near_labels.hpp"
#include "extract/detail/net_relaxation.hpp"
#include "extract/detail/net_volumes.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

unsigned pattern_of(const LabelChunks& labels, std::int64_t label, const glm::ivec3& corner) {
  unsigned pattern = 0;
  for (int n = 0; n < 8; ++n) {
    if (labels.has(label, corner - 1 + glm::ivec3(n & 1, n >> 1 & 1, n >> 2))) pattern |= 1U << n;
  }
  return pattern;
}

// Finds the edges of a chunk that need a vertex in their middle (NetPoints::middles). Returns false if there are none.
bool find_middles_of(const LabelChunks& labels, const glm::ivec3& origin, std::array<ChunkBits, 3>& middles) {
  bool any = false;
  for (ChunkBits& bits : middles) bits.fill(0);
  const NearLabels near(labels, origin);
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      near.for_each_in_row(y, z, [&](const NearLabels::Entry& entry, const CornerWords& words) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for_each_bit(diagonal(words_on_side(words, axis, 1)), [&](int bit) {
            if ((corner_fans()[pattern_at(words, bit)].doubled[1] >> axis & 1) == 0) return;
            glm::ivec3 next = origin + glm::ivec3(bit, y, z);
            ++next[static_cast<int>(axis)];
            if ((corner_fans()[pattern_of(labels, entry.label, next)].doubled[0] >> axis & 1) == 0) return;
            middles[axis][chunk_row(y, z)] |= std::uint64_t{1} << bit;
            any = true;
          });
        }
      });
    }
  }
  return any;
}

}  // namespace

Result<NetPoints> NetPoints::make(const LabelChunks& labels, std::uint64_t relaxations,
                                  const glm::dmat3& output_from_index, NetMemory& memory) {
  auto points = try_make(labels, relaxations, output_from_index, memory);
  // try_make() expects as many faces as points, and few shells: noise has many times as many.
  if (!points && points.error().code == ErrorCode::out_of_memory && !memory.uses_files()) {
    memory.use_files();
    points = try_make(labels, relaxations, output_from_index, memory);
  }
  return points;
}

Result<NetPoints> NetPoints::try_make(const LabelChunks& labels, std::uint64_t relaxations,
                                      const glm::dmat3& output_from_index, NetMemory& memory) {
  NetPoints points;
  const Context& context = memory.context();
  context.progress().begin("smoothing corners", relaxations);
  points.grid_ = TRY(NetGrid::make(labels, memory));
  const std::uint64_t count = points.grid_.size();
  const std::uint64_t chunks = points.grid_.origins().size();
  memory.expect(making_bytes(count, count, chunks, relaxations));
  if (prefers_files(count, count, chunks, relaxations, context)) memory.use_files();
  TRY(points.find_middles(labels, memory));
  points.offsets_ = TRY(memory.make<glm::vec3>(count + 1));
  memory.fill(points.offsets_, glm::vec3(0));
  TRY(relax_net(points.grid_, labels, relaxations, points.offsets_, memory));
  if (relaxations > 0) {
    points.shells_ = TRY(keep_volumes(points.grid_, labels, output_from_index, points.offsets_, memory));
  }
  memory.leave();
  TRY(context.check());
  TRY(memory.check());
  return points;
}

std::uint64_t NetPoints::making_bytes(std::uint64_t points, std::uint64_t faces, std::uint64_t chunks,
                                      std::uint64_t relaxations) {
  const std::uint64_t beside =
      relaxations > 0 ? std::max(relaxing_bytes(points), volume_keeping_bytes(points, faces, chunks)) : 0;
  return bytes(points, chunks) + beside;
}

bool NetPoints::prefers_files(std::uint64_t points, std::uint64_t faces, std::uint64_t chunks,
                              std::uint64_t relaxations, const Context& context) {
  return NetGrid::prefers_files(chunks, context) ||
         NetMemory::prefers_files(making_bytes(points, faces, chunks, relaxations), context);
}

std::uint64_t NetPoints::list_bytes(std::uint64_t chunks, std::uint64_t relaxations) {
  return NetGrid::bytes(chunks) - NetGrid::array_bytes(chunks) + (relaxations > 0 ? volume_list_bytes(chunks) : 0);
}

Result<void> NetPoints::find_middles(const LabelChunks& labels, NetMemory& memory) {
  middles_number_ = TRY(memory.make<std::int32_t>(grid_.origins().size()));
  memory.for_each_chunk(grid_.origins().size(), [&](std::size_t c) {
    Middles middles;
    middles_number_[c] = find_middles_of(labels, grid_.origins()[c], middles) ? 0 : -1;
  });
  TRY(memory.context().check());
  std::int32_t count = 0;
  for (std::int32_t& number : middles_number_) {
    if (number >= 0) number = count++;
  }
  middles_ = TRY(memory.make<Middles>(static_cast<std::size_t>(count)));
  memory.for_each_chunk(grid_.origins().size(), [&](std::size_t c) {
    if (middles_number_[c] >= 0) {
      find_middles_of(labels, grid_.origins()[c], middles_[static_cast<std::size_t>(middles_number_[c])]);
    }
  });
  return memory.context().check();
}

glm::vec3 NetPoints::offset(std::int32_t chunk, const glm::ivec3& corner) const {
  const NetGrid::Row row = grid_.row(chunk, corner.y, corner.z);
  const int bit = corner.x & 63;
  return (row.used >> bit & 1) != 0 ? offsets_[row.number(bit)] : glm::vec3(0);
}

const std::array<ChunkBits, 3>* NetPoints::middles(const glm::ivec3& origin) const {
  const std::int32_t chunk = grid_.find(origin);
  if (chunk < 0) return nullptr;
  const std::int32_t found = middles_number_[static_cast<std::size_t>(chunk)];
  return found < 0 ? nullptr : &middles_[static_cast<std::size_t>(found)];
}

}  // namespace isoextract::extract
