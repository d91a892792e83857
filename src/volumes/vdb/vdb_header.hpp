// The header of a VDB file and the descriptions of its grids, without their trees. Grids of an unknown type are no
// error here. Private to io.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "field/samples.hpp"
#include "volumes/vdb/vdb_cursor.hpp"

namespace isoextract::volumes {

struct VdbGridRecord {
  std::string unique_name;  // as stored: the name, and a suffix where it repeats
  std::string name;
  std::string tree_type;                // "Tree_float_5_4_3"
  std::string value_type;               // "float"
  std::string instance_parent;          // unique name of the grid whose tree this one shares; may be empty
  bool half = false;                    // floats are stored as half
  std::string grid_class;               // "level set", "fog volume", ...; may be empty
  std::optional<std::uint64_t> voxels;  // active ones, where the file says so
  std::optional<field::IndexBox> box;   // of the active voxels, likewise
  std::uint32_t compression = 0;
  std::uint64_t transform_position = 0;  // in the file; the tree follows the transform
  std::uint64_t end_position = 0;        // of the grid, at which the next one's description begins
};

// What OpenVDB 10 writes. Later ones have been readable so far.
inline constexpr std::uint32_t kNewestVdbVersion = 224;

struct VdbHeader {
  std::uint32_t file_version = 0;
  std::vector<VdbGridRecord> grids;  // in the order of the file
};

// Throws VdbDamaged.
[[nodiscard]] VdbHeader read_vdb_header(VdbCursor& cursor);

}  // namespace isoextract::volumes
