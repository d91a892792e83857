// OpenVDB's files: selects a grid and reads its transform, and its tree as sparse samples.
#include <algorithm>
#include <optional>
#include <unordered_map>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "plugin_host/plugin_kinds.hpp"
#include "volume_io/detail/formats.hpp"
#include "volume_io/detail/grid_choice.hpp"
#include "volume_io/detail/placement.hpp"
#include "volume_io/detail/plugin_volumes.hpp"
#include "volume_io/vdb/vdb_header.hpp"
#include "volume_io/vdb/vdb_plugin.hpp"
#include "volume_io/vdb/vdb_transform.hpp"
#include "volume_io/vdb/vdb_tree.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::string_view kVdbStart(" BDV\0\0\0\0", 8);
constexpr std::string_view kLevelSetClass = "level set";
constexpr std::string_view kFogClass = "fog volume";

// Calls use(std::type_identity<Value>{}) with the value type of a scalar grid; returns false for all other grids.
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
  return value_layout(record, sizeof(Value), std::is_floating_point_v<Value> ? sizeof(field::Half) : sizeof(Value));
}

// Leaves the cursor at the grid's tree, limited to the grid's range of the file.
Frame read_transform_of(VdbCursor& cursor, const VdbGridRecord& record) {
  cursor.set_end(record.end_position);
  cursor.seek(record.transform_position);
  return read_vdb_transform(cursor);
}

// The grids of a header by their unique names.
class GridsByName {
 public:
  explicit GridsByName(const VdbHeader& header) {
    for (const VdbGridRecord& record : header.grids) records_.emplace(record.unique_name, &record);
  }

  // Returns the record that owns the tree: `record`, or the grid of which it is an instance.
  [[nodiscard]] const VdbGridRecord& tree_owner(const VdbGridRecord& record) const {
    if (record.instance_parent.empty()) return record;
    const auto parent = records_.find(record.instance_parent);
    if (parent == records_.end() || !parent->second->instance_parent.empty() ||
        parent->second->tree_type != record.tree_type) {
      throw InvalidVdb(fmt::format(
          "grid '{}' shares the tree of another grid, which is missing, has another type or itself shares a tree",
          printable(record.name, 80)));
    }
    return *parent->second;
  }

 private:
  std::unordered_map<std::string_view, const VdbGridRecord*> records_;
};

struct VoxelCount {
  std::uint64_t voxels = 0;
  field::IndexBox box;
};

// Counts active voxels of files that do not store the counts. Reads each tree once, even if several grids share it;
// skips trees that cannot be read.
class VoxelCounter {
 public:
  VoxelCounter(VdbCursor& cursor, const files::InputFile& file, const VdbHeader& header)
      : cursor_(cursor), file_(file), grids_(header) {}

  std::optional<VoxelCount> count(const VdbGridRecord& record) {
    try {
      const VdbGridRecord& owner = grids_.tree_owner(record);
      const auto [known, is_new] = counts_.try_emplace(owner.transform_position);
      if (is_new) known->second = count_tree(owner);
      return known->second;
    } catch (const InvalidVdb&) {
      return std::nullopt;
    } catch (const UnsupportedVdb&) {
      return std::nullopt;
    } catch (const VdbReadError&) {
      return std::nullopt;
    }
  }

 private:
  std::optional<VoxelCount> count_tree(const VdbGridRecord& owner) {
    std::optional<VoxelCount> count;
    visit_scalar_tree(owner.tree_type, [&]<class Value>(std::type_identity<Value>) {
      static_cast<void>(read_transform_of(cursor_, owner));
      const VdbTreeLimits limits{file_.context(), file_.name(), printable(owner.name, 80)};
      const VdbTopology topology = read_vdb_topology<Value>(cursor_, layout_of<Value>(owner), limits);
      count = VoxelCount{topology.samples.active_voxels, topology.samples.active_box};
    });
    return count;
  }

