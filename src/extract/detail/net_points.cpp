#include "extract/detail/net_points.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include <tbb/parallel_sort.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "extract/detail/corner_fans.hpp"
#include "extract/detail/corner_words.hpp"
#include "extract/detail/voxel_input.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

// The part of the way to the mean of their neighbors that points move, and move back. A round removes the steps between
// voxels, but wide parts keep their shape and volume (Taubin: A signal processing approach to fair surface design.
// 1995). All points move at once.
constexpr float kForward = 0.65F;
constexpr float kBackward = -0.66F;

// Cell faces are numbered 2 * axis, plus 1 for the upper side.
constexpr std::size_t kFaces = 6;

constexpr std::array<glm::ivec3, kFaces> kFaceSteps{glm::ivec3(-1, 0, 0), glm::ivec3(1, 0, 0),  glm::ivec3(0, -1, 0),
                                                    glm::ivec3(0, 1, 0),  glm::ivec3(0, 0, -1), glm::ivec3(0, 0, 1)};

// The labels around the corners of one chunk.
class NearLabels {
 public:
  struct Entry {
    std::int64_t label;
    NearChunks near;
  };

  NearLabels(const LabelChunks& labels, const glm::ivec3& origin) {
    for (int n = 0; n < 8; ++n) {
      const glm::ivec3 chunk = origin - chunk_step(7 - n);
      const std::span<const LabelChunk> listed = labels.at(chunk);
      for (const LabelChunk& part : listed) put(part.label, n, part.bits);
      if (!listed.empty()) continue;
      if (const auto label = labels.unlisted(chunk)) put(*label, n, &full_chunk());
    }
  }

  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

  // Returns a bit for each corner of a row that has at least two labels around it.
  [[nodiscard]] std::uint64_t used(int y, int z) const {
    std::uint64_t found = 0;
    for (const Entry& entry : entries_) {
      const CornerWords words = corner_words(entry.near, y, z);
      std::uint64_t some = 0;
      std::uint64_t all = kAllBits;
      for (const std::uint64_t word : words) {
        some |= word;
        all &= word;
      }
      found |= some & ~all;
    }
    return found;
  }

 private:
  void put(std::int64_t label, int n, const ChunkBits* bits) {
    auto at = std::ranges::find(entries_, label, &Entry::label);
    if (at == entries_.end()) {
      Entry none{label, {}};
      none.near.fill(&empty_chunk());
      entries_.push_back(none);
      at = entries_.end() - 1;
    }
    at->near[static_cast<std::size_t>(n)] = bits;
  }

  std::vector<Entry> entries_;
};

// The voxels around the corners of a chunk that have no label, and the ones beyond the data boundary.
class NearRest {
 public:
  NearRest(const LabelChunks& labels, const NearLabels& near, const glm::ivec3& origin) {
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

  [[nodiscard]] std::array<NearChunks, 2> near() const {
    std::array<NearChunks, 2> found{};
    for (std::size_t n = 0; n < 8; ++n) found[0][n] = &unlabeled_[n];
    for (std::size_t n = 0; n < 8; ++n) found[1][n] = &beyond_[n];
    return found;
  }

 private:
  std::array<ChunkBits, 8> unlabeled_{};
  std::array<ChunkBits, 8> beyond_{};
};

// Counts the labels in each face of the cells of a row, as bits: at least one, two, three.
class FaceCounts {
 public:
  void add(const CornerWords& words) {
    for (std::size_t face = 0; face < kFaces; ++face) {
      const std::array<std::uint64_t, 4> four = words_on_side(words, face / 2, face % 2);
      const std::uint64_t some = four[0] | four[1] | four[2] | four[3];
      std::array<std::uint64_t, 3>& least = at_least_[face];
      least[2] |= least[1] & some;
      least[1] |= least[0] & some;
      least[0] |= some;
    }
  }

  // Returns the faces, as bits, through which the point of a cell is connected with others. A curve needs two ends: if
  // fewer than two faces have three labels, no curve passes.
  [[nodiscard]] std::uint8_t joined(int bit) const {
    unsigned two = 0;
    unsigned three = 0;
    for (std::size_t face = 0; face < kFaces; ++face) {
      two |= static_cast<unsigned>(at_least_[face][1] >> bit & 1) << face;
      three |= static_cast<unsigned>(at_least_[face][2] >> bit & 1) << face;
    }
    return static_cast<std::uint8_t>(std::popcount(three) >= 2 ? three : two);
  }

 private:
  std::array<std::array<std::uint64_t, 3>, kFaces> at_least_{};
};

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
  for (const NearLabels::Entry& entry : near.entries()) {
    for (int z = 0; z < 8; ++z) {
      for (int y = 0; y < 8; ++y) {
        const CornerWords words = corner_words(entry.near, y, z);
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
      }
    }
  }
  return any;
}

std::uint64_t bits_before(int bit) { return (std::uint64_t{1} << bit) - 1; }

}  // namespace

