#include "extract/detail/surface_points.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

#include <tbb/parallel_sort.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "extract/detail/corner_words.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

// The voxels around the corners of one chunk, row by row.
class CornerRows {
 public:
  CornerRows(const VoxelChunks& voxels, const glm::ivec3& origin) {
    for (int n = 0; n < 8; ++n) {
      near_[static_cast<std::size_t>(n)] = &voxels.at(origin - chunk_step(7 - n));
    }
  }

  [[nodiscard]] CornerWords row(int y, int z) const { return corner_words(near_, y, z); }

  // Returns whether find(words) finds a corner; `find` is contacts() or mixed().
  template <class Find>
  [[nodiscard]] bool any(const Find& find) const {
    CornerWords whole{};  // if every chunk is full or empty, voxels meet as the chunks do
    bool uniform = true;
    for (std::size_t n = 0; n < 8; ++n) {
      whole[n] = near_[n] == &full_chunk() ? kAllBits : 0;
      uniform = uniform && (whole[n] != 0 || near_[n] == &empty_chunk());
    }
    if (uniform) return find(whole) != 0;
    for (int z = 0; z < 8; ++z) {
      for (int y = 0; y < 8; ++y) {
        if (find(row(y, z)) != 0) return true;
      }
    }
    return false;
  }

 private:
  NearChunks near_;
};

// Returns the edges upward from corner `p`, as axis bits, that need a vertex in the middle for each voxel; `fans`
// belong to the pattern of `p`.
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

void make_unique(std::vector<glm::ivec3>& origins) {
  tbb::parallel_sort(origins.begin(), origins.end(),
                     [](const glm::ivec3& a, const glm::ivec3& b) { return chunk_order(a) < chunk_order(b); });
  origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
}

// Calls f(number 0 to 3, corner) for the corners of a layer's rectangles.
template <class F>
void for_each_corner(const LayerRectangles& layer, const F& f) {
  for (const FaceRectangle& rectangle : layer.rectangles.values()) {
    glm::ivec3 corner;
    corner[layer.axis] = rectangle.plane;
    for (std::size_t c = 0; c < 4; ++c) {
      corner[plane_u(layer.axis)] = (c & 1) != 0 ? rectangle.high[0] : rectangle.low[0];
      corner[plane_v(layer.axis)] = (c & 2) != 0 ? rectangle.high[1] : rectangle.low[1];
      f(c, corner);
    }
  }
}

// Returns the chunks that have a corner of a single face: a corner with voxels inside and outside around it.
Result<std::vector<glm::ivec3>> list_face_origins(const VoxelChunks& voxels, const Context& context,
                                                  const std::string& what, Reservation& memory) {
  const std::vector<VoxelChunk>& chunks = voxels.chunks();
  memory = TRY(context.reserve(8 * chunks.size() * sizeof(glm::ivec3), what));
  std::vector<glm::ivec3> origins;
  origins.reserve(8 * chunks.size());
  for (const VoxelChunk& chunk : chunks) {
    for (int n = 0; n < 8; ++n) origins.push_back(chunk.origin + chunk_step(n));
  }
  make_unique(origins);
  auto flags = TRY(make_reserved_buffer<std::uint8_t>(origins.size(), context, what));
  for_each_index(origins.size(),
                 [&](std::size_t c) { flags->values[c] = CornerRows(voxels, origins[c]).any(mixed<8>) ? 1 : 0; });
  std::size_t kept = 0;
  for (std::size_t c = 0; c < origins.size(); ++c) {
    if (flags->values[c] != 0) origins[kept++] = origins[c];
  }
  origins.resize(kept);
  return origins;
}

std::uint64_t below_bit(int bit) { return (std::uint64_t{1} << bit) - 1; }

}  // namespace

