#include "extract/detail/net_relaxation.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "extract/detail/near_labels.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

// The part of the way to the mean of their neighbors that points move in the first half of a round. In the second half
// they move back by the same part of the way to the new mean. So a round removes steps between voxels, but wide parts
// keep their shape. It is a step down the gradient of the sum of squared distances from the means. The largest
// eigenvalue of that is 4, and the step must not exceed its inverse (a part of 1/2).
constexpr float kPart = 0.5F;

// The extrapolation between rounds. It makes n rounds as good as about n * n / 2 without it (Kim, Fessler: Optimized
// first-order methods for smooth convex minimization. 2016).
class Momentum {
 public:
  // Returns the position from which the next round starts. `start` and `end` are the last one's; `end_before`: that of
  // the one before.
  [[nodiscard]] glm::vec3 next_start(const glm::vec3& start, const glm::vec3& end, const glm::vec3& end_before) const {
    return end + (theta_ - 1) / next_ * (end - end_before) + theta_ / next_ * (end - start);
  }
  void advance() {
    theta_ = next_;
    next_ = after(theta_);
  }

 private:
  static float after(float theta) { return (1 + std::sqrt(1 + 4 * theta * theta)) / 2; }

  float theta_ = 1;
  float next_ = after(1);
};

// Cell faces are numbered 2 * axis, plus 1 for the upper side.
constexpr std::size_t kFaces = 6;

constexpr std::array<glm::ivec3, kFaces> kFaceSteps{glm::ivec3(-1, 0, 0), glm::ivec3(1, 0, 0),  glm::ivec3(0, -1, 0),
                                                    glm::ivec3(0, 1, 0),  glm::ivec3(0, 0, -1), glm::ivec3(0, 0, 1)};

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

// Three numbers and one that does not matter. The compiler adds all four at once.
using Float4 [[gnu::vector_size(16)]] = float;

// Reads a vector and the four bytes after it.
Float4 load(const void* vector) {
  Float4 loaded;
  std::memcpy(&loaded, vector, sizeof(loaded));
  return loaded;
}

// The sum of the steps to the neighbors across each set of faces, and their count as a factor.
struct Steps {
  glm::vec3 sum{0};  // first, for load()
  float share = 0;
  std::uint32_t count = 0;
};

constexpr std::array<Steps, 64> make_steps() {
  std::array<Steps, 64> all{};
  for (unsigned faces = 1; faces < 64; ++faces) {
    Steps& steps = all[faces];
    for (std::size_t face = 0; face < kFaces; ++face) {
      if ((faces >> face & 1) == 0) continue;
      steps.sum += glm::vec3(kFaceSteps[face]);
      ++steps.count;
    }
    steps.share = 1 / static_cast<float>(steps.count);
  }
  return all;
}
constexpr std::array<Steps, 64> kSteps = make_steps();

// The connections of the points.
class Links {
 public:
  static Result<Links> make(const NetGrid& grid, const LabelChunks& labels, const Context& context,
                            const std::string& what) {
    Links links(grid);
    const std::size_t chunks = grid.origins().size();
    auto held = TRY(context.reserve(2 * grid.size() + chunks * sizeof(std::uint64_t), what));
    links.memory_.push_back(std::move(held));
    links.joined_ = Buffer<std::uint8_t>(grid.size());
    links.fixed_ = Buffer<std::uint8_t>(grid.size());
    links.first_ = Buffer<std::uint64_t>(chunks);
    for_each_index(chunks, [&](std::size_t c) { links.find_joined(labels, c); });
    std::uint64_t count = 0;
    for (std::uint64_t& first : links.first_) count += std::exchange(first, count);
    held = TRY(context.reserve(count * sizeof(std::uint32_t), what));
    links.memory_.push_back(std::move(held));
    links.others_ = Buffer<std::uint32_t>(count);
    for_each_index(chunks, [&](std::size_t c) { links.list_others(c); });
    return links;
  }

  [[nodiscard]] unsigned fixed(std::size_t point) const { return fixed_[point]; }

  // Calls f(number, mean) for the points of a chunk, in order. The mean is that of the connected points, from the
  // point's corner. `offsets` has an element after that of the last point.
  template <class F>
  void for_each_mean(std::size_t chunk, const Buffer<glm::vec3>& offsets, const F& f) const {
    const std::uint32_t* other = others_.data() + first_[chunk];
    const auto [begin, end] = grid_.points(chunk);
    for (std::size_t k = begin; k != end; ++k) {
      const Steps& steps = kSteps[joined_[k]];
      Float4 sum = load(&steps);
      for (std::uint32_t n = 0; n < steps.count; ++n) sum += load(&offsets[*other++]);
      sum *= steps.share;
      f(k, glm::vec3(sum[0], sum[1], sum[2]));
    }
  }

