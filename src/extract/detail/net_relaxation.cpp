#include "extract/detail/net_relaxation.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "base/parallel.hpp"
#include "extract/detail/float4.hpp"
#include "extract/detail/near_labels.hpp"
#include "extract/detail/near_points.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

// The fraction of the way to the mean of its neighbors that a point moves in the first half of a round. In the second
// half, the point moves away from the new mean by the same fraction. So a round removes steps between voxels, but wide
// parts keep their shape. A round is a step down the gradient of the sum of squared distances from the means. The
// largest eigenvalue of this gradient is 4, and the step must not exceed the inverse (a fraction of 1/2).
constexpr float kPart = 0.5F;

// Factors for each set of axes: 0 for the axes in the set, 1 for the other axes.
constexpr std::array<Float4, 8> make_free_axes() {
  std::array<Float4, 8> all{};
  for (unsigned axes = 0; axes < 8; ++axes) {
    all[axes] = Float4{(axes & 1) != 0 ? 0.0F : 1.0F, (axes & 2) != 0 ? 0.0F : 1.0F, (axes & 4) != 0 ? 0.0F : 1.0F, 1};
  }
  return all;
}
constexpr std::array<Float4, 8> kFreeAxes = make_free_axes();

// The extrapolation between rounds. It makes n rounds as good as about n * n / 2 without it (Kim, Fessler: Optimized
// first-order methods for smooth convex minimization. 2016).
class Momentum {
 public:
  // Returns the position from which the next round starts. `start` and `end` belong to the last round; `end_before` is
  // the end of the round before it.
  [[nodiscard]] Float4 next_start(Float4 start, Float4 end, Float4 end_before) const {
    return end + of_ends_ * (end - end_before) + of_round_ * (end - start);
  }
  void advance() {
    const float next = after(next_);
    of_ends_ = (next_ - 1) / next;
    of_round_ = next_ / next;
    next_ = next;
  }

 private:
  static float after(float theta) { return (1 + std::sqrt(1 + 4 * theta * theta)) / 2; }

  float next_ = after(1);
  float of_ends_ = 0;
  float of_round_ = 1 / next_;
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

  // Returns the faces, as bits, through which the point of a cell is connected with other points. These are the faces
  // with three labels if there are at least two (a curve needs two ends), else the faces with two labels.
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

// The sum of the steps to the neighbors across a set of faces, and the inverse of their count.
struct Steps {
  glm::vec3 sum{0};  // first, for load()
  float share = 0;
  std::array<Int4, kFaces> joined{};  // all bits set for faces in the set, else 0
};

constexpr std::array<Steps, 64> make_steps() {
  std::array<Steps, 64> all{};
  for (unsigned faces = 1; faces < 64; ++faces) {
    Steps& steps = all[faces];
    int count = 0;
    for (std::size_t face = 0; face < kFaces; ++face) {
      if ((faces >> face & 1) == 0) continue;
      steps.sum += glm::vec3(kFaceSteps[face]);
      steps.joined[face] = Int4{-1, -1, -1, -1};
      ++count;
    }
    steps.share = 1 / static_cast<float>(count);
  }
  return all;
}
constexpr std::array<Steps, 64> kSteps = make_steps();

// The connections of the points.
class Links {
 public:
  static Result<Links> make(const NetGrid& grid, const LabelChunks& labels, NetMemory& memory) {
    Links links(grid, labels.bounds());
    links.joined_ = TRY(memory.make<std::uint8_t>(grid.size()));
    memory.for_each_chunk(grid.origins().size(), [&](std::size_t c) { links.find_joined(labels, c); });
    return links;
  }

