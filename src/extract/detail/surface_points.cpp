#include "extract/detail/surface_points.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <iterator>
#include <utility>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

// The voxels around the corners of one chunk, row by row.
class CornerRows {
 public:
  CornerRows(const VoxelChunks& voxels, const glm::ivec3& origin) {
    for (int n = 0; n < 8; ++n) {
      const glm::ivec3 away(n & 1, n >> 1 & 1, n >> 2);
      near_[static_cast<std::size_t>(n)] = &voxels.at(origin - kVoxelChunk * (1 - away));
    }
  }

  // Bit b of word n: whether voxel n of the eight around corner b of the row is inside.
  using Words = std::array<std::uint64_t, 8>;
  [[nodiscard]] Words row(int y, int z) const {
    Words words;
    for (int n = 0; n < 8; n += 2) {
      const int voxel_y = y - 1 + (n >> 1 & 1);
      const int voxel_z = z - 1 + (n >> 2);
      const std::size_t chunk = (voxel_y < 0 ? 0U : 2U) | (voxel_z < 0 ? 0U : 4U);
      const std::uint64_t upper = (*near_[chunk | 1])[chunk_row(voxel_y, voxel_z)];
      const std::uint64_t before = (*near_[chunk])[chunk_row(voxel_y, voxel_z)];
      words[static_cast<std::size_t>(n)] = upper << 1 | before >> 63;
      words[static_cast<std::size_t>(n) + 1] = upper;
    }
    return words;
  }

 private:
  std::array<const ChunkBits*, 8> near_;
};

unsigned pattern_at(const CornerRows::Words& words, int bit) {
  unsigned pattern = 0;
  for (std::size_t n = 0; n < 8; ++n) pattern |= static_cast<unsigned>(words[n] >> bit & 1) << n;
  return pattern;
}

// Where two of the four around an edge touch along it only: a and d are opposite, as are b and c.
std::uint64_t diagonal(std::uint64_t a, std::uint64_t b, std::uint64_t c, std::uint64_t d) {
  return (a ^ b) & (a ^ c) & ~(a ^ d);
}

// Corners that such an edge ends in.
std::uint64_t contacts(const CornerRows::Words& w) {
  return diagonal(w[0], w[2], w[4], w[6]) | diagonal(w[1], w[3], w[5], w[7]) |  // along x
         diagonal(w[0], w[1], w[4], w[5]) | diagonal(w[2], w[3], w[6], w[7]) |  // along y
         diagonal(w[0], w[1], w[2], w[3]) | diagonal(w[4], w[5], w[6], w[7]);   // along z
}

// Edges upward from corner `p`, of the given pattern, that need a vertex in the middle for each voxel; bits of axes.
unsigned doubled_edges(const VoxelChunks& voxels, const glm::ivec3& p, const CornerFans& fans) {
  unsigned edges = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if ((fans.doubled[1] >> axis & 1) == 0) continue;
    glm::ivec3 next = p;
    ++next[axis];
    if ((corner_fans()[voxels.pattern(next)].doubled[0] >> axis & 1) != 0) edges |= 1U << axis;
  }
  return edges;
}

std::uint64_t below_bit(int bit) { return (std::uint64_t{1} << bit) - 1; }

}  // namespace