  VdbCursor& cursor_;
  const files::InputFile& file_;
  GridsByName grids_;
  std::unordered_map<std::uint64_t, std::optional<VoxelCount>> counts_;  // by the position of the owner's transform
};

// OpenVDB writes "invariant" as the default if the type was never set; "covariant" (gradients) has no matching kind.
std::optional<AttributeKind> kind_of_vectors(std::string_view vector_type) {
  if (vector_type == "contravariant relative") return AttributeKind::vector;
  if (vector_type == "contravariant absolute") return AttributeKind::point;
  if (vector_type == "covariant normalize") return AttributeKind::normal;
  return std::nullopt;
}

std::vector<GridInfo> describe_grids(VdbCursor& cursor, const files::InputFile& file, const VdbHeader& header,
                                     bool plugin_is_missing) {
  VoxelCounter counter(cursor, file, header);
  std::vector<GridInfo> grids;
  for (const VdbGridRecord& record : header.grids) {
    const bool counted = record.voxels && record.box;
    const auto count = counted ? std::optional(VoxelCount{*record.voxels, *record.box}) : counter.count(record);
    GridInfo info;
    info.name = record.name;
    info.type = printable(record.value_type, 80);
    info.scalar = visit_scalar_tree(record.tree_type, [](auto) {});
    if (record.grid_class == kLevelSetClass) info.kind = field::FieldKind::level_set;
    if (record.grid_class == kFogClass) info.kind = field::FieldKind::density;
    info.creator = printable(record.creator, 200);
    info.kind_of_vectors = kind_of_vectors(record.vector_type);
    info.vectors_in_voxels = record.in_local_space;
    info.placement_problem = printable(record.placement_problem, 300);
    if (count) {
      info.box = count->box;
      info.voxels = count->voxels;
    }
    grids.push_back(std::move(info));
  }
  label_grids(grids);
  mark_plugin_grids(header, grids, plugin_is_missing);
  return grids;
}

Result<field::ScalarField> read_grid(const files::InputFile& file, VdbCursor& cursor, const VdbHeader& header,
                                     const VdbGridRecord& record, const ReadOptions& options) {
  field::ScalarField field;
  field.source = file.name();
  field.name = record.name;
  field.format = "OpenVDB";
  if (record.grid_class == kLevelSetClass) field.kind = field::FieldKind::level_set;

  const Frame frame = read_transform_of(cursor, record);
  TRY(set_placement(field, frame, options));
  const VdbGridRecord& owner = GridsByName(header).tree_owner(record);
  if (&owner != &record) static_cast<void>(read_transform_of(cursor, owner));
  const VdbTreeLimits limits{file.context(), file.name(), printable(record.name, 80)};
  visit_scalar_tree(record.tree_type, [&]<class Value>(std::type_identity<Value>) {
    const auto layout = layout_of<Value>(owner);
    VdbTopology topology = read_vdb_topology<Value>(cursor, layout, limits);
    field.samples = read_vdb_leaves<Value>(cursor, layout, limits, std::move(topology));
  });
  return field;
}

// Calls work() and turns its exceptions into errors that name the file.
template <class F>
auto with_messages(const files::InputFile& file, F&& work) -> decltype(work()) {
  if (!files::starts_with(files::first_bytes(file, files::kStartBytes).value_or(std::vector<std::byte>{}), kVdbStart)) {
    return files::bad_signature_error(file, "a VDB file", "' BDV'");
  }
  const auto is = [&](const char* what, const std::exception& why) {
    return fail(ErrorCode::input,
                fmt::format("{}: the VDB file is {}: {}", file.name(), what, printable(why.what(), 300)));
  };
  try {
    return work();
  } catch (const VdbReadError& refused) {
    return tl::unexpected(refused.error);
  } catch (const InvalidVdb& damage) {
    return is("damaged", damage);
  } catch (const UnsupportedVdb& unknown) {
    return is("not supported", unknown);
  }
}

