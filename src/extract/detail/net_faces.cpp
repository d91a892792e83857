#include "extract/detail/net_faces.hpp"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "base/parallel.hpp"
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

// The sides for each pattern of corner_fans.hpp. A table, because GCC 12 (-O2 without assertions) compiles the
// comparison of the two voxels in join_shells() wrongly: faces with the label below them were not joined.
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

// A point owns the faces that have it as their lowest corner. Entry [axes][axis] is the number of own faces before the
// own face across `axis`; `axes` are the axes of all own faces.
constexpr std::array<std::array<std::uint8_t, 3>, 8> kFacesBefore{
    {{0, 0, 0}, {0, 1, 1}, {0, 0, 1}, {0, 1, 2}, {0, 0, 0}, {0, 1, 1}, {0, 0, 1}, {0, 1, 2}}};

// The index step from the place of a corner to the place of the lowest corner of each face around the corner.
constexpr std::array<int, kFacesAround> make_ways_down() {
  std::array<int, kFacesAround> ways{};
  for (unsigned f = 0; f < kFacesAround; ++f) {
    const unsigned axis = f / 4;
    if ((f & 1) == 0) ways[f] -= NearPlaces::kSteps[axis == 0 ? 1 : 0];
    if ((f & 2) == 0) ways[f] -= NearPlaces::kSteps[axis == 2 ? 1 : 2];
  }
  return ways;
}
constexpr std::array<int, kFacesAround> kWaysDown = make_ways_down();

}  // namespace

Result<NetFaces> NetFaces::make(const NetGrid& grid, const LabelChunks& labels, NetMemory& memory) {
  NetFaces faces;
  const Context& context = memory.context();
  faces.sides_ = TRY(memory.make<std::uint16_t>(grid.size()));
  faces.find_sides(grid, labels, memory);
  TRY(context.check());
  TRY(faces.number_faces(grid, memory));
  faces.mark_labeled(grid, labels, memory);
  TRY(context.check());
  TRY(memory.check());
  faces.join_shells(grid, labels, memory);
  TRY(context.check());
  TRY(faces.number_shells(memory));
  return faces;
}

void NetFaces::find_sides(const NetGrid& grid, const LabelChunks& labels, const NetMemory& memory) {
  memory.for_each_chunk(grid.origins().size(), [&](std::size_t c) {
    const NearLabels near(labels, grid.origins()[c]);
    grid.for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
      std::array<std::uint64_t, kFacesAround> differ{};
      near.for_each_in_row(y, z, [&](const NearLabels::Entry& /*entry*/, const CornerWords& words) {
        for (unsigned f = 0; f < kFacesAround; ++f) differ[f] |= words[voxel_below(f)] ^ words[voxel_above(f)];
      });
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        unsigned sides = 0;
        for (unsigned f = 0; f < kFacesAround; ++f) sides |= static_cast<unsigned>(differ[f] >> bit & 1) << f;
        sides_[k++] = static_cast<std::uint16_t>(sides);
      });
    });
  });
}

Result<void> NetFaces::number_faces(const NetGrid& grid, NetMemory& memory) {
  const std::size_t chunks = grid.origins().size();
  first_of_rows_ = TRY(memory.make<std::uint32_t>(64 * chunks + 1));
  memory.fill(first_of_rows_, std::uint32_t{0});
  memory.for_each_chunk(chunks, [&](std::size_t c) {
    grid.for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
      std::uint32_t& count = first_of_rows_[64 * c + chunk_row(y, z)];
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int) { count += static_cast<std::uint32_t>(count_bits(own_axes(k++))); });
    });
  });
  std::uint64_t all = 0;
  memory.for_each_run_of(first_of_rows_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      all += std::exchange(first_of_rows_[row], static_cast<std::uint32_t>(all));
    }
  });
  constexpr std::uint64_t kMost = ~std::uint32_t{0} / 4;
  if (all > kMost) {
    return fail(ErrorCode::input,
                memory.what() + ": there are " + std::to_string(all) + " faces between labels; the limit is " +
                    std::to_string(kMost),
                {Remedy::use, Setting::parts});
  }
  of_shells_ = TRY(memory.make<std::uint32_t>(2 * all));
  return memory.context().check();
}