Result<NetPoints> NetPoints::make(const LabelChunks& labels, std::uint64_t relaxations, const Context& context,
                                  const std::string& what) {
  NetPoints points;
  context.progress().begin("smoothing corners", relaxations);
  TRY(points.list_chunks(labels, context, what));
  TRY(points.find_middles(labels, context, what));
  TRY(points.relax(labels, relaxations, context, what));
  return points;
}

// Lists the chunks that have points, and numbers the points.
Result<void> NetPoints::list_chunks(const LabelChunks& labels, const Context& context, const std::string& what) {
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
  for_each_index(candidates.size(), [&](std::size_t c) {
    const NearLabels near(labels, candidates[c]);
    std::uint64_t used = 0;
    for (int row = 0; row < 64 && used == 0; ++row) used = near.used(row & 7, row >> 3);
    flags->values[c] = used != 0 ? 1 : 0;
  });
  TRY(context.check());
  const auto chunks = static_cast<std::size_t>(std::count(flags->values.begin(), flags->values.end(), std::uint8_t{1}));
  auto held = context.reserve(
      VoxelChunks::bytes(chunks) + chunks * (sizeof(glm::ivec3) + sizeof(ChunkBits) + sizeof(RowBases) + 4), what);
  if (!held) return tl::unexpected(held.error());
  memory_.push_back(std::move(*held));
  origins_.reserve(chunks);
  index_ = field::OriginIndex(chunks);
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    if (flags->values[c] == 0) continue;
    index_.insert(candidates[c], static_cast<std::int32_t>(origins_.size()));
    origins_.push_back(candidates[c]);
  }
  used_ = Buffer<ChunkBits>(chunks);
  first_ = Buffer<RowBases>(chunks);
  for_each_index(chunks, [&](std::size_t c) {
    const NearLabels near(labels, origins_[c]);
    for (int z = 0; z < 8; ++z) {
      for (int y = 0; y < 8; ++y) {
        const std::uint64_t used = near.used(y, z);
        used_[c][chunk_row(y, z)] = used;
        first_[c][chunk_row(y, z)] = static_cast<std::uint32_t>(count_bits(used));
      }
    }
  });
  // Turns counts into first numbers.
  std::uint64_t points = 0;
  for (RowBases& rows : first_) {
    for (std::uint32_t& first : rows) {
      const std::uint32_t count = first;
      first = static_cast<std::uint32_t>(points);
      points += count;
    }
  }
  if (points > ~std::uint32_t{0}) {
    return fail(ErrorCode::input,
                what + ": the faces between labels have " + std::to_string(points) + " corners; the limit is " +
                    std::to_string(~std::uint32_t{0}),
                {Remedy::use, Setting::parts});
  }
  held = context.reserve(points * sizeof(glm::vec3), what);
  if (!held) return tl::unexpected(held.error());
  memory_.push_back(std::move(*held));
  offsets_ = Buffer<glm::vec3>(points);
  return {};
}

Result<void> NetPoints::find_middles(const LabelChunks& labels, const Context& context, const std::string& what) {
  middles_number_ = Buffer<std::int32_t>(origins_.size());
  for_each_index(origins_.size(), [&](std::size_t c) {
    Middles middles;
    middles_number_[c] = find_middles_of(labels, origins_[c], middles) ? 0 : -1;
  });
  std::int32_t count = 0;
  for (std::int32_t& number : middles_number_) {
    if (number >= 0) number = count++;
  }
  auto held = TRY(context.reserve(static_cast<std::uint64_t>(count) * sizeof(Middles), what));
  memory_.push_back(std::move(held));
  middles_ = Buffer<Middles>(static_cast<std::size_t>(count));
  for_each_index(origins_.size(), [&](std::size_t c) {
    if (middles_number_[c] >= 0) {
      find_middles_of(labels, origins_[c], middles_[static_cast<std::size_t>(middles_number_[c])]);
    }
  });
  return context.check();
}

std::size_t NetPoints::number(std::size_t chunk, std::size_t row, int bit) const {
  return first_[chunk][row] + static_cast<std::size_t>(count_bits(used_[chunk][row] & bits_before(bit)));
}

// One step of a round: reads the old positions of all points and writes the new ones.
struct NetPoints::Moves {
  const NetPoints& points;
  const field::IndexBox& bounds;
  const Buffer<std::uint8_t>& joined;
  const Buffer<glm::vec3>& from;
  Buffer<glm::vec3>& to;
  float step;

  // The row of points across each cell face, in this chunk or a neighboring one.
  struct Row {
    const std::uint64_t* used = nullptr;  // null if there is no such row
    std::uint32_t first = 0;
  };

  [[nodiscard]] Row row_at(std::int32_t chunk, int y, int z) const {
    if (chunk < 0) return {};
    const auto c = static_cast<std::size_t>(chunk);
    return {&points.used_[c][chunk_row(y, z)], points.first_[c][chunk_row(y, z)]};
  }

