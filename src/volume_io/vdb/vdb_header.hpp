// The header of a VDB file and the descriptions of its grids, without their trees. Accepts grids of unknown types.
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
  std::string unique_name;  // as stored: the name, with a suffix if it repeats
  std::string name;
  std::string tree_type;                // "Tree_float_5_4_3"
  std::string value_type;               // "float"; with the tree's configuration if it is unusual
  std::string instance_parent;          // unique name of the grid whose tree this one shares; may be empty
  bool half = false;                    // floats are stored as half
  std::string grid_class;               // "level set", "fog volume", ...; may be empty
  std::string creator;                  // from the grid's or the file's metadata
  std::string vector_type;              // of vector grids: "contravariant relative", ...; may be empty
  bool in_local_space = false;          // of vector grids: vectors are in index space instead of world space
  std::optional<std::uint64_t> voxels;  // number of active voxels, if the file has it
  std::optional<field::IndexBox> box;   // of the active voxels, if the file has it
  std::uint32_t compression = 0;
  std::uint64_t transform_position = 0;  // position in the file; the tree follows the transform
  std::string placement_problem;         // why the transform cannot be used; empty if it can
  bool is_in_frustum = false;            // the transform is a frustum, which placement_problem says
  std::uint64_t end_position = 0;        // position after the grid, where the next description starts
};

// Returns how the grid stores values of `value_size` bytes (`half_size` if saved as half). Throws UnsupportedVdb for
// unknown compressions.
[[nodiscard]] VdbValueLayout value_layout(const VdbGridRecord& grid, std::size_t value_size, std::size_t half_size);

// Version written by OpenVDB 10; files of later versions have been readable so far.
inline constexpr std::uint32_t kNewestVdbVersion = 224;

struct VdbHeader {
  std::uint32_t file_version = 0;
  std::vector<VdbGridRecord> grids;  // in file order
};

// Reads the header. Files written as a stream do not store grid positions: reads such a file to its end, skipping each
// tree to find the next grid. Throws InvalidVdb, UnsupportedVdb and VdbReadError.
[[nodiscard]] VdbHeader read_vdb_header(VdbCursor& cursor);

// Returns whether the file has grids and all are point grids. Reads no more than necessary. Throws as
// read_vdb_header() does.
[[nodiscard]] bool has_only_point_grids(VdbCursor& cursor);
// Returns whether `grid` is a point grid; this reader reads only the description of point grids.
[[nodiscard]] bool is_point_grid(const VdbGridRecord& grid);

}  // namespace isoextract::volume_io
