#include "volume_io/vdb/vdb_header.hpp"

#include <cstring>
#include <functional>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "volume_io/vdb/vdb_skip.hpp"
#include "volume_io/vdb/vdb_transform.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::int64_t kVdbMagic = 0x56444220;
// OpenVDB 1.1 (2013); older versions have other nodes and transforms.
constexpr std::uint32_t kOldestVersion = 222;
constexpr std::size_t kUuidLength = 36;
constexpr std::string_view kHalfSuffix = "_HalfFloat";
constexpr char kNameSeparator = '\x1e';

// Calls item(name, type, bytes) for each metadata entry that is small enough to matter; skips larger entries.
void read_metadata(VdbCursor& cursor,
                   const std::function<void(const std::string&, const std::string&, const std::string&)>& item) {
  const auto count = cursor.read_value<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string name = cursor.read_name();
    const std::string type = cursor.read_name();
    const auto size = cursor.read_value<std::uint32_t>();
    constexpr std::uint32_t kMaxInteresting = 256;
    if (size > kMaxInteresting) {
      cursor.seek(cursor.position() + size);
      continue;
    }
    item(name, type, cursor.read_text(size));
  }
}

template <class T>
std::optional<T> number_of(const std::string& bytes) {
  T value;
  if (bytes.size() != sizeof value) return std::nullopt;
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

// Returns whether the entry names the program that made a grid or file, by OpenVDB's convention.
bool is_creator(const std::string& name, const std::string& type) { return name == "creator" && type == "string"; }

void read_grid_metadata(VdbCursor& cursor, VdbGridRecord& grid) {
  std::optional<glm::ivec3> box_min;
  std::optional<glm::ivec3> box_max;
  read_metadata(cursor, [&](const std::string& name, const std::string& type, const std::string& bytes) {
    if (name == "class" && type == "string") grid.grid_class = bytes;
    if (is_creator(name, type)) grid.creator = bytes;
    if (name == "vector_type" && type == "string") grid.vector_type = bytes;
    if (name == "is_local_space" && type == "bool") grid.in_local_space = bytes == std::string(1, '\1');
    if (name == "is_saved_as_half_float" && type == "bool") grid.half = bytes == std::string(1, '\1');
    if (name == "file_bbox_min" && type == "vec3i") box_min = number_of<glm::ivec3>(bytes);
    if (name == "file_bbox_max" && type == "vec3i") box_max = number_of<glm::ivec3>(bytes);
    if (name == "file_voxel_count" && type == "int64") {
      const auto voxels = number_of<std::int64_t>(bytes);
      if (voxels && *voxels >= 0) grid.voxels = static_cast<std::uint64_t>(*voxels);
    }
  });
  if (!box_min || !box_max) return;
  grid.box = field::IndexBox{*box_min, *box_max};
  // The box of an empty grid is inverted, and its size overflows.
  if (grid.box->empty()) grid.box = field::IndexBox{};
}

// "Tree_float_5_4_3" -> "float", "Tree_float_4_3" -> "float (tree 4_3)"; other names as they are.
std::string value_type_of(const std::string& tree_type) {
  constexpr std::string_view kPrefix = "Tree_";
  constexpr std::string_view kUsualShape = "5_4_3";
  const std::size_t end = tree_type.find('_', kPrefix.size());
  if (!tree_type.starts_with(kPrefix) || end == std::string::npos) return tree_type;
  const std::string value = tree_type.substr(kPrefix.size(), end - kPrefix.size());
  const std::string shape = tree_type.substr(end + 1);
  return shape == kUsualShape ? value : fmt::format("{} (tree {})", value, shape);
}

// Reads the frame and leaves the cursor after the transform. Returns false if the transform's end is unknown.
bool read_frame(VdbCursor& cursor, VdbGridRecord& grid) {
  try {
    const VdbPlacement frame = read_vdb_transform(cursor);
    grid.placement_problem = frame.problem;
    grid.is_in_frustum = frame.is_frustum;
    return true;
  } catch (const UnsupportedVdb& unknown) {
    grid.placement_problem = unknown.what();
    return false;
  }
}

// Reads from the grid's compression flags to its transform.
bool read_grid_head(VdbCursor& cursor, VdbGridRecord& grid) {
  grid.compression = cursor.read_value<std::uint32_t>();
  read_grid_metadata(cursor, grid);
  grid.transform_position = cursor.position();
  return read_frame(cursor, grid);
}

// Calls read_grid_head(), and finds the grid's end in a file that does not store it. The last grid's end may stay
// unknown.
void read_streamed_grid(VdbCursor& cursor, VdbGridRecord& grid, bool last) {
  const bool known = read_grid_head(cursor, grid);
  grid.end_position = cursor.size();
  try {
    if (!known) throw UnsupportedVdb(grid.placement_problem);
    if (grid.instance_parent.empty()) skip_vdb_tree(cursor, grid);
    grid.end_position = cursor.position();
  } catch (const UnsupportedVdb& unknown) {
    if (last) return;
    throw UnsupportedVdb(
        fmt::format("grid '{}': {}; the file is a stream without the positions of its grids, so the reader cannot find "
                    "the grids after this one: load and save it with OpenVDB",
                    printable(grid.name, 80), unknown.what()));
  }
}

// Reads the names at the start of a grid's descriptor.
VdbGridRecord read_names(VdbCursor& cursor) {
  VdbGridRecord grid;
  grid.unique_name = cursor.read_name();
  grid.name = grid.unique_name.substr(0, grid.unique_name.find(kNameSeparator));
  grid.tree_type = cursor.read_name();
  // OpenVDB also uses the metadata instead of this suffix to read values.
  if (grid.tree_type.ends_with(kHalfSuffix)) grid.tree_type.resize(grid.tree_type.size() - kHalfSuffix.size());
  grid.value_type = value_type_of(grid.tree_type);
  return grid;
}

VdbGridRecord read_descriptor(VdbCursor& cursor, bool streamed, bool last) {
  VdbGridRecord grid = read_names(cursor);
  grid.instance_parent = cursor.read_name();
  const auto grid_position = cursor.read_value<std::int64_t>();
  static_cast<void>(cursor.read_value<std::int64_t>());  // position of the leaf values, which follow the topology
  const auto end_position = cursor.read_value<std::int64_t>();
  if (streamed) {
    read_streamed_grid(cursor, grid, last);
    return grid;
  }
  if (grid_position < static_cast<std::int64_t>(cursor.position()) || end_position < grid_position ||
      static_cast<std::uint64_t>(end_position) > cursor.size()) {
    throw InvalidVdb(
        fmt::format("expected grid '{}' between byte {} (end of its header) and byte {} (end of the file), its header "
                    "states bytes {} to {}",
                    printable(grid.name, 80), cursor.position(), cursor.size(), grid_position, end_position));
  }
  // Each grid must stay before its own end, so that grids do not overlap and the total time is linear in the file size.
  grid.end_position = static_cast<std::uint64_t>(end_position);
  cursor.seek(static_cast<std::uint64_t>(grid_position));
  cursor.set_end(grid.end_position);
  try {
    read_grid_head(cursor, grid);
  } catch (const InvalidVdb& damage) {
    if (grid.transform_position == 0) throw;
    grid.placement_problem = fmt::format("it is damaged: {}", damage.what());  // other grids stay readable
  }
  cursor.set_end(cursor.size());
  cursor.seek(grid.end_position);
  return grid;
}

}  // namespace