// Makes each node a set of its own.
void NetFaces::mark_labeled(const NetGrid& grid, const LabelChunks& labels, const NetMemory& memory) {
  memory.for_each_chunk(grid.origins().size(), [&](std::size_t c) {
    const NearLabels near(labels, grid.origins()[c]);
    grid.for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
      CornerWords labeled{};
      near.for_each_in_row(y, z, [&](const NearLabels::Entry& /*entry*/, const CornerWords& words) {
        for (std::size_t n = 0; n < words.size(); ++n) labeled[n] |= words[n];
      });
      std::uint32_t node = 2 * first_of_row(c, chunk_row(y, z));
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        for_each_bit(sides_[k++] & kOwnFaces, [&](int own_face) {
          const auto f = static_cast<unsigned>(own_face);
          const bool below = (labeled[voxel_below(f)] >> bit & 1) != 0;
          const bool above = (labeled[voxel_above(f)] >> bit & 1) != 0;
          of_shells_[node] = below ? node : kNoShell;
          of_shells_[node + 1] = above ? node + 1 : kNoShell;
          node += 2;
        });
      });
    });
  });
}

// Joins the faces in each fan of each label around each point.
void NetFaces::join_shells(const NetGrid& grid, const LabelChunks& labels, const NetMemory& memory) {
  const DisjointSets sets(of_shells_.span());
  memory.for_each_chunk(grid.origins().size(), [&](std::size_t c) {
    const NearLabels near(labels, grid.origins()[c]);
    const NearFaces faces(grid, *this, c);
    grid.for_each_row(c, [&](const NetGrid::Row&, int y, int z) {
      near.for_each_in_row(y, z, [&](const NearLabels::Entry& /*entry*/, const CornerWords& words) {
        for_each_bit(mixed(words), [&](int bit) {
          const unsigned pattern = pattern_at(words, bit);
          const FaceSides& sides = kFaceSides[pattern];
          const int place = NearPlaces::of(bit, y, z);
          std::array<std::uint32_t, 4> first{kNoShell, kNoShell, kNoShell, kNoShell};
          for_each_bit(static_cast<unsigned>(sides.below | sides.above), [&](int f) {
            const std::uint32_t node = 2 * faces.number(place, f) + (sides.above >> f & 1);
            std::uint32_t& one = first[corner_fans()[pattern].of_face[static_cast<std::size_t>(f)]];
            if (one == kNoShell) {
              one = node;
            } else {
              sets.join(one, node);
            }
          });
        });
      });
    });
  });
}

// Numbers the shells by their first face.
Result<void> NetFaces::number_shells(const NetMemory& memory) {
  constexpr std::size_t kGrain = 1 << 13;
  const DisjointSets sets(of_shells_.span());
  std::size_t shells = 0;
  memory.for_each_run_of(of_shells_, [&](std::size_t first, std::size_t last) {
    shells += reduce_ranges(
        last - first, kGrain, std::size_t{0},
        [&](std::size_t begin, std::size_t end, std::size_t roots) {
          for (std::size_t i = first + begin; i != first + end; ++i) {
            const auto node = static_cast<std::uint32_t>(i);
            const std::uint32_t parent = sets.load(node);
            if (parent == kNoShell) continue;
            const std::uint32_t root = sets.root(parent);
            sets.store(node, root);
            roots += root == node ? 1 : 0;
          }
          return roots;
        },
        std::plus<>());
  });
  TRY(memory.context().check());
  auto held = TRY(memory.context().reserve(shells * sizeof(std::uint32_t), memory.what()));
  memory_.push_back(std::move(held));
  first_nodes_.reserve(shells);
  // Each parent, a root or not, is a lower node, so its number is known before its children need it.
  memory.for_each_run_of(of_shells_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t node = begin; node < end; ++node) {
      std::uint32_t& root = of_shells_[node];
      if (root == node) {
        root = static_cast<std::uint32_t>(first_nodes_.size());
        first_nodes_.push_back(static_cast<std::uint32_t>(node));
      } else if (root != kNoShell) {
        root = of_shells_[root];
      }
    }
  });
  return memory.context().check();
}

