#include "volume_io/vdb/vdb_tree.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

#include <fmt/format.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include "base/buffer.hpp"

namespace isoextract::volume_io {
namespace {

constexpr int kLeafSize = field::SparseBlock::kSize;
constexpr int kLowerSize = 16 * kLeafSize;
constexpr int kUpperSize = 32 * kLowerSize;
constexpr std::size_t kLeafValues = 512;
constexpr std::size_t kLeafMaskBytes = kLeafValues / 8;

using LeafMask = std::array<std::uint64_t, 8>;

auto by_place(const glm::ivec3& v) { return std::tuple(v.x, v.y, v.z); }

// Calls use(i) for each set bit in ascending order.
template <std::size_t Words, class F>
void for_each_bit(const std::array<std::uint64_t, Words>& mask, F&& use) {
  for (std::size_t word = 0; word < Words; ++word) {
    for (std::uint64_t bits = mask[word]; bits != 0; bits &= bits - 1) {
      use(static_cast<int>(64 * word) + std::countr_zero(bits));
    }
  }
}

template <std::size_t Words>
std::array<std::uint64_t, Words> mask_words(std::span<const std::byte> mask) {
  std::array<std::uint64_t, Words> words;
  std::memcpy(words.data(), mask.data(), sizeof words);
  return words;
}

// Returns the box of the set bits; at least one must be set.
field::IndexBox box_of(const LeafMask& mask) {
  field::IndexBox box{glm::ivec3(kLeafSize), glm::ivec3(0)};
  std::uint64_t rows = 0;  // bit y * 8 + z
  for (int x = 0; x < kLeafSize; ++x) {
    const std::uint64_t word = mask[static_cast<std::size_t>(x)];
    if (word == 0) continue;
    box.min.x = std::min(box.min.x, x);
    box.max.x = x;
    rows |= word;
  }
  box.min.y = std::countr_zero(rows) / 8;
  box.max.y = 7 - std::countl_zero(rows) / 8;
  rows |= rows >> 32;
  rows |= rows >> 16;
  rows |= rows >> 8;
  const auto columns = static_cast<std::uint8_t>(rows);
  box.min.z = std::countr_zero(columns);
  box.max.z = 7 - std::countl_zero(columns);
  return box;
}

template <class Value>
class TopologyReader {
 public:
  TopologyReader(VdbCursor& cursor, const VdbValueLayout& layout, const VdbTreeLimits& limits)
      : cursor_(cursor), layout_(layout), limits_(limits) {}

  VdbTopology read() {
    const auto buffers = cursor_.read_value<std::int32_t>();
    if (buffers != 1) throw InvalidVdb(fmt::format("expected one buffer in a tree, found {}", buffers));
    background_ = cursor_.read_value<Value>();
    samples_.type = field::sample_type_of<Value>();
    samples_.background = static_cast<double>(background_);
    const auto tiles = cursor_.read_value<std::uint32_t>();
    const auto children = cursor_.read_value<std::uint32_t>();
    for (std::uint32_t i = 0; i < tiles; ++i) {
      const glm::ivec3 origin = read_root_place();
      const auto value = cursor_.read_value<Value>();
      const auto active = cursor_.read_value<std::uint8_t>();
      if (active > 1) throw InvalidVdb(fmt::format("expected 0 or 1 as the active flag of a tile, found {}", active));
      if (active == 1) {
        check_range(origin);
        count_tile(origin, kUpperSize);
      }
      add_tile(origin, kUpperSize, value);
    }
    for (std::uint32_t i = 0; i < children; ++i) {
      const glm::ivec3 origin = read_root_place();
      check_range(origin);
      check_order(i == 0 ? origin : root_places_[root_places_.size() - 2], origin);
      read_node<32, kLowerSize>(origin);
    }
    std::ranges::sort(root_places_, {}, by_place);
    if (const auto twice = std::ranges::adjacent_find(root_places_); twice != root_places_.end()) {
      throw InvalidVdb(fmt::format("expected one node or tile at each position, found two at ({}, {}, {})", twice->x,
                                   twice->y, twice->z));
    }
    return std::move(topology_);
  }

 private:
  // Validates the position: iterators rely on multiples of the node size.
  glm::ivec3 read_root_place() {
    const auto place = cursor_.read_value<glm::ivec3>();
    for (int axis = 0; axis < 3; ++axis) {
      if (place[axis] % kUpperSize == 0) continue;
      throw InvalidVdb(
          fmt::format("expected nodes and tiles at multiples of {} voxels, found one at index {} along axis {}",
                      kUpperSize, place[axis], axis));
    }
    root_places_.push_back(place);
    return place;
  }

