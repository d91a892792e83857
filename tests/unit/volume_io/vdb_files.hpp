// Shared by the tests of the VDB reader: files written by OpenVDB, and sample lookup.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <tuple>

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include "field/scalar_field.hpp"

namespace isoextract::test {

inline void write_vdb(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids,
                      std::uint32_t compression = openvdb::io::COMPRESS_ACTIVE_MASK, bool with_counts = true) {
  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.setCompression(compression);
  file.setGridStatsMetadataEnabled(with_counts);
  file.write(grids);
  file.close();
}

// Writes without grid positions, as to a pipe.
inline void write_vdb_stream(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids,
                             std::uint32_t compression = openvdb::io::COMPRESS_ACTIVE_MASK, bool with_counts = true) {
  openvdb::initialize();
  std::ofstream file(path, std::ios::binary);
  openvdb::io::Stream stream(file);
  stream.setCompression(compression);
  stream.setGridStatsMetadataEnabled(with_counts);
  stream.write(grids);
}

// Returns the sample an extractor sees at an index, from a block, a tile or the background.
template <class T>
double sparse_value(const field::SparseSamples& samples, const glm::ivec3& index) {
  const glm::ivec3 origin = index & ~7;
  const auto key = [](const glm::ivec3& v) { return std::tuple(v.x, v.y, v.z); };
  const auto block = std::ranges::lower_bound(samples.blocks, key(origin), {},
                                              [&](const field::SparseBlock& b) { return key(b.origin); });
  if (block != samples.blocks.end() && block->origin == origin) {
    const glm::ivec3 in = index - origin;
    return static_cast<double>(static_cast<const T*>(block->values)[in.x << 6 | in.y << 3 | in.z]);
  }
  for (const field::SparseTile& tile : samples.tiles) {
    const glm::ivec3 in = index - tile.origin;
    if (std::min({in.x, in.y, in.z}) >= 0 && std::max({in.x, in.y, in.z}) < tile.size) return tile.value;
  }
  return samples.background;
}

// Makes voxels (1, 2, 3) and (-100, 0, 9) with a spacing of one half.
template <class Grid>
typename Grid::Ptr two_voxels(const std::string& name, typename Grid::ValueType first,
                              typename Grid::ValueType second) {
  openvdb::initialize();
  auto grid = Grid::create();
  grid->setName(name);
  grid->tree().setValue({1, 2, 3}, first);
  grid->tree().setValue({-100, 0, 9}, second);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  return grid;
}

}  // namespace isoextract::test
