#include "volume_io/vdb/vdb_skip.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "volume_io/vdb/vdb_values.hpp"

namespace isoextract::volume_io {
namespace {

// Content of a leaf besides its mask.
enum class LeafContents {
  values,           // compressed like other nodes' values
  origin_and_bits,  // bool: its origin and one bit per value
  origin,           // mask: its origin; the mask is the value
};

// Size of a tree's values in a file.
struct TreeValues {
  std::string_view type;
  std::size_t size;
  std::size_t half_size;
  LeafContents leaf = LeafContents::values;
};

constexpr std::array kTreeValues{TreeValues{"float", 4, 2},
                                 TreeValues{"double", 8, 2},
                                 TreeValues{"int32", 4, 4},
                                 TreeValues{"int64", 8, 8},
                                 TreeValues{"vec3s", 12, 6},
                                 TreeValues{"vec3d", 24, 6},
                                 TreeValues{"vec3i", 12, 12},
                                 TreeValues{"bool", 1, 1, LeafContents::origin_and_bits},
                                 TreeValues{"mask", 1, 1, LeafContents::origin}};

constexpr std::uint64_t kPlaceBytes = 3 * sizeof(std::int32_t);
constexpr std::uint64_t kLeafEntries = 512;
constexpr std::uint64_t kMaskBytes = kLeafEntries / 8;

void pass(VdbCursor& cursor, std::uint64_t bytes) { cursor.seek(cursor.position() + bytes); }

// Skips a node with this many entries, each a tile or a child. Returns the number of children.
std::uint32_t skip_node(VdbCursor& cursor, const VdbValueLayout& layout, std::uint64_t entries) {
  const std::uint64_t mask_bytes = entries / 8;
  cursor.prepare(2 * mask_bytes + max_packed_bytes(entries, layout.value_size));
  const auto children = cursor.take(mask_bytes);
  const auto active = cursor.take(mask_bytes);
  static_cast<void>(take_values(cursor, active, layout));
  return count_bits(children);
}

// Skips everything before the leaves' contents. Returns the number of leaves.
std::uint64_t skip_topology(VdbCursor& cursor, const VdbValueLayout& layout) {
  constexpr std::uint64_t kUpperEntries = 32 * 32 * 32;
  constexpr std::uint64_t kLowerEntries = 16 * 16 * 16;
  const auto buffers = cursor.read_value<std::int32_t>();
  if (buffers != 1) throw InvalidVdb(fmt::format("expected one buffer in a tree, found {}", buffers));
  pass(cursor, layout.value_size);  // the background
  const auto tiles = cursor.read_value<std::uint32_t>();
  const auto uppers = cursor.read_value<std::uint32_t>();
  pass(cursor, tiles * (kPlaceBytes + layout.value_size + 1));
  std::uint64_t leaves = 0;
  for (std::uint32_t upper = 0; upper < uppers; ++upper) {
    pass(cursor, kPlaceBytes);
    const std::uint32_t lowers = skip_node(cursor, layout, kUpperEntries);
    for (std::uint32_t lower = 0; lower < lowers; ++lower) {
      const std::uint32_t in_lower = skip_node(cursor, layout, kLowerEntries);
      pass(cursor, in_lower * kMaskBytes);
      leaves += in_lower;
    }
  }
  return leaves;
}

void skip_leaves(VdbCursor& cursor, const VdbValueLayout& layout, LeafContents contents, std::uint64_t leaves) {
  if (contents != LeafContents::values) {
    const std::uint64_t bits = contents == LeafContents::origin_and_bits ? kMaskBytes : 0;
    pass(cursor, leaves * (kMaskBytes + kPlaceBytes + bits));
    return;
  }
  for (std::uint64_t leaf = 0; leaf < leaves; ++leaf) {
    cursor.prepare(kMaskBytes + max_packed_bytes(kLeafEntries, layout.value_size));
    const auto active = cursor.take(kMaskBytes);
    static_cast<void>(take_values(cursor, active, layout));
  }
}

}  // namespace

void skip_vdb_tree(VdbCursor& cursor, const VdbGridRecord& grid) {
  // For trees of the usual configuration value_type is the plain type.
  const auto known = std::ranges::find(kTreeValues, std::string_view(grid.value_type), &TreeValues::type);
  if (known == kTreeValues.end() || !grid.tree_type.starts_with("Tree_")) {
    throw UnsupportedVdb(
        fmt::format("the reader cannot find the end of a tree of the unknown type {}", printable(grid.tree_type, 80)));
  }
  const VdbValueLayout layout = value_layout(grid, known->size, known->half_size);
  skip_leaves(cursor, layout, known->leaf, skip_topology(cursor, layout));
}

}  // namespace isoextract::volume_io