std::vector<LabelShells> NetFaces::count_shells(const NetGrid& grid, const LabelChunks& labels) const {
  constexpr std::size_t kGrain = 64;
  std::vector<std::int64_t> of_shells(first_nodes_.size());
  for_each_index(
      first_nodes_.size(),
      [&](std::size_t s) { of_shells[s] = labels.label_at(voxel_at(grid, first_nodes_[s])).value_or(0); }, kGrain);
  std::ranges::sort(of_shells);
  std::vector<LabelShells> counts;
  for (const std::int64_t label : of_shells) {
    if (counts.empty() || counts.back().label != label) counts.push_back({label, 0});
    ++counts.back().shells;
  }
  return counts;
}

// Returns the voxel of a node.
glm::ivec3 NetFaces::voxel_at(const NetGrid& grid, std::uint32_t node) const {
  const std::uint32_t face = node / 2;
  // Rows without faces have the same first face as the row after them.
  const auto after = std::ranges::upper_bound(first_of_rows_, face);
  const auto row_number = static_cast<std::size_t>(after - first_of_rows_.begin()) - 1;
  const std::size_t chunk = row_number / 64;
  const auto y = static_cast<int>(row_number % 8);
  const auto z = static_cast<int>(row_number % 64 / 8);
  const NetGrid::Row row = grid.row(static_cast<std::int32_t>(chunk), y, z);
  glm::ivec3 voxel(0);
  std::uint32_t number = first_of_rows_[row_number];
  std::uint32_t k = row.first;
  for_each_bit(row.used, [&](int bit) {
    for_each_bit(own_axes(k++), [&](int axis) {
      if (number++ != face) return;
      voxel = grid.origins()[chunk] + glm::ivec3(bit, y, z);
      if (node % 2 == 0) --voxel[axis];
    });
  });
  return voxel;
}

NearFaces::NearFaces(const NetGrid& grid, const NetFaces& faces, std::size_t chunk) {
  for (int n = 0; n < 4; ++n) {
    const int step_y = (n & 1) - 1;
    const int step_z = (n >> 1) - 1;
    const int place_of_lower = 3 * (step_y + 1) + 9 * (step_z + 1);
    const std::int32_t lower = grid.near(chunk)[static_cast<std::size_t>(place_of_lower)];
    const std::int32_t middle = grid.near(chunk)[static_cast<std::size_t>(place_of_lower) + 1];
    for (int z = step_z < 0 ? 7 : 0; z < 8; ++z) {
      for (int y = step_y < 0 ? 7 : 0; y < 8; ++y) {
        const int place = NearPlaces::of(0, y + 8 * step_y, z + 8 * step_z);
        if (const NetGrid::Row row = grid.row(lower, y, z); row.used >> 63 != 0) {
          const std::uint32_t last = row.number(63);
          const std::uint32_t end = faces.first_of_row(static_cast<std::size_t>(lower), chunk_row(y, z) + 1);
          put(faces, place - 1, last, end - static_cast<std::uint32_t>(count_bits(faces.own_axes(last))));
        }
        const NetGrid::Row row = grid.row(middle, y, z);
        if (row.used == 0) continue;
        std::uint32_t number = faces.first_of_row(static_cast<std::size_t>(middle), chunk_row(y, z));
        std::uint32_t k = row.first;
        for_each_bit(row.used, [&](int bit) {
          put(faces, place + bit, k, number);
          number += static_cast<std::uint32_t>(count_bits(faces.own_axes(k++)));
        });
      }
    }
  }
}

std::uint32_t NearFaces::number(int place, int side) const {
  const int near = place + kWaysDown[static_cast<std::size_t>(side)];
  const auto lowest = static_cast<std::size_t>(near);
  return first_[lowest] + kFacesBefore[axes_[lowest]][static_cast<std::size_t>(side / 4)];
}

}  // namespace isoextract::extract
