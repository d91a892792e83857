#include "volume_io/vdb/vdb_plugin.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/file_bytes.hpp"
#include "plugin_host/plugin_kinds.hpp"
#include "volume_io/detail/grid_choice.hpp"
#include "volume_io/vdb/vdb_skip.hpp"
#include "volume_io/vdb/vdb_transform.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::array<std::string_view, 6> kPluginValues{"bool", "mask", "int64", "vec3s", "vec3d", "vec3i"};
constexpr std::string_view kStaggeredClass = "staggered";
constexpr std::array<std::string_view, 4> kVectorParts{"[x]", "[y]", "[z]", "[length]"};

// Matches only trees of the usual configuration: value_type states any other configuration.
bool is_left_to_plugin(const VdbGridRecord& record) { return std::ranges::count(kPluginValues, record.value_type) > 0; }

// "velocity[x]" -> "velocity"; other names as they are.
std::string_view remove_component_suffix(std::string_view name) {
  for (const std::string_view part : kVectorParts) {
    if (name.ends_with(part)) return name.substr(0, name.size() - part.size());
  }
  return name;
}

// Shifts a component of a staggered grid to the centers of the voxels' lower faces along its axis, as OpenVDB's
// StaggeredBoxSampler does.
void shift_staggered_component(const std::string& part, const VdbGridRecord& record, field::ScalarField& field) {
  const std::string what = fmt::format("the grid '{}' has staggered components: ", printable(record.name, 80));
  const std::string_view axes = "xyz";
  const std::size_t axis = part.size() == 3 ? axes.find(part[1]) : std::string_view::npos;
  if (axis == std::string_view::npos) {
    field.notes.push_back(
        {NoteId::staggered_grid, what + "each length combines three components that lie half a voxel apart"});
  } else if (record.is_in_frustum) {
    field.notes.push_back(
        {NoteId::staggered_grid,
         what + "in a frustum the reader places its components at the centers of voxels, half a voxel off"});
  } else {
    glm::dvec3 shift(0);
    shift[static_cast<int>(axis)] = -0.5;
    for (field::Affine* map : {&field.index_to_world, &field.index_to_file}) map->offset += map->linear * shift;
    field.notes.push_back({NoteId::staggered_grid, what + "the reader places its components on the faces of voxels"});
  }
}

// Checks where the tree ends; the plug-in only gets trees of known configurations.
void check_tree_ends(VdbCursor& cursor, const VdbGridRecord& record) {
  if (!record.instance_parent.empty()) return;
  cursor.set_end(record.end_position);
  cursor.seek(record.transform_position);
  static_cast<void>(read_vdb_transform(cursor));
  skip_vdb_tree(cursor, record);
  cursor.set_end(cursor.size());
}

}  // namespace

void mark_plugin_grids(const VdbHeader& header, std::span<GridInfo> grids, bool is_missing) {
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const VdbGridRecord& record = header.grids[i];
    GridInfo& grid = grids[i];
    const bool is_bent = grid.scalar && record.is_in_frustum;
    if (!is_bent && !is_left_to_plugin(record)) continue;
    grid.plugin = plugin_host::kOpenVdbPlugin;
    grid.plugin_is_missing = is_missing;
    if (!record.value_type.starts_with("vec3")) continue;
    for (const std::string_view part : kVectorParts) grid.parts.push_back(fmt::format("{}{}", grid.label, part));
  }
}

std::optional<PluginGrid> choose_plugin_grid(VdbCursor& cursor, const VdbHeader& header,
                                             std::span<const GridInfo> grids, const ReadOptions& options) {
  if (const auto chosen = choose_grid({}, grids, options.grid)) {
    const VdbGridRecord& record = header.grids[*chosen];
    if (grids[*chosen].plugin.empty() || options.spacing) return std::nullopt;
    check_tree_ends(cursor, record);
    return PluginGrid{grids[*chosen].label, fmt::format("'{}' lies in a frustum", grids[*chosen].label)};
  }
  // Without a choice, scalar grids have precedence: the built-in reader asks the user to choose one.
  if (!options.grid && std::ranges::count(grids, true, &GridInfo::scalar) > 0) return std::nullopt;
  std::optional<PluginGrid> found;
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const VdbGridRecord& record = header.grids[i];
    if (grids[i].plugin.empty()) continue;
    const std::string wanted = options.grid.value_or("");
    if (options.grid && !grids[i].matches_name(wanted) && !grids[i].matches_name(remove_component_suffix(wanted)))
      continue;
    check_tree_ends(cursor, record);
    if (!found) found = PluginGrid{options.grid, fmt::format("'{}' holds {}", grids[i].label, grids[i].type)};
  }
  return found;
}

Result<field::ScalarField> read_by_plugin(const VolumeFormat& plugin, const std::string& input,
                                          const PluginGrid& wanted, const VdbHeader& header,
                                          std::span<const GridInfo> grids, const ReadOptions& options,
                                          const Context& context) {
  ReadOptions asked = options;
  asked.grid = wanted.grid;
  auto field = plugin.open(input, asked, context);
  const std::string start = input + ": ";
  if (!field && field.error().code == ErrorCode::unavailable && field.error().message.starts_with(start)) {
    field.error().message.insert(start.size(), fmt::format("the grid {}; ", wanted.reason));
  }
  if (!field) return field;
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const auto part = std::ranges::find(grids[i].parts, field->grid);
    const bool is_part = part != grids[i].parts.end();
    if (!is_part && grids[i].label != field->grid) continue;
    field->creator = grids[i].creator;
    if (is_part && header.grids[i].grid_class == kStaggeredClass) {
      shift_staggered_component(part->substr(grids[i].label.size()), header.grids[i], *field);
    }
  }
  return field;
}

}  // namespace isoextract::volume_io
