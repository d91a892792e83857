// Input grids of the interface (grid_tools_plugin.h) as OpenVDB grids of floats.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <openvdb/openvdb.h>

#include <grid_tools_plugin.h>
#include "openvdb_parts.hpp"

namespace isoextract_openvdb {

using openvdb::FloatGrid;
using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;

inline constexpr double kMostIndex = 1 << 29;  // limit of voxel indices; keeps arithmetic within an int

template <class F>
void visit_samples(std::int32_t type, const void* data, F&& use) {
  const auto as = [&]<class T>(std::type_identity<T>) { use(static_cast<const T*>(data)); };
  switch (type) {
    case ISOEXTRACT_U8: return as(std::type_identity<std::uint8_t>{});
    case ISOEXTRACT_I8: return as(std::type_identity<std::int8_t>{});
    case ISOEXTRACT_U16: return as(std::type_identity<std::uint16_t>{});
    case ISOEXTRACT_I16: return as(std::type_identity<std::int16_t>{});
    case ISOEXTRACT_U32: return as(std::type_identity<std::uint32_t>{});
    case ISOEXTRACT_I32: return as(std::type_identity<std::int32_t>{});
    case ISOEXTRACT_F16: return as(std::type_identity<openvdb::math::half>{});
    case ISOEXTRACT_F32: return as(std::type_identity<float>{});
    case ISOEXTRACT_F64: return as(std::type_identity<double>{});
    default: throw PluginError("expected samples of a known type, found type " + std::to_string(type));
  }
}

inline bool same_bits(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }

// Builds an OpenVDB grid from an input; reserves its memory in `memory`.
class GridBuilder {
 public:
  GridBuilder(const isoextract_grid_input& input, Reserved& memory) : input_(input), memory_(memory) {}