  // Leaf values are stored in the order of positions, so all nodes must be in that order.
  static void check_order(const glm::ivec3& before, const glm::ivec3& origin) {
    if (by_place(before) <= by_place(origin)) return;
    throw InvalidVdb(
        fmt::format("expected nodes in the order of their positions, found ({}, {}, {}) after ({}, {}, {})", origin.x,
                    origin.y, origin.z, before.x, before.y, before.z));
  }

  // Leaves room for one more voxel on every side.
  static void check_range(const glm::ivec3& origin) {
    for (int axis = 0; axis < 3; ++axis) {
      if (origin[axis] >= -field::kMaxSparseIndex && origin[axis] < field::kMaxSparseIndex) continue;
      throw UnsupportedVdb(
          fmt::format("expected voxel indices from -2^29 to 2^29 - 1 along {}, found {}", "xyz"[axis], origin[axis]));
    }
  }

  // Reads a node of kSide^3 entries, each a tile or a child with kChildSize voxels per side.
  template <int kSide, int kChildSize>
  void read_node(const glm::ivec3& origin) {
    constexpr std::size_t kEntries = std::size_t{kSide} * kSide * kSide;
    constexpr std::size_t kWords = kEntries / 64;
    cursor_.prepare(2 * kEntries / 8 + max_packed_bytes(kEntries, layout_.value_size));
    const auto child_bytes = cursor_.take(kEntries / 8);
    const auto active_bytes = cursor_.take(kEntries / 8);
    const auto children = mask_words<kWords>(child_bytes);
    const auto active = mask_words<kWords>(active_bytes);
    values_.resize(kEntries);
    unpack_values<Value>(take_values(cursor_, active_bytes, layout_), layout_, background_, values_);

    const auto place = [&](int i) {
      return origin + kChildSize * glm::ivec3(i / (kSide * kSide), i / kSide % kSide, i % kSide);
    };
    // topologyUnion() of OpenVDB 3.0 left entries that are both active tiles and children. They are children here, and
    // the values stored for them are ignored. So active voxel counts can differ from OpenVDB's.
    std::array<std::uint64_t, kWords> tiles;
    std::array<std::uint64_t, kWords> active_tiles;
    for (std::size_t word = 0; word < kWords; ++word) {
      tiles[word] = ~children[word];
      active_tiles[word] = active[word] & ~children[word];
    }
    for_each_bit(active_tiles, [&](int i) { count_tile(place(i), kChildSize); });
    for_each_bit(tiles, [&](int i) { add_tile(place(i), kChildSize, values_[static_cast<std::size_t>(i)]); });
    for_each_bit(children, [&](int i) {
      if constexpr (kChildSize == kLeafSize) {
        add_leaf(place(i));
      } else {
        read_node<16, kLeafSize>(place(i));
      }
    });
  }

  void add_leaf(const glm::ivec3& origin) {
    const auto mask = cursor_.read_value<LeafMask>();
    make_room(samples_.blocks, topology_.blocks_memory);
    make_room(topology_.masks, topology_.masks_memory);
    samples_.blocks.push_back({origin});
    topology_.masks.push_back(mask);
    int on = 0;
    for (const std::uint64_t word : mask) on += std::popcount(word);
    samples_.active_voxels += static_cast<std::uint64_t>(on);
    if (on == 0) return;
    const field::IndexBox box = box_of(mask);
    expand_box({origin + box.min, origin + box.max});
  }

  void count_tile(const glm::ivec3& origin, int size) {
    const auto side = static_cast<std::uint64_t>(size);
    samples_.active_voxels += side * side * side;
    expand_box({origin, origin + (size - 1)});
  }

  void add_tile(const glm::ivec3& origin, int size, Value value) {
    const bool both_nan = value != value && background_ != background_;
    if (value == background_ || both_nan) return;
    check_range(origin);
    make_room(samples_.tiles, topology_.tiles_memory);
    samples_.tiles.push_back({origin, size, static_cast<double>(value)});
  }

  void expand_box(const field::IndexBox& box) {
    field::IndexBox& whole = samples_.active_box;
    whole = whole.empty() ? box : field::IndexBox{glm::min(whole.min, box.min), glm::max(whole.max, box.max)};
  }

  // Makes room for one more element. A few bytes in a file can describe many tiles, so growth is reserved first, in
  // addition to the existing list.
  template <class T>
  void make_room(std::vector<T>& list, Reservation& memory) const {
    if (list.size() < list.capacity()) return;
    constexpr std::size_t kFirst = 16;
    const std::size_t capacity = std::max(kFirst, list.size() + list.size() / 2);
    auto grown = limits_.context.reserve(
        capacity * sizeof(T), fmt::format("{}: the tiles and nodes of grid '{}'", limits_.file, limits_.grid));
    if (!grown) throw VdbReadError(grown.error());
    list.reserve(capacity);
    memory = std::move(*grown);
  }

