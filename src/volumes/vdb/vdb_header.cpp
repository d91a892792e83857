#include "volumes/vdb/vdb_header.hpp"

#include <cstring>
#include <functional>

#include <fmt/format.h>

namespace isoextract::volumes {
namespace {

constexpr std::int64_t kVdbMagic = 0x56444220;
// From OpenVDB 1.1 (2013) on; older layouts have other nodes and transforms.
constexpr std::uint32_t kOldestVersion = 222;
constexpr std::size_t kUuidLength = 36;
constexpr std::string_view kHalfSuffix = "_HalfFloat";
constexpr char kNameSeparator = '\x1e';

// Calls item(name, type, bytes) for each entry of a metadata map that is small enough to be of interest; the others are
// passed over.
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
std::optional<T> value_of(const std::string& bytes) {
  T value;
  if (bytes.size() != sizeof value) return std::nullopt;
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

void read_grid_metadata(VdbCursor& cursor, VdbGridRecord& grid) {
  std::optional<glm::ivec3> box_min;
  std::optional<glm::ivec3> box_max;
  read_metadata(cursor, [&](const std::string& name, const std::string& type, const std::string& bytes) {
    if (name == "class" && type == "string") grid.grid_class = bytes;
    if (name == "is_saved_as_half_float" && type == "bool") grid.half = bytes == std::string(1, '\1');
    if (name == "file_bbox_min" && type == "vec3i") box_min = value_of<glm::ivec3>(bytes);
    if (name == "file_bbox_max" && type == "vec3i") box_max = value_of<glm::ivec3>(bytes);
    if (name == "file_voxel_count" && type == "int64") {
      const auto voxels = value_of<std::int64_t>(bytes);
      if (voxels && *voxels >= 0) grid.voxels = static_cast<std::uint64_t>(*voxels);
    }
  });
  if (!box_min || !box_max) return;
  grid.box = field::IndexBox{*box_min, *box_max};
  // An empty grid's box is inside out, in a way that overflows when it is measured.
  if (grid.box->empty()) grid.box = field::IndexBox{};
}

// "Tree_float_5_4_3" -> "float"; other names as they are.
std::string value_type_of(const std::string& tree_type) {
  constexpr std::string_view kPrefix = "Tree_";
  if (!tree_type.starts_with(kPrefix)) return tree_type;
  return tree_type.substr(kPrefix.size(), tree_type.find('_', kPrefix.size()) - kPrefix.size());
}

VdbGridRecord read_descriptor(VdbCursor& cursor) {
  VdbGridRecord grid;
  grid.unique_name = cursor.read_name();
  grid.name = grid.unique_name.substr(0, grid.unique_name.find(kNameSeparator));
  grid.tree_type = cursor.read_name();
  // OpenVDB too goes by the metadata when it reads the values.
  if (grid.tree_type.ends_with(kHalfSuffix)) grid.tree_type.resize(grid.tree_type.size() - kHalfSuffix.size());
  grid.value_type = value_type_of(grid.tree_type);
  grid.instance_parent = cursor.read_name();
  const auto grid_position = cursor.read_value<std::int64_t>();
  static_cast<void>(cursor.read_value<std::int64_t>());  // of its values: they follow the tree's nodes
  const auto end_position = cursor.read_value<std::int64_t>();
  if (grid_position < static_cast<std::int64_t>(cursor.position()) || end_position < grid_position ||
      static_cast<std::uint64_t>(end_position) > cursor.size()) {
    throw VdbDamaged(fmt::format("grid '{}' is said to be at bytes {} to {} of {}",
                                 files::printable(std::string_view(grid.name), 80), grid_position, end_position,
                                 cursor.size()));
  }
  // Grids do not overlap where each stays within its end: then all of them together take no longer than the file is.
  grid.end_position = static_cast<std::uint64_t>(end_position);
  cursor.seek(static_cast<std::uint64_t>(grid_position));
  cursor.set_end(grid.end_position);
  grid.compression = cursor.read_value<std::uint32_t>();
  read_grid_metadata(cursor, grid);
  grid.transform_position = cursor.position();
  cursor.set_end(cursor.size());
  cursor.seek(grid.end_position);
  return grid;
}

}  // namespace

VdbHeader read_vdb_header(VdbCursor& cursor) {
  VdbHeader header;
  if (cursor.read_value<std::int64_t>() != kVdbMagic) throw VdbDamaged("expected 'VDB' at the start");
  header.file_version = cursor.read_value<std::uint32_t>();
  if (header.file_version < kOldestVersion) {
    throw VdbDamaged(fmt::format("expected file version {} or later, found {}: load and save it with a newer OpenVDB",
                                 kOldestVersion, header.file_version));
  }
  static_cast<void>(cursor.take(2 * sizeof(std::uint32_t)));  // the library's version
  if (cursor.read_value<std::uint8_t>() == 0) {
    throw VdbDamaged("written as a stream, without the places of its grids: load and save it with OpenVDB");
  }
  cursor.seek(cursor.position() + kUuidLength);
  read_metadata(cursor, [](const std::string&, const std::string&, const std::string&) {});
  const auto count = cursor.read_value<std::int32_t>();
  if (count < 0) throw VdbDamaged(fmt::format("said to hold {} grids", count));
  for (std::int32_t i = 0; i < count; ++i) header.grids.push_back(read_descriptor(cursor));
  return header;
}

}  // namespace isoextract::volumes