  FloatGrid::Ptr build() {
    if (input_.sparse != nullptr) {
      from_sparse(*input_.sparse);
    } else {
      from_box();
    }
    const bool is_level_set = input_.kind == ISOEXTRACT_LEVEL_SET;
    grid_->setGridClass(is_level_set ? openvdb::GRID_LEVEL_SET : openvdb::GRID_FOG_VOLUME);
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) matrix[column][row] = input_.index_to_world[4 * row + column];
    }
    grid_->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    return grid_;
  }

 private:
  [[nodiscard]] float value_of(double stored) const {
    const bool as_it_is = input_.slope == 1 && input_.intercept == 0;
    return static_cast<float>(as_it_is ? stored : input_.slope * stored + input_.intercept);
  }

  // Returns float samples without slope and intercept unchanged, bit by bit.
  template <class T>
  [[nodiscard]] float sample(T stored) const {
    if constexpr (std::is_same_v<T, float>) {
      if (input_.slope == 1 && input_.intercept == 0) return stored;
    }
    return value_of(static_cast<double>(stored));
  }

  // Returns whether a voxel is active. An inactive value is the background or, in a level set, the negative background.
  [[nodiscard]] bool is_active(float value) const {
    const float background = grid_->background();
    if (input_.kind == ISOEXTRACT_LEVEL_SET && same_bits(value, -background)) return false;
    return !same_bits(value, background);
  }

  void from_sparse(const isoextract_sparse_samples& samples) {
    grid_ = FloatGrid::create(value_of(samples.background));
    memory_.take(samples.block_count * kLeafBytes + (std::uint64_t{1} << 20));
    reserve_nodes_above(samples);
    for (std::size_t i = 0; i < samples.tile_count; ++i) add_tile(samples.tiles[i]);
    for (std::size_t i = 0; i < samples.block_count; ++i) {
      const isoextract_sparse_block& block = samples.blocks[i];
      Leaf& leaf = *grid_->tree().touchLeaf({block.origin[0], block.origin[1], block.origin[2]});
      visit_samples(samples.sample_type, block.values, [&](const auto* values) {
        for (openvdb::Index n = 0; n < kLeafValues; ++n) put(leaf, n, sample(values[n]));
      });
    }
  }

  // Scattered bricks can each have their own nodes, which are far larger than a brick.
  void reserve_nodes_above(const isoextract_sparse_samples& samples) {
    using Upper = FloatTree::RootNodeType::ChildNodeType;
    using Lower = Upper::ChildNodeType;
    memory_.take((samples.block_count + samples.tile_count) * sizeof(openvdb::Coord));
    std::vector<openvdb::Coord> nodes;
    nodes.reserve(samples.block_count + samples.tile_count);
    const auto add = [&](const std::int32_t* origin) { nodes.emplace_back(origin[0], origin[1], origin[2]); };
    const auto distinct = [&](openvdb::Index side) {
      for (openvdb::Coord& node : nodes) node &= ~(static_cast<std::int32_t>(side) - 1);
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());  // most duplicates are consecutive
      std::ranges::sort(nodes, [](const openvdb::Coord& a, const openvdb::Coord& b) { return a < b; });
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
      return static_cast<std::uint64_t>(nodes.size());
    };
    const std::span tiles(samples.tiles, samples.tile_count);
    for (const isoextract_sparse_block& block : std::span(samples.blocks, samples.block_count)) add(block.origin);
    for (const isoextract_sparse_tile& tile : tiles) {
      if (tile.size < static_cast<int>(Lower::DIM)) add(tile.origin);
    }
    const std::uint64_t lower = distinct(Lower::DIM);
    for (const isoextract_sparse_tile& tile : tiles) {
      if (tile.size >= static_cast<int>(Lower::DIM) && tile.size < static_cast<int>(Upper::DIM)) add(tile.origin);
    }
    memory_.take(lower * sizeof(Lower) + distinct(Upper::DIM) * sizeof(Upper));
  }

  void put(Leaf& leaf, openvdb::Index n, float value) const {
    leaf.setValueOnly(n, value);
    leaf.setActiveState(n, is_active(value));
  }

  // Fills the tile with cubes of the tree's node sizes.
  void add_tile(const isoextract_sparse_tile& tile) {
    const float value = value_of(tile.value);
    openvdb::Index level = 1;
    int size = 8;
    if (tile.size >= 4096) {
      level = 3;
      size = 4096;
    } else if (tile.size >= 128) {
      level = 2;
      size = 128;
    }
    for (int x = 0; x < tile.size; x += size) {
      for (int y = 0; y < tile.size; y += size) {
        for (int z = 0; z < tile.size; z += size) {
          grid_->tree().addTile(level, {tile.origin[0] + x, tile.origin[1] + y, tile.origin[2] + z}, value,
                                is_active(value));
        }
      }
    }
  }

  void from_box() {
    std::array<int, 3> dims{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (input_.dims[axis] == 0 || input_.dims[axis] >= static_cast<std::uint64_t>(kMostIndex)) {
        throw PluginError("expected fewer than 2^29 samples along each axis");
      }
      dims[axis] = static_cast<int>(input_.dims[axis]);
    }
    std::uint64_t leaves = 1;
    for (const int dim : dims) leaves *= static_cast<std::uint64_t>((dim + 7) / 8);
    memory_.take(leaves * kLeafBytes);
    visit_samples(input_.sample_type, input_.data, [&](const auto* data) {
      const std::size_t count = input_.dims[0] * input_.dims[1] * input_.dims[2];
      grid_ = FloatGrid::create(outside(data, count));
      for (int x = 0; x < dims[0]; x += 8) {
        for (int y = 0; y < dims[1]; y += 8) {
          for (int z = 0; z < dims[2]; z += 8) put_box(data, dims, {x, y, z});
        }
      }
    });
  }

  // Returns the background of a full box, which is outside for every iso value: the least finite value of a density, or
  // the greatest finite value of a level set; 0 if there is none.
  template <class T>
  [[nodiscard]] float outside(const T* data, std::size_t count) const {
    const bool greatest = input_.kind == ISOEXTRACT_LEVEL_SET;
    std::optional<float> found;
    for (std::size_t i = 0; i < count; ++i) {
      const float value = sample(data[i]);
      if (std::isfinite(value) && (!found || (greatest ? value > *found : value < *found))) found = value;
    }
    return found.value_or(0.0F);
  }

  template <class T>
  void put_box(const T* data, const std::array<int, 3>& dims, const openvdb::Coord& origin) {
    Leaf* leaf = nullptr;  // null if all values are the background
    for (openvdb::Index n = 0; n < kLeafValues; ++n) {
      const openvdb::Coord at = origin + Leaf::offsetToLocalCoord(n);
      if (at.x() >= dims[0] || at.y() >= dims[1] || at.z() >= dims[2]) continue;
      const auto row = static_cast<std::size_t>(at.y()) + input_.dims[1] * static_cast<std::size_t>(at.z());
      const float value = sample(data[static_cast<std::size_t>(at.x()) + input_.dims[0] * row]);
      if (leaf == nullptr && same_bits(value, grid_->background())) continue;
      if (leaf == nullptr) leaf = grid_->tree().touchLeaf(origin);
      put(*leaf, n, value);
    }
  }

  const isoextract_grid_input& input_;
  Reserved& memory_;
  FloatGrid::Ptr grid_;
};

}  // namespace isoextract_openvdb