Result<std::vector<glm::ivec3>> SurfacePoints::list_origins(const VoxelChunks& voxels, const Context& context,
                                                            const std::string& what, Reservation& memory) {
  // Corners of a chunk's voxels are in it, and in those after it where voxels at its end are inside.
  const auto reaches = [](const VoxelChunk& chunk) {
    unsigned axes = 0;
    for (int z = 0; z < 8; ++z) {
      for (int y = 0; y < 8; ++y) {
        const std::uint64_t word = (*chunk.bits)[chunk_row(y, z)];
        axes |= word >> 63 != 0 ? 1U : 0U;
        axes |= word != 0 && y == 7 ? 2U : 0U;
        axes |= word != 0 && z == 7 ? 4U : 0U;
      }
    }
    return axes;
  };
  const auto is_within = [&](const VoxelChunk& chunk) {
    const auto is_full = [&](const glm::ivec3& step) { return &voxels.at(chunk.origin + step) == &full_chunk(); };
    if (chunk.bits != &full_chunk()) return false;
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 step(0);
      step[axis] = kVoxelChunk[axis];
      if (!is_full(step) || !is_full(-step)) return false;
    }
    return true;
  };
  std::vector<VoxelChunk> chunks;  // those that have a face
  auto listed = context.reserve(voxels.chunks().size() * sizeof(VoxelChunk), what);
  if (!listed) return tl::unexpected(listed.error());
  chunks.reserve(voxels.chunks().size());
  std::ranges::remove_copy_if(voxels.chunks(), std::back_inserter(chunks), is_within);
  std::uint64_t count = 0;
  for (const VoxelChunk& chunk : chunks) count += std::uint64_t{1} << std::popcount(reaches(chunk));
  auto held = context.reserve(count * sizeof(glm::ivec3), what);
  if (!held) return tl::unexpected(held.error());
  memory = std::move(*held);
  std::vector<glm::ivec3> origins;
  origins.reserve(count);
  for (const VoxelChunk& chunk : chunks) {
    const unsigned axes = reaches(chunk);
    for (unsigned n = 0; n < 8; ++n) {
      if ((n & ~axes) == 0) origins.push_back(chunk.origin + kVoxelChunk * glm::ivec3(n & 1, n >> 1 & 1, n >> 2));
    }
  }
  tbb::parallel_sort(origins.begin(), origins.end(),
                     [](const glm::ivec3& a, const glm::ivec3& b) { return chunk_order(a) < chunk_order(b); });
  origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
  return origins;
}

Result<SurfacePoints> SurfacePoints::make(const VoxelChunks& voxels, const std::vector<LayerRectangles>& rectangles,
                                          bool closes, const Context& context, const std::string& what) {
  SurfacePoints points;
  Reservation list_memory;
  auto origins = list_origins(voxels, context, what, list_memory);
  if (!origins) return tl::unexpected(origins.error());
  points.origins_ = std::move(*origins);
  points.memory_.push_back(std::move(list_memory));
  const std::size_t chunks = points.origins_.size();
  auto memory = context.reserve(VoxelChunks::bytes(chunks) + chunks * (sizeof(ChunkBits) + sizeof(RowBases) + 4), what);
  if (!memory) return tl::unexpected(memory.error());
  points.memory_.push_back(std::move(*memory));
  points.index_ = field::OriginIndex(chunks);
  for (std::size_t c = 0; c < chunks; ++c) points.index_.insert(points.origins_[c], static_cast<std::int32_t>(c));
  points.used_ = Buffer<ChunkBits>(chunks);
  points.first_ = Buffer<RowBases>(chunks);
  points.special_number_ = Buffer<std::int32_t>(chunks);

  context.progress().begin("numbering corners", 0);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t c) {
    points.used_[c].fill(0);
    if (closes) points.mark_contacts(voxels, c);
  });
  tbb::parallel_for(std::size_t{0}, rectangles.size(), [&](std::size_t l) {
    const int axis = rectangles[l].axis;
    for (const FaceRectangle& rectangle : rectangles[l].rectangles.values()) {
      glm::ivec3 corner;
      corner[axis] = rectangle.plane;
      for (const int u : {rectangle.low[0], rectangle.high[0]}) {
        for (const int v : {rectangle.low[1], rectangle.high[1]}) {
          corner[plane_u(axis)] = u;
          corner[plane_v(axis)] = v;
          points.mark(corner);
        }
      }
    }
  });
  if (auto wanted = context.check(); !wanted) return tl::unexpected(wanted.error());

  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t c) {
    points.special_number_[c] = points.has_specials(voxels, c, closes) ? 0 : kNoSpecials;
  });
  std::int32_t specials = 0;
  for (std::int32_t& number : points.special_number_) {
    if (number != kNoSpecials) number = specials++;
  }
  memory = context.reserve(static_cast<std::uint64_t>(specials) * sizeof(Specials), what);
  if (!memory) return tl::unexpected(memory.error());
  points.memory_.push_back(std::move(*memory));
  points.specials_ = Buffer<Specials>(static_cast<std::size_t>(specials));
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t c) {
    if (points.special_number_[c] != kNoSpecials) points.fill_specials(voxels, c, closes);
    points.count_rows(c);
  });
  // Counts become first numbers.
  for (RowBases& rows : points.first_) {
    for (std::uint32_t& first : rows) {
      const std::uint32_t count = first;
      first = static_cast<std::uint32_t>(points.vertices_);
      points.vertices_ += count;
    }
  }
  return points;
}