// Returns the chunks that have a used corner. If faces are large, these are few of the chunks that have faces.
Result<std::vector<glm::ivec3>> SurfacePoints::list_origins(const VoxelChunks& voxels,
                                                            const std::vector<LayerRectangles>& rectangles, bool closes,
                                                            const Context& context, const std::string& what,
                                                            Reservation& memory) {
  std::vector<ReservedList<glm::ivec3>> of_layers;
  of_layers.reserve(rectangles.size());
  for (std::size_t l = 0; l < rectangles.size(); ++l) of_layers.emplace_back(context, what);
  for_each_index(rectangles.size(), [&](std::size_t l) {
    std::array<glm::ivec3, 4> last;  // chunk origins; neighbors in the list usually share one
    last.fill(glm::ivec3(1));
    for_each_corner(rectangles[l], [&](std::size_t c, const glm::ivec3& corner) {
      const glm::ivec3 origin = chunk_origin(corner);
      if (origin != last[c]) of_layers[l].add(origin);
      last[c] = origin;
    });
    make_unique(of_layers[l].values());
  });
  std::uint64_t count = 0;
  for (const ReservedList<glm::ivec3>& layer : of_layers) {
    if (layer.error()) return tl::unexpected(*layer.error());
    count += layer.values().size();
  }

  // Finds for each listed chunk which of the eight chunks from itself upward have voxels that touch along an edge only.
  // Skips listed neighbors, because they have their own turn.
  const std::vector<VoxelChunk>& chunks = voxels.chunks();
  auto flags = TRY(make_reserved_buffer<std::uint8_t>(closes ? chunks.size() : 0, context, what));
  for_each_index(flags->values.size(), [&](std::size_t c) {
    unsigned found = 0;
    for (int n = 0; n < 8; ++n) {
      const glm::ivec3 origin = chunks[c].origin + chunk_step(n);
      if ((n == 0 || !voxels.lists(origin)) && CornerRows(voxels, origin).any(contacts)) found |= 1U << n;
    }
    flags->values[c] = static_cast<std::uint8_t>(found);
  });
  for (const std::uint8_t found : flags->values) count += static_cast<std::uint64_t>(std::popcount(found));

  memory = TRY(context.reserve(count * sizeof(glm::ivec3), what));
  std::vector<glm::ivec3> origins;
  origins.reserve(count);
  for (const ReservedList<glm::ivec3>& layer : of_layers) {
    origins.insert(origins.end(), layer.values().begin(), layer.values().end());
  }
  for (std::size_t c = 0; c < flags->values.size(); ++c) {
    for_each_bit(flags->values[c], [&](int n) { origins.push_back(chunks[c].origin + chunk_step(n)); });
  }
  make_unique(origins);
  return origins;
}

Result<SurfacePoints> SurfacePoints::make(const VoxelChunks& voxels, const std::vector<LayerRectangles>& rectangles,
                                          VoxelFaces faces, const NetPoints* net, const Context& context,
                                          const std::string& what) {
  const bool are_single = faces == VoxelFaces::plain;
  const bool closes = faces != VoxelFaces::rectangles;
  SurfacePoints points;
  points.net_ = net;
  Reservation list_memory;
  points.origins_ = TRY(are_single ? list_face_origins(voxels, context, what, list_memory)
                                   : list_origins(voxels, rectangles, closes, context, what, list_memory));
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
  for_each_index(chunks, [&](std::size_t c) {
    if (!closes) {
      points.used_[c].fill(0);
      return;
    }
    const CornerRows rows(voxels, points.origins_[c]);
    for (int row = 0; row < 64; ++row) {
      const CornerWords words = rows.row(row & 7, row >> 3);
      points.used_[c][static_cast<std::size_t>(row)] = are_single ? mixed(words) : contacts(words);
    }
  });
  if (!are_single) points.mark_corners(rectangles);
  TRY(context.check());

  for_each_index(chunks, [&](std::size_t c) {
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
  for_each_index(chunks, [&](std::size_t c) {
    if (points.special_number_[c] != kNoSpecials) points.fill_specials(voxels, c, closes);
    points.count_rows(c);
  });
  points.has_middles_ = std::ranges::any_of(points.specials_.span(), [](const Specials& chunk) {
    return std::ranges::any_of(chunk.middles, [](const ChunkBits& bits) { return bits != empty_chunk(); });
  });
  // Turns counts into first numbers.
  for (RowBases& rows : points.first_) {
    for (std::uint32_t& first : rows) {
      const std::uint32_t count = first;
      first = static_cast<std::uint32_t>(points.vertices_);
      points.vertices_ += count;
    }
  }
  return points;
}

// Marks the corners of the rectangles as used.
void SurfacePoints::mark_corners(const std::vector<LayerRectangles>& rectangles) {
  for_each_index(rectangles.size(), [&](std::size_t l) {
    std::array<glm::ivec3, 4> last;  // chunk origins; neighbors in the list usually share one
    std::array<std::size_t, 4> chunk{};
    last.fill(glm::ivec3(1));
    for_each_corner(rectangles[l], [&](std::size_t c, const glm::ivec3& corner) {
      if (const glm::ivec3 origin = chunk_origin(corner); origin != last[c]) {
        last[c] = origin;
        chunk[c] = static_cast<std::size_t>(index_.find(origin));
      }
      mark(chunk[c], corner);
    });
  });
}

void SurfacePoints::mark(std::size_t chunk, const glm::ivec3& corner) {
  std::atomic_ref<std::uint64_t> word(used_[chunk][chunk_row(corner.y, corner.z)]);
  const std::uint64_t bit = std::uint64_t{1} << (corner.x & 63);
  if ((word.load(std::memory_order_relaxed) & bit) == 0) word.fetch_or(bit, std::memory_order_relaxed);
}

bool SurfacePoints::has_specials(const VoxelChunks& voxels, std::size_t chunk, bool closes) const {
  if (net_ != nullptr && net_->middles(origins_[chunk]) != nullptr) return true;
  const CornerRows rows(voxels, origins_[chunk]);
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      std::uint64_t used = used_[chunk][chunk_row(y, z)];
      if (used == 0) continue;
      const CornerWords words = rows.row(y, z);
      for (; used != 0; used &= used - 1) {
        const int bit = std::countr_zero(used);
        const CornerFans& fans = corner_fans()[pattern_at(words, bit)];
        if (fans.fans > 1) return true;
        if (closes && net_ == nullptr && doubled_edges(voxels, origins_[chunk] + glm::ivec3(bit, y, z), fans) != 0)
          return true;
      }
    }
  }
  return false;
}