  void chunk(std::size_t c) const {
    const glm::ivec3 origin = points.origins_[c];
    std::array<std::int32_t, kFaces> next{};
    for (std::size_t face = 0; face < kFaces; ++face) {
      next[face] = points.index_.find(origin + kFaceSteps[face] * kVoxelChunk);
    }
    const auto self = static_cast<std::int32_t>(c);
    for (int z = 0; z < 8; ++z) {
      for (int y = 0; y < 8; ++y) {
        const std::uint64_t used = points.used_[c][chunk_row(y, z)];
        if (used == 0) continue;
        const std::array<Row, kFaces> rows{row_at(next[0], y, z),
                                           row_at(next[1], y, z),
                                           row_at(y > 0 ? self : next[2], y - 1, z),
                                           row_at(y < 7 ? self : next[3], y + 1, z),
                                           row_at(z > 0 ? self : next[4], y, z - 1),
                                           row_at(z < 7 ? self : next[5], y, z + 1)};
        std::uint32_t k = points.first_[c][chunk_row(y, z)];
        for_each_bit(used, [&](int bit) {
          move(origin + glm::ivec3(bit, y, z), bit, k, rows);
          ++k;
        });
      }
    }
  }

  // Returns the number of the point across a face.
  [[nodiscard]] std::uint32_t neighbor(std::size_t face, int bit, std::uint32_t k,
                                       const std::array<Row, kFaces>& rows) const {
    if (face == 0 && bit > 0) return k - 1;
    if (face == 1 && bit < 63) return k + 1;
    const Row& row = rows[face];
    const int place = face == 0 ? 63 : face == 1 ? 0 : bit;
    return row.first + static_cast<std::uint32_t>(count_bits(*row.used & bits_before(place)));
  }

  void move(const glm::ivec3& corner, int bit, std::uint32_t k, const std::array<Row, kFaces>& rows) const {
    glm::vec3 sum(0);
    float count = 0;
    const unsigned faces = joined[k];
    for (std::size_t face = 0; face < kFaces; ++face) {
      if ((faces >> face & 1) == 0) continue;
      sum += from[neighbor(face, bit, k, rows)] + glm::vec3(kFaceSteps[face]);
      ++count;
    }
    const glm::vec3 mean = sum / count;
    constexpr float kReach = 0.5F - kMargin;
    glm::vec3 place = glm::clamp(from[k] + step * (mean - from[k]), -kReach, kReach);
    for (int axis = 0; axis < 3; ++axis) {
      if (corner[axis] == bounds.min[axis] || corner[axis] == bounds.max[axis] + 1) place[axis] = 0;
    }
    to[k] = place;
  }
};

Result<void> NetPoints::relax(const LabelChunks& labels, std::uint64_t rounds, const Context& context,
                              const std::string& what) {
  std::fill(offsets_.begin(), offsets_.end(), glm::vec3(0));
  if (rounds == 0) return {};
  auto joined = TRY(make_reserved_buffer<std::uint8_t>(offsets_.size(), context, what));
  auto other = TRY(make_reserved_buffer<glm::vec3>(offsets_.size(), context, what));
  for_each_index(origins_.size(), [&](std::size_t c) {
    const NearLabels near(labels, origins_[c]);
    const NearRest rest(labels, near, origins_[c]);
    const std::array<NearChunks, 2> others = rest.near();
    for (int z = 0; z < 8; ++z) {
      for (int y = 0; y < 8; ++y) {
        const std::uint64_t used = used_[c][chunk_row(y, z)];
        if (used == 0) continue;
        FaceCounts counts;
        for (const NearLabels::Entry& entry : near.entries()) counts.add(corner_words(entry.near, y, z));
        for (const NearChunks& chunks : others) counts.add(corner_words(chunks, y, z));
        std::uint32_t k = first_[c][chunk_row(y, z)];
        for_each_bit(used, [&](int bit) { joined->values[k++] = counts.joined(bit); });
      }
    }
  });
  for (std::uint64_t round = 0; round < rounds; ++round) {
    for (const float step : {kForward, kBackward}) {
      TRY(context.check());
      const Moves moves{*this, labels.bounds(), joined->values, offsets_, other->values, step};
      for_each_index(origins_.size(), [&](std::size_t c) { moves.chunk(c); });
      std::swap(offsets_, other->values);
    }
    context.progress().advance(1);
  }
  return {};
}

glm::vec3 NetPoints::offset(const glm::ivec3& corner) const {
  const std::int32_t chunk = index_.find(chunk_origin(corner));
  if (chunk < 0) return glm::vec3(0);
  const std::size_t row = chunk_row(corner.y, corner.z);
  const int bit = corner.x & 63;
  const auto c = static_cast<std::size_t>(chunk);
  if ((used_[c][row] >> bit & 1) == 0) return glm::vec3(0);
  return offsets_[number(c, row, bit)];
}

const std::array<ChunkBits, 3>* NetPoints::middles(const glm::ivec3& origin) const {
  const std::int32_t chunk = index_.find(origin);
  if (chunk < 0) return nullptr;
  const std::int32_t found = middles_number_[static_cast<std::size_t>(chunk)];
  return found < 0 ? nullptr : &middles_[static_cast<std::size_t>(found)];
}

}  // namespace isoextract::extract