void SurfacePoints::mark(const glm::ivec3& corner) {
  const auto chunk = static_cast<std::size_t>(index_.find(chunk_origin(corner)));
  std::atomic_ref<std::uint64_t> word(used_[chunk][chunk_row(corner.y, corner.z)]);
  const std::uint64_t bit = std::uint64_t{1} << (corner.x & 63);
  if ((word.load(std::memory_order_relaxed) & bit) == 0) word.fetch_or(bit, std::memory_order_relaxed);
}

void SurfacePoints::mark_contacts(const VoxelChunks& voxels, std::size_t chunk) {
  const CornerRows rows(voxels, origins_[chunk]);
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) used_[chunk][chunk_row(y, z)] = contacts(rows.row(y, z));
  }
}

bool SurfacePoints::has_specials(const VoxelChunks& voxels, std::size_t chunk, bool closes) const {
  const CornerRows rows(voxels, origins_[chunk]);
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      std::uint64_t used = used_[chunk][chunk_row(y, z)];
      if (used == 0) continue;
      const CornerRows::Words words = rows.row(y, z);
      for (; used != 0; used &= used - 1) {
        const int bit = std::countr_zero(used);
        const CornerFans& fans = corner_fans()[pattern_at(words, bit)];
        if (fans.fans > 1) return true;
        if (closes && doubled_edges(voxels, origins_[chunk] + glm::ivec3(bit, y, z), fans) != 0) return true;
      }
    }
  }
  return false;
}

void SurfacePoints::fill_specials(const VoxelChunks& voxels, std::size_t chunk, bool closes) {
  Specials& specials = specials_[static_cast<std::size_t>(special_number_[chunk])];
  for (ChunkBits& bits : specials.more_fans) bits.fill(0);
  for (ChunkBits& bits : specials.middles) bits.fill(0);
  specials.pattern.fill(0);
  const CornerRows rows(voxels, origins_[chunk]);
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      const std::size_t row = chunk_row(y, z);
      const CornerRows::Words words = rows.row(y, z);
      for_each_bit(used_[chunk][row], [&](int bit) {
        const unsigned pattern = pattern_at(words, bit);
        const CornerFans& fans = corner_fans()[pattern];
        specials.pattern[64 * row + static_cast<std::size_t>(bit)] = static_cast<std::uint8_t>(pattern);
        const std::uint64_t more = fans.fans - 1U;
        for (std::size_t digit = 0; digit < 2; ++digit) specials.more_fans[digit][row] |= (more >> digit & 1) << bit;
        if (!closes) return;
        const std::uint64_t edges = doubled_edges(voxels, origins_[chunk] + glm::ivec3(bit, y, z), fans);
        for (std::size_t axis = 0; axis < 3; ++axis) specials.middles[axis][row] |= (edges >> axis & 1) << bit;
      });
    }
  }
}

// Of a row, those of corners with bits in `below`.
std::uint32_t SurfacePoints::vertices_below(std::size_t chunk, std::size_t row, std::uint64_t below) const {
  int count = std::popcount(used_[chunk][row] & below);
  if (special_number_[chunk] != kNoSpecials) {
    const Specials& specials = specials_[static_cast<std::size_t>(special_number_[chunk])];
    count += std::popcount(specials.more_fans[0][row] & below) + 2 * std::popcount(specials.more_fans[1][row] & below);
    for (const ChunkBits& middles : specials.middles) count += 2 * std::popcount(middles[row] & below);
  }
  return static_cast<std::uint32_t>(count);
}

void SurfacePoints::count_rows(std::size_t chunk) {
  for (std::size_t row = 0; row < 64; ++row) first_[chunk][row] = vertices_below(chunk, row, kAllBits);
}

void SurfacePoints::write_positions(const OutputFrame& placement, const glm::ivec3& base, mesh::Mesh& mesh) const {
  tbb::parallel_for(std::size_t{0}, origins_.size(), [&](std::size_t c) { write_chunk(placement, base, mesh, c); });
}

