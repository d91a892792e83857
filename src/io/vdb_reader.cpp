// OpenVDB's files: which grid, where it is, and its tree into sparse samples.
#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "io/grid_choice.hpp"
#include "io/vdb_header.hpp"
#include "io/vdb_transform.hpp"
#include "io/vdb_tree.hpp"
#include "io/volume_format.hpp"

namespace isoextract {
namespace {

constexpr std::string_view kLevelSetClass = "level set";
constexpr std::string_view kFogClass = "fog volume";

// Calls use(std::type_identity<Value>{}) with the type of a scalar grid's values; false for all other grids.
template <class F>
bool visit_scalar_tree(const std::string& tree_type, F&& use) {
  if (tree_type == "Tree_float_5_4_3") {
    use(std::type_identity<float>{});
  } else if (tree_type == "Tree_double_5_4_3") {
    use(std::type_identity<double>{});
  } else if (tree_type == "Tree_int32_5_4_3") {
    use(std::type_identity<std::int32_t>{});
  } else {
    return false;
  }
  return true;
}

template <class Value>
VdbValueLayout layout_of(const VdbGridRecord& record) {
  constexpr std::uint32_t kKnown = kVdbZip | kVdbActiveMask | kVdbBlosc;
  if ((record.compression & ~kKnown) != 0) {
    throw VdbDamaged(
        fmt::format("grid '{}' is compressed in an unknown way ({})", printable(record.name, 80), record.compression));
  }
  const bool half = record.half && std::is_floating_point_v<Value>;
  return {sizeof(Value), half ? sizeof(Half) : sizeof(Value), record.compression};
}

// Leaves the cursor at the grid's tree.
Frame read_transform_of(VdbCursor& cursor, const VdbGridRecord& record) {
  cursor.seek(record.transform_position);
  return read_vdb_transform(cursor);
}

// The record whose tree belongs to `record`: its own, or that of the grid it is an instance of.
const VdbGridRecord& tree_owner(const VdbHeader& header, const VdbGridRecord& record) {
  if (record.instance_parent.empty()) return record;
  const auto parent = std::ranges::find(header.grids, record.instance_parent, &VdbGridRecord::unique_name);
  if (parent == header.grids.end() || !parent->instance_parent.empty() || parent->tree_type != record.tree_type) {
    throw VdbDamaged(fmt::format("grid '{}' shares the tree of a grid that is not there", record.name));
  }
  return *parent;
}

// For files whose writer did not store these counts.
void count_voxels(VdbCursor& cursor, const VdbTreeLimits& limits, const VdbHeader& header, VdbGridRecord& record) {
  visit_scalar_tree(record.tree_type, [&]<class Value>(std::type_identity<Value>) {
    const VdbGridRecord& owner = tree_owner(header, record);
    static_cast<void>(read_transform_of(cursor, owner));
    const VdbTopology topology = read_vdb_topology<Value>(cursor, layout_of<Value>(owner), limits);
    record.voxels = topology.samples.active_voxels;
    record.box = topology.samples.active_box;
  });
}

std::vector<GridInfo> describe_grids(VdbCursor& cursor, const std::string& file, const Limits& limits,
                                     VdbHeader& header) {
  std::map<std::string, int> counts;
  std::vector<GridInfo> grids;
  for (VdbGridRecord& record : header.grids) {
    if (!record.voxels || !record.box) count_voxels(cursor, {limits, file, record.name}, header, record);
    GridInfo info;
    info.name = record.name;
    info.index_of_name = counts[record.name]++;
    info.type = record.value_type;
    info.scalar = visit_scalar_tree(record.tree_type, [](auto) {});
    if (record.grid_class == kLevelSetClass) info.kind = FieldKind::level_set;
    if (record.grid_class == kFogClass) info.kind = FieldKind::density;
    info.box = record.box.value_or(IndexBox{});
    info.voxels = record.voxels.value_or(0);
    grids.push_back(std::move(info));
  }
  for (GridInfo& info : grids) info.name_repeats = counts[info.name] > 1;
  return grids;
}

Result<ScalarField> read_grid(const InputFile& file, VdbCursor& cursor, const VdbHeader& header,
                              const VdbGridRecord& record, const ReadOptions& options) {
  ScalarField field;
  field.source = file.name();
  field.name = record.name;
  field.format = "OpenVDB";
  if (record.grid_class == kLevelSetClass) field.kind = FieldKind::level_set;

  const Frame frame = read_transform_of(cursor, record);
  if (auto placed = place_field(field, frame, options); !placed) return tl::unexpected(placed.error());
  const VdbGridRecord& owner = tree_owner(header, record);
  if (&owner != &record) static_cast<void>(read_transform_of(cursor, owner));
  const VdbTreeLimits limits{options.limits, file.name(), record.name};
  visit_scalar_tree(record.tree_type, [&]<class Value>(std::type_identity<Value>) {
    const auto layout = layout_of<Value>(owner);
    VdbTopology topology = read_vdb_topology<Value>(cursor, layout, limits);
    field.samples = read_vdb_leaves<Value>(cursor, layout, limits, std::move(topology));
  });
  return field;
}

// Calls work() and turns what it throws into an error that names the file.
template <class F>
auto with_messages(const InputFile& file, F&& work) -> decltype(work()) {
  if (!looks_like_vdb(first_bytes(file, kDetectionBytes).value_or(std::vector<std::byte>{}))) {
    return fail_magic(file, "a VDB file", "' BDV'");
  }
  try {
    return work();
  } catch (const VdbRefused& refused) {
    return tl::unexpected(refused.error);
  } catch (const VdbDamaged& damage) {
    return fail(ErrorKind::input, fmt::format("{}: the VDB file is damaged or not supported: {}", file.name(),
                                              printable(std::string_view(damage.what()), 300)));
  }
}

}  // namespace

bool looks_like_vdb(std::span<const std::byte> content) {
  return starts_with(content, std::string_view(" BDV\0\0\0\0", 8));
}

Result<std::vector<GridInfo>> list_vdb_grids(const InputFile& file) {
  return with_messages(file, [&]() -> Result<std::vector<GridInfo>> {
    VdbCursor cursor(file);
    VdbHeader header = read_vdb_header(cursor);
    return describe_grids(cursor, file.name(), default_limits(), header);
  });
}

Result<ScalarField> read_vdb(const InputFile& file, const ReadOptions& options) {
  return with_messages(file, [&]() -> Result<ScalarField> {
    if (options.progress != nullptr) options.progress->begin("reading", 0);
    VdbCursor cursor(file, options.progress);
    VdbHeader header = read_vdb_header(cursor);
    const std::vector<GridInfo> grids = describe_grids(cursor, file.name(), options.limits, header);
    const auto chosen = choose_grid(file.name(), grids, options.grid);
    if (!chosen) return tl::unexpected(chosen.error());
    auto field = read_grid(file, cursor, header, header.grids[*chosen], options);
    if (!field) return field;
    if (!options.grid && grids.size() > 1) {
      field->notes.push_back(fmt::format("grid '{}' of {} was chosen: it is the only scalar one",
                                         grid_label(grids[*chosen]), grids.size()));
    }
    if (header.file_version > kNewestVdbVersion) {
      field->notes.push_back(fmt::format("the file's version {} is newer than {}, the latest that is known",
                                         header.file_version, kNewestVdbVersion));
    }
    return field;
  });
}

}  // namespace isoextract