VdbValueLayout value_layout(const VdbGridRecord& grid, std::size_t value_size, std::size_t half_size) {
  constexpr std::uint32_t kKnown = kVdbZip | kVdbActiveMask | kVdbBlosc;
  if ((grid.compression & ~kKnown) != 0) {
    throw UnsupportedVdb(
        fmt::format("grid '{}' is compressed in an unknown way ({})", printable(grid.name, 80), grid.compression));
  }
  return {value_size, grid.half ? half_size : value_size, grid.compression};
}

namespace {

// The part of a file before its grids.
struct FileHead {
  std::uint32_t version = 0;
  bool streamed = false;  // has no grid positions
  std::string creator;
  std::int32_t grids = 0;
};

FileHead read_file_head(VdbCursor& cursor) {
  FileHead head;
  if (cursor.read_value<std::int64_t>() != kVdbMagic)
    throw InvalidVdb("expected ' BDV' and four zero bytes at the start");
  head.version = cursor.read_value<std::uint32_t>();
  if (head.version < kOldestVersion) {
    throw UnsupportedVdb(
        fmt::format("expected file version {} or later, found {}: load and save it with a newer OpenVDB",
                    kOldestVersion, head.version));
  }
  static_cast<void>(cursor.take(2 * sizeof(std::uint32_t)));  // version of the library
  head.streamed = cursor.read_value<std::uint8_t>() == 0;
  cursor.seek(cursor.position() + kUuidLength);
  read_metadata(cursor, [&](const std::string& name, const std::string& type, const std::string& bytes) {
    if (is_creator(name, type)) head.creator = bytes;
  });
  head.grids = cursor.read_value<std::int32_t>();
  if (head.grids < 0) throw InvalidVdb(fmt::format("expected 0 or more grids, the header states {}", head.grids));
  return head;
}

}  // namespace

VdbHeader read_vdb_header(VdbCursor& cursor) {
  const FileHead head = read_file_head(cursor);
  VdbHeader header;
  header.file_version = head.version;
  for (std::int32_t i = 0; i < head.grids; ++i) {
    header.grids.push_back(read_descriptor(cursor, head.streamed, i + 1 == head.grids));
    if (header.grids.back().creator.empty()) header.grids.back().creator = head.creator;
  }
  return header;
}

bool is_point_grid(const VdbGridRecord& grid) { return grid.tree_type.starts_with("Tree_ptdataidx"); }

bool has_only_point_grids(VdbCursor& cursor) {
  const FileHead head = read_file_head(cursor);
  for (std::int32_t i = 0; i < head.grids; ++i) {
    const std::uint64_t place = cursor.position();
    if (!is_point_grid(read_names(cursor))) return false;
    cursor.seek(place);
    static_cast<void>(read_descriptor(cursor, head.streamed, i + 1 == head.grids));
  }
  return head.grids > 0;
}

}  // namespace isoextract::volume_io