void SurfacePoints::write_chunk(const OutputFrame& placement, const glm::ivec3& base, mesh::Mesh& mesh,
                                std::size_t chunk) const {
  const std::int32_t special = special_number_[chunk];
  const Specials* specials = special != kNoSpecials ? &specials_[static_cast<std::size_t>(special)] : nullptr;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      const std::size_t row = chunk_row(y, z);
      std::uint32_t next = first_[chunk][row];
      for_each_bit(used_[chunk][row], [&](int bit) {
        // A voxel is a box around its sample.
        const glm::dvec3 corner = glm::dvec3(base + origins_[chunk] + glm::ivec3(bit, y, z)) - 0.5;
        const glm::vec3 position = placement.position(corner);
        mesh.positions[next++] = position;
        if (specials == nullptr) return;
        const std::uint64_t more =
            (specials->more_fans[0][row] >> bit & 1) + 2 * (specials->more_fans[1][row] >> bit & 1);
        for (std::uint64_t fan = 0; fan < more; ++fan) mesh.positions[next++] = position;
        for (int axis = 0; axis < 3; ++axis) {
          if ((specials->middles[static_cast<std::size_t>(axis)][row] >> bit & 1) == 0) continue;
          glm::dvec3 middle = corner;
          middle[axis] += 0.5;
          for (int voxel = 0; voxel < 2; ++voxel) mesh.positions[next++] = placement.position(middle);
        }
      });
    }
  }
}

void SurfacePoints::Finder::go_to(const glm::ivec3& corner) {
  const glm::ivec3 origin = chunk_origin(corner);
  if (origin == origin_) return;
  origin_ = origin;
  chunk_ = static_cast<std::size_t>(points_.index_.find(origin));
}

std::uint32_t SurfacePoints::Finder::vertex(const FaceCorner& at) {
  go_to(at.corner);
  const std::size_t row = chunk_row(at.corner.y, at.corner.z);
  const int bit = at.corner.x & 63;
  const std::uint32_t first = points_.first_[chunk_][row] + points_.vertices_below(chunk_, row, below_bit(bit));
  const std::int32_t special = points_.special_number_[chunk_];
  if (special == kNoSpecials) return first;
  const Specials& specials = points_.specials_[static_cast<std::size_t>(special)];
  const CornerFans& fans = corner_fans()[specials.pattern[64 * row + static_cast<std::size_t>(bit)]];
  return first + fans.of_face[static_cast<std::size_t>(at.face)];
}

std::optional<std::uint32_t> SurfacePoints::Finder::middle_vertex(const glm::ivec3& corner, int axis, int upper) {
  go_to(corner);
  const std::int32_t special = points_.special_number_[chunk_];
  if (special == kNoSpecials) return std::nullopt;
  const Specials& specials = points_.specials_[static_cast<std::size_t>(special)];
  const std::size_t row = chunk_row(corner.y, corner.z);
  const int bit = corner.x & 63;
  const auto has = [&](int a) { return (specials.middles[static_cast<std::size_t>(a)][row] >> bit & 1) != 0; };
  if (!has(axis)) return std::nullopt;
  const CornerFans& fans = corner_fans()[specials.pattern[64 * row + static_cast<std::size_t>(bit)]];
  std::uint32_t number = points_.first_[chunk_][row] + points_.vertices_below(chunk_, row, below_bit(bit)) + fans.fans;
  for (int a = 0; a < axis; ++a) number += has(a) ? 2 : 0;
  return number + static_cast<std::uint32_t>(upper);
}

// To the next used corner along `axis`; `limit` where there is none before.
int SurfacePoints::Finder::steps_to_next(const glm::ivec3& corner, int axis, int limit) {
  glm::ivec3 p = corner;
  for (int steps = 1; steps < limit;) {
    p[axis] = corner[axis] + steps;
    go_to(p);
    const std::uint64_t word = points_.used_[chunk_][chunk_row(p.y, p.z)] >> (p.x & 63);
    if (axis == 0) {
      if (word != 0) return std::min(steps + std::countr_zero(word), limit);
      steps += 64 - (p.x & 63);
    } else {
      if ((word & 1) != 0) return steps;
      ++steps;
    }
  }
  return limit;
}

}  // namespace isoextract::extract
