#include "volume_io/detail/plugin_volumes.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include <volume_plugin.h>
#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "plugin_host/plugin_kinds.hpp"
#include "plugin_host/plugin_samples.hpp"
#include "plugin_host/plugin_session.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/detail/grid_choice.hpp"

namespace isoextract::volume_io {
namespace {

namespace fs = std::filesystem;
// A plug-in's samples, with the reservation for a full box.
struct PluginSamples {
  Reservation box_memory;
  plugin_host::SessionSamples visited;
};

class PluginFormat final : public VolumeFormat {
 public:
  PluginFormat(FormatDescription described, plugin_host::PluginFolders folders)
      : VolumeFormat(std::move(described)), library_(plugin_host::kVolumePlugins, about().id, std::move(folders)) {}

  [[nodiscard]] Result<std::vector<GridInfo>> list(const std::string& input, const ReadOptions& /*options*/,
                                                   const Context& context) const override {
    const auto visit = TRY(visit_file(input, context));
    return describe(input, visit->list());
  }

  [[nodiscard]] Result<std::vector<fs::path>> files(const std::string& input, const ReadOptions& /*options*/,
                                                    const Context& /*context*/) const override {
    return std::vector<fs::path>{input};
  }

  [[nodiscard]] Result<field::ScalarField> open(const std::string& input, const ReadOptions& options,
                                                const Context& context) const override {
    context.progress().begin("reading", 0);
    const auto visit = TRY(visit_file(input, context));
    const isoextract_volume_list& list = visit->list();
    const auto grids = TRY(describe(input, list));
    const auto chosen = TRY(choose_grid(input, grids, options.grid));

    const isoextract_volume_grid& grid = list.grids[chosen];
    field::ScalarField field;
    field.source = input;
    field.name = plugin_host::plugin_text(grid.name);
    if (grids.size() > 1 || !field.name.empty()) {
      field.grids = grids.size();
      field.grid = grids[chosen].label;
    } else {
      field.name = stem_of(input);
    }
    field.format = visit->format();
    field.world_space = plugin_host::plugin_text(grid.world_space);
    if (grid.kind == ISOEXTRACT_LEVEL_SET) field.kind = field::FieldKind::level_set;
    TRY(read_samples(*visit, input, chosen, context, field));
    TRY(set_placement(field, {plugin_host::affine_of(grid.index_to_world), {}}, options));
    return field;
  }

 private:
  // Opens a file with the plug-in, which lists its grids.
  Result<std::unique_ptr<plugin_host::VolumeSession>> visit_file(const std::string& input,
                                                                 const Context& context) const {
    if (files::is_standard_input(input)) {
      return fail(ErrorCode::input,
                  fmt::format("{}: the plug-in for {} cannot read it, because it needs the path of a file",
                              files::kStandardInputName, about().id),
                  "write the data to a file first");
    }
    const auto file = TRY(files::InputFile::open(input, context));
    auto visit = plugin_host::open_volume_session(library_, about().id, file);
    if (!visit) return visit;
    if ((*visit)->list().grids == nullptr && (*visit)->list().count > 0) {
      return refused(input, "a null list of grids");
    }
    return visit;
  }

  // Returns the error for invalid output of the plug-in; the file is not at fault.
  tl::unexpected<Error> refused(const std::string& input, const std::string& what) const {
    return fail(ErrorCode::input, fmt::format("{}: the plug-in for {} returns {}", input, about().id, what));
  }

  Result<std::vector<GridInfo>> describe(const std::string& input, const isoextract_volume_list& list) const {
    std::vector<GridInfo> grids;
    for (std::size_t i = 0; i < list.count; ++i) {
      const isoextract_volume_grid& grid = list.grids[i];
      const auto type = plugin_host::sample_type_of(grid.sample_type);
      GridInfo info;
      info.name = plugin_host::plugin_text(grid.name);
      if (type && grid.is_sparse != 0) {
        info.scalar = true;
        if (grid.has_counts != 0) {
          info.voxels = grid.active_voxels;
          info.box = {{grid.active_min[0], grid.active_min[1], grid.active_min[2]},
                      {grid.active_max[0], grid.active_max[1], grid.active_max[2]}};
        }
      } else if (type) {
        const auto dims = TRY(checked_dims(input, {grid.dims[0], grid.dims[1], grid.dims[2]}, *type));
        info = dense_grid(std::move(info.name), dims, *type);
      } else if (grid.sample_type != ISOEXTRACT_NOT_SCALAR) {
        return refused(input, fmt::format("samples of an unknown type ({})", grid.sample_type));
      }
      if (type) info.kind = grid.kind == ISOEXTRACT_LEVEL_SET ? field::FieldKind::level_set : field::FieldKind::density;
      info.type = printable(plugin_host::plugin_text(grid.type_name), 80);
      grids.push_back(std::move(info));
    }
    label_grids(grids);
    return grids;
  }