void SurfacePoints::fill_specials(const VoxelChunks& voxels, std::size_t chunk, bool closes) {
  Specials& specials = specials_[static_cast<std::size_t>(special_number_[chunk])];
  for (ChunkBits& bits : specials.more_fans) bits.fill(0);
  for (ChunkBits& bits : specials.middles) bits.fill(0);
  for (ChunkBits& bits : specials.single_middles) bits.fill(0);
  specials.pattern.fill(0);
  const CornerRows rows(voxels, origins_[chunk]);
  const std::array<ChunkBits, 3>* of_net = net_ != nullptr ? net_->middles(origins_[chunk]) : nullptr;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      const std::size_t row = chunk_row(y, z);
      const CornerWords words = rows.row(y, z);
      for (std::size_t axis = 0; of_net != nullptr && axis < 3; ++axis) {
        // Two vertices where voxels of this label touch along the edge only. Otherwise the label has one surface there
        // and one vertex.
        const std::array<std::uint64_t, 4> four = words_on_side(words, axis, 1);
        specials.middles[axis][row] = (*of_net)[axis][row] & mixed(four);
        specials.single_middles[axis][row] = specials.middles[axis][row] & ~diagonal(four);
      }
      for_each_bit(used_[chunk][row], [&](int bit) {
        const unsigned pattern = pattern_at(words, bit);
        const CornerFans& fans = corner_fans()[pattern];
        specials.pattern[64 * row + static_cast<std::size_t>(bit)] = static_cast<std::uint8_t>(pattern);
        const std::uint64_t more = fans.fans - 1U;
        for (std::size_t digit = 0; digit < 2; ++digit) specials.more_fans[digit][row] |= (more >> digit & 1) << bit;
        if (!closes || net_ != nullptr) return;
        const std::uint64_t edges = doubled_edges(voxels, origins_[chunk] + glm::ivec3(bit, y, z), fans);
        for (std::size_t axis = 0; axis < 3; ++axis) specials.middles[axis][row] |= (edges >> axis & 1) << bit;
      });
    }
  }
}

// Returns the number of vertices of a row at corners with bits in `below`.
std::uint32_t SurfacePoints::vertices_below(std::size_t chunk, std::size_t row, std::uint64_t below) const {
  int count = count_bits(used_[chunk][row] & below);
  if (special_number_[chunk] != kNoSpecials) {
    const Specials& specials = specials_[static_cast<std::size_t>(special_number_[chunk])];
    count += count_bits(specials.more_fans[0][row] & below) + 2 * count_bits(specials.more_fans[1][row] & below);
    for (const ChunkBits& middles : specials.middles) count += 2 * count_bits(middles[row] & below);
    for (const ChunkBits& middles : specials.single_middles) count -= count_bits(middles[row] & below);
  }
  return static_cast<std::uint32_t>(count);
}

void SurfacePoints::count_rows(std::size_t chunk) {
  for (std::size_t row = 0; row < 64; ++row) first_[chunk][row] = vertices_below(chunk, row, kAllBits);
}

void SurfacePoints::write_positions(const OutputPlacement& placement, const glm::ivec3& base, mesh::Mesh& mesh) const {
  for_each_index(origins_.size(), [&](std::size_t c) { write_chunk(placement, base, mesh, c); });
}

// A voxel is a box centered on its sample, hence the half step.
glm::dvec3 SurfacePoints::place_of(const glm::ivec3& base, std::int32_t net_chunk, const glm::ivec3& corner) const {
  const glm::dvec3 place = glm::dvec3(base + corner) - 0.5;
  return net_ == nullptr ? place : place + glm::dvec3(net_->offset(net_chunk, corner));
}

