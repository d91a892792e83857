#include "extract/detail/net_faces.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "extract/detail/corner_fans.hpp"
#include "extract/detail/near_labels.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

// The faces across an axis extend along the next two axes, so that their normal is the axis.
constexpr int next_axis(int axis, int steps) { return (axis + steps) % 3; }

// Returns the number (corner_fans.hpp) of the face across `axis` at one of its corners: `u` and `v` steps from its
// lowest corner along the next two axes.
constexpr unsigned face_at_corner(int axis, int u, int v) {
  const bool is_u_lower = next_axis(axis, 1) < next_axis(axis, 2);
  const int lower = 1 - (is_u_lower ? u : v);
  const int higher = 1 - (is_u_lower ? v : u);
  return static_cast<unsigned>(axis * 4 + (lower | higher << 1));
}

// Returns the voxel on the lower side of a face around a corner.
constexpr std::size_t voxel_below(unsigned face) {
  const unsigned axis = face / 4;
  const unsigned lower = axis == 0 ? 1 : 0;
  const unsigned higher = axis == 2 ? 1 : 2;
  return (face & 1) << lower | (face >> 1 & 1) << higher;
}

constexpr std::size_t voxel_above(unsigned face) { return voxel_below(face) | std::size_t{1} << face / 4; }

constexpr unsigned kFacesAround = 12;

// The faces around a corner between voxels inside and outside, as bits: the voxel below or above the face is inside.
struct FaceSides {
  std::uint16_t below = 0;
  std::uint16_t above = 0;
};

// Of each pattern of corner_fans.hpp. A table, because GCC 12 (-O2 without assertions) compiles the comparison of the two
// voxels in join_shells() wrongly: faces with the label below them were not joined.
constexpr std::array<FaceSides, 256> make_face_sides() {
  std::array<FaceSides, 256> all{};
  for (unsigned pattern = 0; pattern < 256; ++pattern) {
    for (unsigned f = 0; f < kFacesAround; ++f) {
      const unsigned below = pattern >> voxel_below(f) & 1;
      const unsigned above = pattern >> voxel_above(f) & 1;
      if (below > above) all[pattern].below |= static_cast<std::uint16_t>(1U << f);
      if (above > below) all[pattern].above |= static_cast<std::uint16_t>(1U << f);
    }
  }
  return all;
}
constexpr std::array<FaceSides, 256> kFaceSides = make_face_sides();

// The faces that have the corner as their lowest one.
constexpr std::uint16_t kOwnFaces =
    1U << face_at_corner(0, 0, 0) | 1U << face_at_corner(1, 0, 0) | 1U << face_at_corner(2, 0, 0);