  VdbCursor& cursor_;
  const VdbValueLayout& layout_;
  const VdbTreeLimits& limits_;
  Value background_{};
  VdbTopology topology_;
  field::SparseSamples& samples_ = topology_.samples;
  std::vector<glm::ivec3> root_places_;
  std::vector<Value> values_;  // of the current node
};

// Owns the values of a grid's samples, with their reservations.
template <class Value>
struct TreeMemory {
  Buffer<Value> values;
  Reservation values_memory;
  Reservation blocks_memory;
  Reservation tiles_memory;
};

// Consecutive leaves in one window of the file.
struct LeafRun {
  std::shared_ptr<const std::byte[]> window;  // keeps alive the data of the leaves
  std::size_t first = 0;
  std::vector<VdbPackedValues> leaves;
};

template <class Value>
LeafRun take_run(VdbCursor& cursor, const VdbValueLayout& layout, const std::vector<LeafMask>& masks,
                 std::size_t first) {
  const std::uint64_t longest = kLeafMaskBytes + max_packed_bytes(kLeafValues, sizeof(Value));
  cursor.prepare(longest);
  LeafRun run{cursor.window(), first, {}};
  for (std::size_t i = first; i < masks.size() && cursor.is_prepared(longest); ++i) {
    const auto active = cursor.take(kLeafMaskBytes);
    if (mask_words<8>(active) != masks[i]) {
      throw InvalidVdb(
          fmt::format("the mask of active voxels of the leaf at byte {} differs from its mask in the tree's topology",
                      cursor.position() - kLeafMaskBytes));
    }
    run.leaves.push_back(take_values(cursor, active, layout));
  }
  return run;
}

}  // namespace

template <class Value>
VdbTopology read_vdb_topology(VdbCursor& cursor, const VdbValueLayout& layout, const VdbTreeLimits& limits) {
  return TopologyReader<Value>(cursor, layout, limits).read();
}

template <class Value>
field::SparseSamples read_vdb_leaves(VdbCursor& cursor, const VdbValueLayout& layout, const VdbTreeLimits& limits,
                                     VdbTopology topology) {
  const std::size_t count = topology.samples.blocks.size();
  auto reserved =
      limits.context.reserve(count * kLeafValues * sizeof(Value),
                             fmt::format("{}: the {} leaf nodes of grid '{}'", limits.file, count, limits.grid));
  if (!reserved) throw VdbReadError(reserved.error());

  field::SparseSamples samples = std::move(topology.samples);
  const auto memory = std::make_shared<TreeMemory<Value>>(
      TreeMemory<Value>{Buffer<Value>(count * kLeafValues), std::move(*reserved), std::move(topology.blocks_memory),
                        std::move(topology.tiles_memory)});
  const auto background = static_cast<Value>(samples.background);
  const auto values_of = [&](std::size_t leaf) {
    return memory->values.span().subspan(leaf * kLeafValues, kLeafValues);
  };
  std::size_t next = 0;
  const auto take = [&](tbb::flow_control& control) {
    if (next == count) {
      control.stop();
      return LeafRun{};
    }
    LeafRun run = take_run<Value>(cursor, layout, topology.masks, next);
    next += run.leaves.size();
    return run;
  };
  const auto unpack = [&](const LeafRun& run) {
    for (std::size_t i = 0; i < run.leaves.size(); ++i) {
      unpack_values<Value>(run.leaves[i], layout, background, values_of(run.first + i));
    }
  };
  const auto runs_at_once = 2 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  tbb::parallel_pipeline(runs_at_once, tbb::make_filter<void, LeafRun>(tbb::filter_mode::serial_in_order, take) &
                                           tbb::make_filter<LeafRun, void>(tbb::filter_mode::parallel, unpack));

  for (std::size_t i = 0; i < count; ++i) samples.blocks[i].values = values_of(i).data();
  tbb::parallel_sort(samples.blocks, [](const field::SparseBlock& a, const field::SparseBlock& b) {
    return by_place(a.origin) < by_place(b.origin);
  });
  samples.owner = memory;
  return samples;
}

template VdbTopology read_vdb_topology<float>(VdbCursor&, const VdbValueLayout&, const VdbTreeLimits&);
template VdbTopology read_vdb_topology<double>(VdbCursor&, const VdbValueLayout&, const VdbTreeLimits&);
template VdbTopology read_vdb_topology<std::int32_t>(VdbCursor&, const VdbValueLayout&, const VdbTreeLimits&);
template field::SparseSamples read_vdb_leaves<float>(VdbCursor&, const VdbValueLayout&, const VdbTreeLimits&,
                                                     VdbTopology);
template field::SparseSamples read_vdb_leaves<double>(VdbCursor&, const VdbValueLayout&, const VdbTreeLimits&,
                                                      VdbTopology);
template field::SparseSamples read_vdb_leaves<std::int32_t>(VdbCursor&, const VdbValueLayout&, const VdbTreeLimits&,
                                                            VdbTopology);

}  // namespace isoextract::volume_io