  // Calls f(number, mean, free axes) for the points of a chunk, in order. The mean is the mean of the connected points,
  // relative to the point's corner. `offsets` has one element more than there are points.
  template <class F>
  void for_each_mean(std::size_t chunk, const NetArray<glm::vec3>& offsets, const F& f) const {
    // Index steps to the neighbors within a plane of places (NearPointPlanes).
    constexpr std::array<int, kFaces> kWays{
        -NearPlaces::kSteps[0], NearPlaces::kSteps[0], -NearPlaces::kSteps[1], NearPlaces::kSteps[1], 0, 0};
    // A copy at places is faster to read than the list of points: the neighbors of a point are at fixed distances.
    // Three planes of it stay in the fastest cache, if each place has three numbers only. The fourth that is copied
    // belongs to the next place, which is copied later.
    std::array<std::array<glm::vec3, NearPlaces::kSteps[2] + 1>, 3> planes;
    const auto plane_at = [&](int z) { return planes[static_cast<std::size_t>(z + 1) % planes.size()].data(); };
    const NearPointPlanes points(grid_, chunk);
    const auto copy_plane = [&](int z) {
      glm::vec3* const plane = plane_at(z);
      points.for_each(z, [&](int place, std::uint32_t k) { std::memcpy(plane + place, &offsets[k], sizeof(Int4)); });
    };
    copy_plane(-1);
    copy_plane(0);
    for (int z = 0; z < 8; ++z) {
      copy_plane(z + 1);
      const std::array<const glm::vec3*, kFaces> near{plane_at(z), plane_at(z),     plane_at(z),
                                                      plane_at(z), plane_at(z - 1), plane_at(z + 1)};
      for (int y = 0; y < 8; ++y) {
        const NetGrid::Row row = grid_.row(static_cast<std::int32_t>(chunk), y, z);
        if (row.used == 0) continue;
        const RowFixedAxes fixed(grid_.origins()[chunk] + glm::ivec3(0, y, z), bounds_);
        const int place = NearPlaces::of(0, y, -1);
        std::uint32_t k = row.first;
        for_each_bit(row.used, [&](int bit) {
          const Steps& steps = kSteps[joined_[k]];
          Float4 sum = load(&steps);
          // A sum over all six faces is faster than a loop over the connected faces: the processor cannot predict their
          // number.
          for (std::size_t face = 0; face < kFaces; ++face) {
            const Float4 offset = load(near[face] + (place + bit + kWays[face]));
            sum += std::bit_cast<Float4>(std::bit_cast<Int4>(offset) & steps.joined[face]);
          }
          sum *= steps.share;
          f(k, sum, kFreeAxes[fixed.at(bit)]);
          ++k;
        });
      }
    }
  }

 private:
  Links(const NetGrid& grid, const field::IndexBox& bounds) : grid_(grid), bounds_(bounds) {}

  void find_joined(const LabelChunks& labels, std::size_t chunk) {
    const NearLabels near(labels, grid_.origins()[chunk]);
    const NearRest rest(labels, near, grid_.origins()[chunk]);
    const std::array<NearChunks, 2> others = rest.near();
    grid_.for_each_row(chunk, [&](const NetGrid::Row& row, int y, int z) {
      FaceCounts counts;
      near.for_each_in_row(y, z,
                           [&](const NearLabels::Entry& /*entry*/, const CornerWords& words) { counts.add(words); });
      for (const NearChunks& chunks : others) counts.add(corner_words(chunks, y, z));
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) { joined_[k++] = counts.joined(bit); });
    });
  }

  const NetGrid& grid_;
  field::IndexBox bounds_;
  NetArray<std::uint8_t> joined_;  // of each point: the faces that lead to connected points, as bits
};

}  // namespace

Result<void> relax_net(const NetGrid& grid, const LabelChunks& labels, std::uint64_t rounds,
                       NetArray<glm::vec3>& offsets, NetMemory& memory) {
  if (rounds == 0) return {};
  const Context& context = memory.context();
  const Links links = TRY(Links::make(grid, labels, memory));
  NetArray<glm::vec3> start = TRY(memory.make<glm::vec3>(grid.size() + 1));
  NetArray<glm::vec3> half = TRY(memory.make<glm::vec3>(grid.size() + 1));
  memory.fill(start, glm::vec3(0));  // like `offsets`
  half[grid.size()] = glm::vec3(0);
  Momentum momentum;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    TRY(context.check());
    memory.for_each_chunk(grid.origins().size(), [&](std::size_t c) {
      links.for_each_mean(c, start, [&](std::size_t k, Float4 mean, Float4 free_axes) {
        const Float4 from = load(&start[k]);
        store(half[k], (from + kPart * (mean - from)) * free_axes);
      });
    });
    memory.for_each_chunk(grid.origins().size(), [&](std::size_t c) {
      links.for_each_mean(c, half, [&](std::size_t k, Float4 mean, Float4 free_axes) {
        const Float4 from = load(&half[k]);
        const Float4 end = clamp((from - kPart * (mean - from)) * free_axes, kNetReach);
        store(start[k], momentum.next_start(load(&start[k]), end, load(&offsets[k])));
        store(offsets[k], end);
      });
    });
    momentum.advance();
    context.progress().advance(1);
  }
  return {};
}

}  // namespace isoextract::extract