constexpr std::array<std::array<int, 2>, 4> kCornerSteps{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

// The numbers of the points up to one step above the corners of a chunk.
class UpperPoints {
 public:
  UpperPoints(const NetGrid& grid, std::size_t chunk) : grid_(grid) {
    for (int n = 0; n < 8; ++n) next_[static_cast<std::size_t>(n)] = grid.find(grid.origins()[chunk] + chunk_step(n));
  }

  // Returns the number of the point at a corner that has one, from the lowest corner of the chunk.
  [[nodiscard]] std::uint32_t number(const glm::ivec3& corner) const {
    const unsigned chunk = static_cast<unsigned>(corner.x >> 6 | corner.y >> 3 << 1 | corner.z >> 3 << 2);
    return grid_.row(next_[chunk], corner.y, corner.z).number(corner.x & 63);
  }

 private:
  const NetGrid& grid_;
  std::array<std::int32_t, 8> next_{};
};

// Sets of nodes, joined from several threads (Anderson, Woll: Wait-free parallel algorithms for the union-find problem.
// 1991). The root of a set is its lowest node, so the result does not depend on the order.
class JoinedSets {
 public:
  explicit JoinedSets(Buffer<std::uint32_t>& parent) : parent_(parent) {}

  std::uint32_t root(std::uint32_t node) const {
    for (;;) {
      const std::uint32_t above = at(node).load(std::memory_order_relaxed);
      if (above == node) return node;
      const std::uint32_t next = at(above).load(std::memory_order_relaxed);
      std::uint32_t expected = above;
      if (next != above) at(node).compare_exchange_weak(expected, next, std::memory_order_relaxed);
      node = above;
    }
  }

  void join(std::uint32_t a, std::uint32_t b) const {
    for (;;) {
      a = root(a);
      b = root(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      std::uint32_t expected = a;
      if (at(a).compare_exchange_strong(expected, b, std::memory_order_relaxed)) return;
    }
  }

 private:
  [[nodiscard]] std::atomic_ref<std::uint32_t> at(std::uint32_t node) const {
    return std::atomic_ref<std::uint32_t>(parent_[node]);
  }

  Buffer<std::uint32_t>& parent_;
};

}  // namespace

Result<NetFaces> NetFaces::make(const NetGrid& grid, const LabelChunks& labels, const Context& context,
                                const std::string& what) {
  NetFaces faces;
  auto held = TRY(context.reserve(grid.size() * (sizeof(std::uint16_t) + sizeof(std::uint32_t)) +
                                      (grid.origins().size() + 2) * sizeof(std::uint32_t),
                                  what));
  faces.memory_.push_back(std::move(held));
  faces.find_sides(grid, labels);
  TRY(context.check());
  TRY(faces.list_faces(grid, labels, context, what));
  TRY(context.check());
  TRY(faces.join_shells(grid, labels, context, what));
  faces.sides_ = Buffer<std::uint16_t>();
  return faces;
}

void NetFaces::find_sides(const NetGrid& grid, const LabelChunks& labels) {
  sides_ = Buffer<std::uint16_t>(grid.size());
  for_each_index(grid.origins().size(), [&](std::size_t c) {
    const NearLabels near(labels, grid.origins()[c]);
    grid.for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
      std::array<std::uint64_t, kFacesAround> differ{};
      for (const NearLabels::Entry& entry : near.entries()) {
        const CornerWords words = corner_words(entry.near, y, z);
        for (unsigned f = 0; f < kFacesAround; ++f) differ[f] |= words[voxel_below(f)] ^ words[voxel_above(f)];
      }
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        unsigned sides = 0;
        for (unsigned f = 0; f < kFacesAround; ++f) sides |= static_cast<unsigned>(differ[f] >> bit & 1) << f;
        sides_[k++] = static_cast<std::uint16_t>(sides);
      });
    });
  });
}

Result<void> NetFaces::list_faces(const NetGrid& grid, const LabelChunks& labels, const Context& context,
                                  const std::string& what) {
  const std::size_t chunks = grid.origins().size();
  first_around_ = Buffer<std::uint32_t>(grid.size() + 1);
  first_of_chunk_ = Buffer<std::uint32_t>(chunks);
  struct Counts {
    std::uint64_t around = 0;
    std::uint64_t own = 0;
  };
  auto made = TRY(make_reserved_buffer<Counts>(chunks, context, what));
  Buffer<Counts>& before = made->values;
  const auto add = [&](Counts& counts, std::size_t k) {
    counts.around += static_cast<std::uint64_t>(std::popcount(sides_[k]));
    counts.own += static_cast<std::uint64_t>(std::popcount(static_cast<std::uint16_t>(sides_[k] & kOwnFaces)));
  };
  for_each_index(chunks, [&](std::size_t c) {
    Counts counts;
    const auto [begin, end] = grid.points(c);
    for (std::size_t k = begin; k != end; ++k) add(counts, k);
    before[c] = counts;
  });
  Counts all;
  for (Counts& counts : before) {
    const Counts here = std::exchange(counts, all);
    all.around += here.around;
    all.own += here.own;
  }
  constexpr std::uint64_t kMost = ~std::uint32_t{0} / 4;
  if (all.own > kMost) {
    return fail(ErrorCode::input,
                what + ": there are " + std::to_string(all.own) + " faces between labels; the limit is " +
                    std::to_string(kMost),
                {Remedy::use, Setting::parts});
  }
  auto held = TRY(context.reserve(all.own * (sizeof(Face) + 1) + all.around * sizeof(std::uint32_t), what));
  memory_.push_back(std::move(held));
  faces_ = Buffer<Face>(all.own);
  axes_ = Buffer<std::uint8_t>(all.own);
  around_ = Buffer<std::uint32_t>(all.around);
  for_each_index(chunks, [&](std::size_t c) {
    Counts counts = before[c];
    first_of_chunk_[c] = static_cast<std::uint32_t>(counts.own);
    const auto [begin, end] = grid.points(c);
    for (std::size_t k = begin; k != end; ++k) {
      first_around_[k] = static_cast<std::uint32_t>(counts.around);
      add(counts, k);
    }
  });
  first_around_[grid.size()] = static_cast<std::uint32_t>(all.around);
  for_each_index(chunks, [&](std::size_t c) {
    const NearLabels near(labels, grid.origins()[c]);
    const UpperPoints points(grid, c);
    std::uint32_t number = first_of_chunk_[c];
    grid.for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
      CornerWords labeled{};
      for (const NearLabels::Entry& entry : near.entries()) {
        const CornerWords words = corner_words(entry.near, y, z);
        for (std::size_t n = 0; n < words.size(); ++n) labeled[n] |= words[n];
      }
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        for_each_bit(sides_[k] & kOwnFaces, [&](int own_face) {
          const int axis = own_face / 4;
          axes_[number] = static_cast<std::uint8_t>(axis);
          Face& face = faces_[number];
          for (std::size_t n = 0; n < 4; ++n) {
            const auto& [u, v] = kCornerSteps[n];
            glm::ivec3 corner(bit, y, z);
            corner[next_axis(axis, 1)] += u;
            corner[next_axis(axis, 2)] += v;
            const std::uint32_t point = n == 0 ? k : points.number(corner);
            const unsigned lower = (1U << face_at_corner(axis, u, v)) - 1;
            around_[first_around_[point] + static_cast<std::uint32_t>(std::popcount(sides_[point] & lower))] = number;
            face.points[n] = point;
          }
          const auto f = static_cast<unsigned>(own_face);
          for (std::uint32_t side = 0; side < 2; ++side) {
            const std::size_t voxel = side == 0 ? voxel_below(f) : voxel_above(f);
            face.shells[side] = (labeled[voxel] >> bit & 1) != 0 ? 2 * number + side : kNoShell;
          }
          ++number;
        });
        ++k;
      });
    });
  });
  return {};
}