Result<std::vector<GridInfo>> list_vdb_grids(const files::InputFile& file, bool plugin_is_missing) {
  return with_messages(file, [&]() -> Result<std::vector<GridInfo>> {
    VdbCursor cursor(file);
    const VdbHeader header = read_vdb_header(cursor);
    return describe_grids(cursor, file, header, plugin_is_missing);
  });
}

Result<field::ScalarField> read_vdb(const std::string& input, const files::InputFile& file, const VolumeFormat& plugin,
                                    const ReadOptions& options) {
  return with_messages(file, [&]() -> Result<field::ScalarField> {
    file.context().progress().begin("reading", 0);
    VdbCursor cursor(file);
    const VdbHeader header = read_vdb_header(cursor);
    const std::vector<GridInfo> grids = describe_grids(cursor, file, header, false);
    if (const auto wanted = choose_plugin_grid(cursor, header, grids, options)) {
      return read_by_plugin(plugin, input, *wanted, header, grids, options, file.context());
    }
    const auto chosen = TRY(choose_grid(file.name(), grids, options.grid));
    auto field = read_grid(file, cursor, header, header.grids[chosen], options);
    if (!field) return field;
    field->grids = grids.size();
    field->grid = grids[chosen].label;
    field->creator = grids[chosen].creator;
    if (!options.grid && grids.size() > 1) {
      field->notes.push_back(
          {NoteId::grid_chosen, fmt::format("the reader takes grid '{}', the only scalar one of {} grids",
                                            grids[chosen].label, grids.size())});
    }
    if (header.file_version > kNewestVdbVersion) {
      field->notes.push_back(
          {NoteId::newer_version,
           fmt::format("the file's version {} is newer than {}, the latest version that the reader knows",
                       header.file_version, kNewestVdbVersion)});
    }
    return field;
  });
}

class VdbFormat final : public VolumeFormat {
 public:
  explicit VdbFormat(plugin_host::PluginFolders folders)
      : VolumeFormat({.id = "vdb",
                      .title = "OpenVDB grids of float, double or int32; others by a plug-in",
                      .extensions = {".vdb"},
                      .prefix = {},
                      .has_grids = true}),
        plugin_is_there_(
            plugin_host::PluginLibrary(plugin_host::kVolumePlugins, plugin_host::kOpenVdbPlugin, folders).is_there()),
        plugin_(make_plugin_format({.id = plugin_host::kOpenVdbPlugin, .title = about().title, .has_grids = true},
                                   std::move(folders))) {}

  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    return !start.packed && files::starts_with(start.bytes, kVdbStart);
  }

  [[nodiscard]] Result<std::vector<GridInfo>> list(const std::string& input, const ReadOptions& /*options*/,
                                                   const Context& context) const override {
    const auto file = TRY(files::InputFile::open(input, context));
    return list_vdb_grids(file, !plugin_is_there_);
  }

  [[nodiscard]] Result<std::vector<std::filesystem::path>> files(const std::string& input,
                                                                 const ReadOptions& /*options*/,
                                                                 const Context& /*context*/) const override {
    return std::vector<std::filesystem::path>{input};
  }

  [[nodiscard]] Result<field::ScalarField> open(const std::string& input, const ReadOptions& options,
                                                const Context& context) const override {
    const auto file = TRY(files::InputFile::open(input, context));
    return read_vdb(input, file, *plugin_, options);
  }

 private:
  bool plugin_is_there_;
  std::unique_ptr<const VolumeFormat> plugin_;
};

}  // namespace

std::unique_ptr<const VolumeFormat> make_vdb_format(plugin_host::PluginFolders folders) {
  return std::make_unique<const VdbFormat>(std::move(folders));
}

const VolumeFormat& vdb_format() {
  static const VdbFormat format(plugin_host::plugin_folders());
  return format;
}

}  // namespace isoextract::volume_io