 private:
  explicit Links(const NetGrid& grid) : grid_(grid) {}

  void find_joined(const LabelChunks& labels, std::size_t chunk) {
    const NearLabels near(labels, grid_.origins()[chunk]);
    const NearRest rest(labels, near, grid_.origins()[chunk]);
    const std::array<NearChunks, 2> others = rest.near();
    std::uint64_t count = 0;
    grid_.for_each_row(chunk, [&](const NetGrid::Row& row, int y, int z) {
      FaceCounts counts;
      for (const NearLabels::Entry& entry : near.entries()) counts.add(corner_words(entry.near, y, z));
      for (const NearChunks& chunks : others) counts.add(corner_words(chunks, y, z));
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        joined_[k] = counts.joined(bit);
        fixed_[k] =
            static_cast<std::uint8_t>(fixed_axes(grid_.origins()[chunk] + glm::ivec3(bit, y, z), labels.bounds()));
        count += kSteps[joined_[k++]].count;
      });
    });
    first_[chunk] = count;
  }

  void list_others(std::size_t chunk) {
    const glm::ivec3 origin = grid_.origins()[chunk];
    std::array<std::int32_t, kFaces> next{};
    for (std::size_t face = 0; face < kFaces; ++face) next[face] = grid_.find(origin + kFaceSteps[face] * kVoxelChunk);
    const auto self = static_cast<std::int32_t>(chunk);
    std::uint32_t* other = others_.data() + first_[chunk];
    grid_.for_each_row(chunk, [&](const NetGrid::Row& row, int y, int z) {
      const std::array<NetGrid::Row, kFaces> rows{grid_.row(next[0], y, z),
                                                  grid_.row(next[1], y, z),
                                                  grid_.row(y > 0 ? self : next[2], y - 1, z),
                                                  grid_.row(y < 7 ? self : next[3], y + 1, z),
                                                  grid_.row(z > 0 ? self : next[4], y, z - 1),
                                                  grid_.row(z < 7 ? self : next[5], y, z + 1)};
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        for_each_bit(joined_[k], [&](int face) { *other++ = neighbor(face, bit, k, rows); });
        ++k;
      });
    });
  }

  // Returns the number of the point across a face.
  static std::uint32_t neighbor(int face, int bit, std::uint32_t k, const std::array<NetGrid::Row, kFaces>& rows) {
    if (face == 0) return bit > 0 ? k - 1 : rows[0].number(63);
    if (face == 1) return bit < 63 ? k + 1 : rows[1].first;
    return rows[static_cast<std::size_t>(face)].number(bit);
  }

  const NetGrid& grid_;
  Buffer<std::uint8_t> joined_;  // of each point: the faces that lead to connected points, as bits
  Buffer<std::uint8_t> fixed_;   // of each point: the axes along which it does not move
  Buffer<std::uint64_t> first_;  // of each chunk, in others_
  Buffer<std::uint32_t> others_;
  std::vector<Reservation> memory_;
};

}  // namespace

Result<void> relax_net(const NetGrid& grid, const LabelChunks& labels, std::uint64_t rounds, Buffer<glm::vec3>& offsets,
                       const Context& context, const std::string& what) {
  if (rounds == 0) return {};
  const Links links = TRY(Links::make(grid, labels, context, what));
  auto start_memory = TRY(make_reserved_buffer<glm::vec3>(grid.size() + 1, context, what));
  auto half_memory = TRY(make_reserved_buffer<glm::vec3>(grid.size() + 1, context, what));
  Buffer<glm::vec3>& start = start_memory->values;
  Buffer<glm::vec3>& half = half_memory->values;
  std::copy(offsets.begin(), offsets.end(), start.begin());
  start[grid.size()] = half[grid.size()] = glm::vec3(0);
  Momentum momentum;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    TRY(context.check());
    for_each_index(grid.origins().size(), [&](std::size_t c) {
      links.for_each_mean(c, start, [&](std::size_t k, const glm::vec3& mean) {
        half[k] = without_axes(start[k] + kPart * (mean - start[k]), links.fixed(k));
      });
    });
    for_each_index(grid.origins().size(), [&](std::size_t c) {
      links.for_each_mean(c, half, [&](std::size_t k, const glm::vec3& mean) {
        const glm::vec3 end = offset_within_cell(half[k] - kPart * (mean - half[k]), links.fixed(k));
        start[k] = momentum.next_start(start[k], end, offsets[k]);
        offsets[k] = end;
      });
    });
    momentum.advance();
    context.progress().advance(1);
  }
  return {};
}

}  // namespace isoextract::extract