// Joins the faces in each fan of each label around each point, then numbers the shells by their first face.
Result<void> NetFaces::join_shells(const NetGrid& grid, const LabelChunks& labels, const Context& context,
                                   const std::string& what) {
  auto memory = TRY(make_reserved_buffer<std::uint32_t>(2 * faces_.size(), context, what));
  Buffer<std::uint32_t>& parent = memory->values;
  constexpr std::size_t kGrain = 1 << 12;
  for_each_index(
      faces_.size(),
      [&](std::size_t f) {
        parent[2 * f] = faces_[f].shells[0];
        parent[2 * f + 1] = faces_[f].shells[1];
      },
      kGrain);
  const JoinedSets sets(parent);
  for_each_index(grid.origins().size(), [&](std::size_t c) {
    const NearLabels near(labels, grid.origins()[c]);
    grid.for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
      for (const NearLabels::Entry& entry : near.entries()) {
        const CornerWords words = corner_words(entry.near, y, z);
        for_each_bit(mixed(words), [&](int bit) {
          const unsigned pattern = pattern_at(words, bit);
          const std::uint32_t k = row.number(bit);
          const std::uint32_t* list = around_.data() + first_around_[k];
          std::array<std::uint32_t, 4> first{kNoShell, kNoShell, kNoShell, kNoShell};
          for_each_bit(sides_[k], [&](int f) {
            const std::uint32_t face = *list++;
            const FaceSides& around = kFaceSides[pattern];
            if (((around.below | around.above) >> f & 1) == 0) return;
            const std::uint32_t node = 2 * face + (around.above >> f & 1);
            std::uint32_t& one = first[corner_fans()[pattern].of_face[static_cast<std::size_t>(f)]];
            if (one == kNoShell) {
              one = node;
            } else {
              sets.join(one, node);
            }
          });
        });
      }
    });
  });
  for (std::uint32_t node = 0; node < parent.size(); ++node) {
    if (parent[node] == node) faces_[node / 2].shells[node & 1] = shells_++;
  }
  for_each_index(
      parent.size(),
      [&](std::size_t n) {
        if (parent[n] == kNoShell || parent[n] == n) return;
        const std::uint32_t root = sets.root(static_cast<std::uint32_t>(n));
        faces_[n / 2].shells[n & 1] = faces_[root / 2].shells[root & 1];
      },
      kGrain);
  return context.check();
}

}  // namespace isoextract::extract