void SurfacePoints::write_chunk(const OutputPlacement& placement, const glm::ivec3& base, mesh::Mesh& mesh,
                                std::size_t chunk) const {
  const std::int32_t special = special_number_[chunk];
  const Specials* specials = special != kNoSpecials ? &specials_[static_cast<std::size_t>(special)] : nullptr;
  const std::int32_t net_chunk = net_ != nullptr ? net_->chunk(origins_[chunk]) : -1;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      const std::size_t row = chunk_row(y, z);
      std::uint32_t next = first_[chunk][row];
      for_each_bit(used_[chunk][row], [&](int bit) {
        const glm::ivec3 corner = origins_[chunk] + glm::ivec3(bit, y, z);
        const glm::vec3 position = placement.position(place_of(base, net_chunk, corner));
        mesh.positions[next++] = position;
        if (specials == nullptr) return;
        const std::uint64_t more =
            (specials->more_fans[0][row] >> bit & 1) + 2 * (specials->more_fans[1][row] >> bit & 1);
        for (std::uint64_t fan = 0; fan < more; ++fan) mesh.positions[next++] = position;
        for (int axis = 0; axis < 3; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          if ((specials->middles[a][row] >> bit & 1) == 0) continue;
          glm::ivec3 end = corner;
          ++end[axis];
          const std::int32_t end_chunk = net_ != nullptr ? net_->chunk(chunk_origin(end)) : -1;
          const glm::vec3 middle =
              placement.position((place_of(base, net_chunk, corner) + place_of(base, end_chunk, end)) / 2.0);
          mesh.positions[next++] = middle;
          if ((specials->single_middles[a][row] >> bit & 1) == 0) mesh.positions[next++] = middle;
        }
      });
    }
  }
}

void SurfacePoints::Finder::go_to(const glm::ivec3& corner) {
  const glm::ivec3 origin = chunk_origin(corner);
  if (origin == origin_) return;
  origin_ = origin;
  chunk_ = points_.index_.find(origin);
}

std::uint32_t SurfacePoints::Finder::vertex(const FaceCorner& at) {
  go_to(at.corner);
  const std::size_t row = chunk_row(at.corner.y, at.corner.z);
  const int bit = at.corner.x & 63;
  const std::uint32_t first = points_.first_[chunk()][row] + points_.vertices_below(chunk(), row, below_bit(bit));
  const std::int32_t special = points_.special_number_[chunk()];
  if (special == kNoSpecials) return first;
  const Specials& specials = points_.specials_[static_cast<std::size_t>(special)];
  const CornerFans& fans = corner_fans()[specials.pattern[64 * row + static_cast<std::size_t>(bit)]];
  return first + fans.of_face[static_cast<std::size_t>(at.face)];
}

std::optional<std::uint32_t> SurfacePoints::Finder::middle_vertex(const glm::ivec3& corner, int axis, int upper) {
  go_to(corner);
  const std::int32_t special = points_.special_number_[chunk()];
  if (special == kNoSpecials) return std::nullopt;
  const Specials& specials = points_.specials_[static_cast<std::size_t>(special)];
  const std::size_t row = chunk_row(corner.y, corner.z);
  const int bit = corner.x & 63;
  const auto count = [&](int a) {
    const auto n = static_cast<std::size_t>(a);
    return 2 * static_cast<std::uint32_t>(specials.middles[n][row] >> bit & 1) -
           static_cast<std::uint32_t>(specials.single_middles[n][row] >> bit & 1);
  };
  if (count(axis) == 0) return std::nullopt;
  const CornerFans& fans = corner_fans()[specials.pattern[64 * row + static_cast<std::size_t>(bit)]];
  std::uint32_t number =
      points_.first_[chunk()][row] + points_.vertices_below(chunk(), row, below_bit(bit)) + fans.fans;
  for (int a = 0; a < axis; ++a) number += count(a);
  return count(axis) == 1 ? number : number + static_cast<std::uint32_t>(upper);
}

// Returns the steps to the next used corner along `axis`, or `limit` if there is none before.
int SurfacePoints::Finder::steps_to_next(const glm::ivec3& corner, int axis, int limit) {
  glm::ivec3 p = corner;
  for (int steps = 1; steps < limit;) {
    p[axis] = corner[axis] + steps;
    go_to(p);
    if (chunk_ < 0) {
      steps += kVoxelChunk[axis] - (p[axis] & (kVoxelChunk[axis] - 1));
      continue;
    }
    const std::uint64_t word = points_.used_[chunk()][chunk_row(p.y, p.z)] >> (p.x & 63);
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