  // Reads the samples of a scalar grid; the sizes of a full box have been checked.
  Result<void> read_samples(plugin_host::VolumeSession& visit, const std::string& input, std::size_t index,
                            const Context& context, field::ScalarField& field) const {
    const isoextract_volume_grid& grid = visit.list().grids[index];
    const auto owner = std::make_shared<PluginSamples>();
    field::DenseSamples dense;
    if (grid.is_sparse == 0) {
      dense.type = *plugin_host::sample_type_of(grid.sample_type);
      dense.dims = {static_cast<int>(grid.dims[0]), static_cast<int>(grid.dims[1]), static_cast<int>(grid.dims[2])};
      owner->box_memory = TRY(context.reserve(sample_bytes(dense.dims, dense.type),
                                              fmt::format("{}: {}", input, describe_samples(dense.dims, dense.type))));
    }
    auto visited = TRY(visit.open(index, owner->box_memory.bytes()));
    owner->visited = std::move(visited);
    const isoextract_volume_samples& samples = *owner->visited.samples;
    if (const std::string note = printable(plugin_host::plugin_text(samples.note), 300); !note.empty())
      field.notes.push_back({NoteId::plugin_output, note});
    if (const std::string printed = visit.printed(); !printed.empty()) {
      field.notes.push_back(
          {NoteId::plugin_output, fmt::format("the plug-in for {} printed: {}", about().id, printed)});
    }
    return grid.is_sparse != 0 ? put_sparse(input, grid, owner, field) : put_box(input, std::move(dense), owner, field);
  }

  Result<void> put_sparse(const std::string& input, const isoextract_volume_grid& grid,
                          const std::shared_ptr<PluginSamples>& owner, field::ScalarField& field) const {
    const isoextract_sparse_samples* given = owner->visited.samples->sparse;
    if (given == nullptr) return refused(input, "no samples, expected sparse ones");
    if (given->sample_type != grid.sample_type)
      return refused(input, "samples of another type than in its list of grids");
    auto sparse = plugin_host::sparse_samples_of(*given, owner);
    if (!sparse) return refused(input, sparse.error());
    field.samples = std::move(*sparse);
    return {};
  }

  Result<void> put_box(const std::string& input, field::DenseSamples dense, const std::shared_ptr<PluginSamples>& owner,
                       field::ScalarField& field) const {
    const isoextract_volume_samples& samples = *owner->visited.samples;
    const std::uint64_t expected = sample_bytes(dense.dims, dense.type);
    const std::string what = describe_samples(dense.dims, dense.type);
    if (samples.data == nullptr) return refused(input, fmt::format("no samples, expected {}", what));
    if (samples.bytes != expected) {
      return refused(input, fmt::format("{} bytes, expected {} ({})", samples.bytes, expected, what));
    }
    if (reinterpret_cast<std::uintptr_t>(samples.data) % field::sample_size(dense.type) != 0) {
      return refused(input, "samples that are not aligned for their type");
    }
    dense.data = samples.data;
    dense.owner = owner;
    field.samples = std::move(dense);
    return {};
  }

  plugin_host::PluginLibrary library_;
};

FormatDescription describe_plugin(plugin_host::PluginTable table) {
  FormatDescription about;
  about.id = std::move(table.id);
  about.title = std::move(table.title);
  about.extensions = std::move(table.extensions);
  about.has_grids = true;
  return about;
}

}  // namespace

std::unique_ptr<const VolumeFormat> make_plugin_format(FormatDescription about, plugin_host::PluginFolders folders) {
  return std::make_unique<const PluginFormat>(std::move(about), std::move(folders));
}

std::vector<std::unique_ptr<const VolumeFormat>> find_plugin_formats(const plugin_host::PluginFolders& folders) {
  std::vector<std::unique_ptr<const VolumeFormat>> formats;
  for (plugin_host::PluginTable& table :
       plugin_host::find_plugin_tables(folders, plugin_host::kVolumePlugins.name_start)) {
    if (table.id != plugin_host::kOpenVdbPlugin)
      formats.push_back(make_plugin_format(describe_plugin(std::move(table)), folders));
  }
  return formats;
}

}  // namespace isoextract::volume_io
