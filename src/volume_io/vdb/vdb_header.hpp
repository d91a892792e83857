// The header of a VDB file and the descriptions of its grids, without their trees. Grids of an unknown type are no
// error here.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "field/samples.hpp"
#include "volume_io/vdb/vdb_cursor.hpp"
#include "volume_io/vdb/vdb_values.hpp"

namespace isoextract::volume_io {

struct VdbGridRecord {
  std::string unique_name;  // as stored: the name, and a suffix where it repeats
  std::string name;
  std::string tree_type;                // "Tree_float_5_4_3"
  std::string value_type;               // "float"; the tree's shape as well if it is not the usual one
  std::string instance_parent;          // unique name of the grid whose tree this one shares; may be empty
  bool half = false;                    // floats are stored as half
  std::string grid_class;               // "level set", "fog volume", ...; may be empty
  std::string creator;                  // what made it, where the grid or the file says so
  std::string vector_type;              // of vectors: "contravariant relative", ...; may be empty
  bool in_local_space = false;          // likewise: they are in the axes of the voxels, not in those of the world
  std::optional<std::uint64_t> voxels;  // active ones, where the file says so
  std::optional<field::IndexBox> box;   // of the active voxels, likewise
  std::uint32_t compression = 0;
  std::uint64_t transform_position = 0;  // in the file; the tree follows the transform
  std::string frame_problem;             // why the transform cannot be used; empty if it can
  bool in_frustum = false;               // which is why
  std::uint64_t end_position = 0;        // of the grid, at which the next one's description begins
};

// How values of `value_size` bytes are stored in the grid; of `half_size` where it is saved as half. Throws
// VdbUnsupported for compressions that are not known.
[[nodiscard]] VdbValueLayout value_layout(const VdbGridRecord& grid, std::size_t value_size, std::size_t half_size);

// What OpenVDB 10 writes. Later ones have been readable so far.
inline constexpr std::uint32_t kNewestVdbVersion = 224;

struct VdbHeader {
  std::uint32_t file_version = 0;
  std::vector<VdbGridRecord> grids;  // in the order of the file
};

// Of a file that was written as a stream, which has no places of grids, this reads all there is: a grid's end is found
// by passing over its tree. Throws VdbDamaged and VdbUnsupported.
[[nodiscard]] VdbHeader read_vdb_header(VdbCursor& cursor);

// Whether the grids of a file are points, all of them, and there is one. Reads no further than it must. Throws
// VdbDamaged and VdbUnsupported.
[[nodiscard]] bool holds_only_points(VdbCursor& cursor);
// Points of which nothing but their descriptors is read here.
[[nodiscard]] bool is_point_grid(const VdbGridRecord& grid);

}  // namespace isoextract::volume_io
