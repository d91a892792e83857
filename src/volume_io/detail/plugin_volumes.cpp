#include "volume_io/detail/plugin_volumes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include <volume_plugin.h>
#include "base/checked.hpp"
#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "files/unpacked_files.hpp"
#include "plugin_host/plugin_kinds.hpp"
#include "plugin_host/plugin_samples.hpp"
#include "plugin_host/plugin_session.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/detail/grid_choice.hpp"
#include "volume_io/detail/sample_store.hpp"
#include "volume_io/detail/slice_stack.hpp"

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
  PluginFormat(FormatDescription described, const plugin_host::PluginTable& table, plugin_host::PluginFolders folders)
      : VolumeFormat(std::move(described)),
        table_(table),
        library_(plugin_host::kVolumePlugins, about().id, std::move(folders), table.package) {}

  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    const auto has_magic = [&](const plugin_host::PluginMagic& magic) {
      return start.bytes.size() >= magic.offset && start.bytes.size() - magic.offset >= magic.bytes.size() &&
             std::ranges::equal(start.bytes.subspan(magic.offset, magic.bytes.size()), magic.bytes);
    };
    const std::string_view text(reinterpret_cast<const char*>(start.bytes.data()), start.bytes.size());
    const auto has_text = [&](const std::string& part) { return text.find(part) != std::string_view::npos; };
    return !start.packed &&
           (std::ranges::any_of(table_.magic, has_magic) || std::ranges::any_of(table_.contains, has_text));
  }

  [[nodiscard]] bool probe_folder(const fs::path& folder, const Context& context) const override {
    for (const std::string& entry : table_.folders) {
      std::error_code none;
      if (entry != "*" ? fs::exists(folder / entry, none) : has_file_of_format(folder, context)) return true;
    }
    return false;
  }

  [[nodiscard]] Result<std::vector<GridInfo>> list(const std::string& input, const ReadOptions& options,
                                                   const Context& context) const override {
    const auto visit = TRY(visit_input(input, options, context));
    const std::string label = files::input_label(input);
    const auto grids = TRY(describe(label, visit->list()));
    if (options.volume) {
      const auto chosen = choose_grid(label, grids, options.grid);
      if (chosen) TRY(choose_volume(label, grids[*chosen].volumes, options.volume));
    }
    return grids;
  }

  [[nodiscard]] Result<std::vector<fs::path>> files(const std::string& input, const ReadOptions& options,
                                                    const Context& context) const override {
    std::vector<fs::path> files;
    std::error_code none;
    const auto slices = TRY(slices_of(input));
    if (!slices.empty()) return std::vector<fs::path>(slices.begin(), slices.end());
    if (!fs::is_directory(input, none)) files.emplace_back(input);
    const auto visit = TRY(visit_input(input, options, context));
    const isoextract_volume_list& list = visit->list();
    for (std::size_t i = 0; list.files != nullptr && i < list.file_count; ++i) {
      const fs::path file = plugin_host::plugin_text(list.files[i]);
      if (file != input) files.push_back(file);
    }
    return files;
  }

  [[nodiscard]] Result<field::ScalarField> open(const std::string& input, const ReadOptions& options,
                                                const Context& context) const override {
    context.progress().begin("reading", 0);
    const auto visit = TRY(visit_input(input, options, context));
    const isoextract_volume_list& list = visit->list();
    const std::string label = files::input_label(input);
    const auto grids = TRY(describe(label, list));
    const auto chosen = TRY(choose_grid(label, grids, options.grid));

    const isoextract_volume_grid& grid = list.grids[chosen];
    const GridInfo& info = grids[chosen];
    field::ScalarField field;
    field.source = label;
    field.name = info.name;
    if (grids.size() > 1 || !field.name.empty()) {
      field.grids = grids.size();
      field.grid = info.label;
    } else {
      field.name = stem_of(input);
    }
    field.format = visit->format();
    field.world_space = info.world_space;
    field.length_unit = info.length_unit;
    field.creator = info.creator;
    field.labels = info.labels;
    field.time_unit = info.time_unit;
    field.is_sampled = grid.is_sampled != 0 && options.sampling.has_value();
    if (grid.kind == ISOEXTRACT_LEVEL_SET) field.kind = field::FieldKind::level_set;
    if (std::string note = printable(plugin_host::plugin_text(list.note), 300); !note.empty()) {
      field.notes.push_back({NoteId::plugin_output, std::move(note)});
    }
    plugin_host::VolumeSelection selection;
    selection.grid = chosen;
    selection.volume = TRY(choose_volume(label, info.volumes, options.volume));
    const auto component = TRY(choose_component(label, info.components, options.component, info.component_names));
    selection.component = component ? static_cast<std::int64_t>(*component) : ISOEXTRACT_COMPONENT_LENGTH;
    // The plug-in has already applied the scale to lengths.
    if (component) field.scale = {grid.slope, grid.intercept};
    if (!info.volume_times.empty()) field.time = info.volume_times[static_cast<std::size_t>(selection.volume)];
    if (grid.is_sparse != 0) {
      TRY(read_sparse(*visit, label, selection, field));
      TRY(set_placement(field, frame_of(grid), options));
      return field;
    }
    TRY(read_box(*visit, label, grid, selection, options, context, field));
    return field;
  }

 private:
  [[nodiscard]] bool has_file_of_format(const fs::path& folder, const Context& context) const {
    // Limits that suffice: a folder of slices has few other files in it and few folders above it.
    constexpr int kMostTried = 32;
    constexpr int kMostDepth = 3;
    int tried = 0;
    std::error_code error;
    for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error), end;
         !error && at != end && tried < kMostTried; at.increment(error)) {
      std::error_code none;
      if (at.depth() >= kMostDepth) at.disable_recursion_pending();
      if (!at->is_regular_file(none)) continue;
      ++tried;
      const auto file = files::InputFile::open(at->path(), context);
      const auto start = file ? files::first_bytes(*file, files::kStartBytes) : tl::unexpected(Error());
      if (start && probe({at->path(), *start, false})) return true;
    }
    return false;
  }

  // Returns the input as the plug-in gets it.
  Result<plugin_host::VolumeInput> describe_input(const std::string& input, const ReadOptions& options,
                                                  const Context& context) const {
    plugin_host::VolumeInput wanted;
    wanted.name = files::input_label(input);
    wanted.path = input;
    wanted.context = context;
    wanted.volume = static_cast<std::uint64_t>(std::max<std::int64_t>(0, options.volume.value_or(0)));
    wanted.level = options.level.value_or(0);
    if (options.sampling) wanted.spacing = {options.sampling->x, options.sampling->y, options.sampling->z};
    wanted.resamples = options.resamples;
    wanted.files = TRY(slices_of(input));
    if (!wanted.files.empty()) wanted.path = wanted.files.front();
    std::error_code none;
    fs::path folder = wanted.path;
    if (!fs::is_directory(folder, none)) {
      folder = folder.parent_path();
      const auto file = TRY(files::InputFile::open(wanted.path, context));
      if (wanted.files.empty()) wanted.path = files::openable_path(file);
      auto& start =
          wanted.start.emplace(static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), files::kStartBytes)));
      TRY(file.read_at(0, start));
      wanted.bytes = file.size();
      for (std::size_t i = 1; i < wanted.files.size(); ++i) wanted.bytes += fs::file_size(wanted.files[i], none);
      // A file may be one of a series in its folder.
      if (std::ranges::count(table_.folders, "*") > 0) {
        wanted.bytes += bytes_in<fs::directory_iterator>(folder.empty() ? "." : folder);
      }
      return wanted;
    }
    wanted.bytes += bytes_in<fs::recursive_directory_iterator>(folder);
    return wanted;
  }

  // Returns the files of a stack in order; none for other inputs.
  [[nodiscard]] Result<std::vector<std::string>> slices_of(const std::string& input) const {
    if (!about().takes_slices) return std::vector<std::string>();
    auto slices = TRY(find_slices(input, *this));
    return std::move(slices).value_or(std::vector<std::string>());
  }

  // Returns the bytes of the files among the first kMostFiles entries that the iterator finds.
  template <class Iterator>
  static std::uint64_t bytes_in(const fs::path& folder) {
    constexpr std::size_t kMostFiles = 10000;
    std::uint64_t bytes = 0;
    std::size_t count = 0;
    std::error_code error;
    for (Iterator at(folder, fs::directory_options::skip_permission_denied, error), end;
         !error && at != end && count < kMostFiles; at.increment(error), ++count) {
      std::error_code none;
      if (at->is_regular_file(none)) bytes += at->file_size(none);
    }
    return bytes;
  }

  // Opens an input with the plug-in, which lists its grids.
  Result<std::unique_ptr<plugin_host::VolumeSession>> visit_input(const std::string& input, const ReadOptions& options,
                                                                  const Context& context) const {
    const auto wanted = TRY(describe_input(input, options, context));
    auto visit = plugin_host::open_volume_session(library_, about().id, wanted);
    if (!visit) return visit;
    if ((*visit)->list().grids == nullptr && (*visit)->list().count > 0) {
      return refused(files::input_label(input), "a null list of grids");
    }
    return visit;
  }

  // Returns the error for invalid output of the plug-in; the file is not at fault.
  tl::unexpected<Error> refused(const std::string& input, const std::string& what) const {
    return fail(ErrorCode::input, fmt::format("{}: the plug-in for {} returns {}", input, about().id, what));
  }

  // Sets the texts, times and labels of a grid in `info`.
  static void describe_contents(const isoextract_volume_grid& grid, GridInfo& info) {
    using plugin_host::plugin_text;
    info.type = printable(plugin_text(grid.type_name), 80);
    info.world_space = printable(plugin_text(grid.world_space), 80);
    info.length_unit = printable(plugin_text(grid.length_unit), 80);
    info.time_unit = printable(plugin_text(grid.time_unit), 80);
    info.component_names = printable(plugin_text(grid.component_names), 200);
    if (grid.volume_times != nullptr) {
      info.volume_times.assign(grid.volume_times, grid.volume_times + grid.volumes);
    }
    for (std::size_t i = 0; grid.labels != nullptr && i < grid.label_count; ++i) {
      const isoextract_volume_label& label = grid.labels[i];
      field::LabelName& named = info.labels.emplace_back();
      named.label = label.value;
      named.name = plugin_text(label.name);
      if (label.has_color != 0) {
        named.color = glm::clamp(glm::dvec3(label.color[0], label.color[1], label.color[2]), 0.0, 1.0);
      }
    }
    std::ranges::sort(info.labels, {}, &field::LabelName::label);
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
        if (grid.components == 0 || grid.volumes == 0) return refused(input, "a grid without components or volumes");
        const auto dims = TRY(checked_dims(input, {grid.dims[0], grid.dims[1], grid.dims[2]}, *type));
        const auto count = checked_product(grid.components, grid.volumes);
        if (!count) return refused(input, "more components and volumes than 64 bits can count");
        TRY(check_volume_count(input, dims, *type, *count));
        info = dense_grid(std::move(info.name), dims, *type);
        info.components = grid.components;
        info.volumes = grid.volumes;
      } else if (grid.sample_type != ISOEXTRACT_NOT_SCALAR) {
        return refused(input, fmt::format("samples of an unknown type ({})", grid.sample_type));
      }
      if (type) info.kind = grid.kind == ISOEXTRACT_LEVEL_SET ? field::FieldKind::level_set : field::FieldKind::density;
      info.creator = printable(plugin_host::plugin_text(list.creator), 200);
      describe_contents(grid, info);
      grids.push_back(std::move(info));
    }
    label_grids(grids);
    return grids;
  }

  static Frame frame_of(const isoextract_volume_grid& grid) {
    Frame frame{plugin_host::affine_of(grid.index_to_world), {}};
    frame.stated = grid.has_placement != 0;
    return frame;
  }

  // Adds the plug-in's part counts and notes about the samples that it has read.
  void take_facts(const plugin_host::VolumeSession& visit, const isoextract_volume_samples& samples,
                  field::ScalarField& field) const {
    field.parts = {samples.parts_read, samples.parts};
    if (const std::string note = printable(plugin_host::plugin_text(samples.note), 300); !note.empty())
      field.notes.push_back({NoteId::plugin_output, note});
    if (const std::string printed = visit.printed(); !printed.empty()) {
      field.notes.push_back(
          {NoteId::plugin_output, fmt::format("the plug-in for {} printed: {}", about().id, printed)});
    }
  }

  Result<void> read_sparse(plugin_host::VolumeSession& visit, const std::string& input,
                           const plugin_host::VolumeSelection& selection, field::ScalarField& field) const {
    const isoextract_volume_grid& grid = visit.list().grids[selection.grid];
    auto visited = TRY(visit.open(selection));
    TRY(visit.finish());
    take_facts(visit, *visited.samples, field);
    const isoextract_sparse_samples* given = visited.samples->sparse;
    if (given == nullptr) return refused(input, "no samples, expected sparse ones");
    if (given->sample_type != grid.sample_type)
      return refused(input, "samples of another type than in its list of grids");
    auto sparse = plugin_host::sparse_samples_of(*given, visited.owner);
    if (!sparse) return refused(input, sparse.error());
    field.samples = std::move(*sparse);
    return {};
  }

  // Reads the samples of a full box, or of the part that options.region needs.
  Result<void> read_box(plugin_host::VolumeSession& visit, const std::string& input, const isoextract_volume_grid& grid,
                        plugin_host::VolumeSelection& selection, const ReadOptions& options, const Context& context,
                        field::ScalarField& field) const {
    field::DenseSamples dense;
    dense.type = *plugin_host::sample_type_of(grid.sample_type);
    if (selection.component == ISOEXTRACT_COMPONENT_LENGTH) dense.type = type_of_lengths(dense.type);
    dense.dims = {static_cast<int>(grid.dims[0]), static_cast<int>(grid.dims[1]), static_cast<int>(grid.dims[2])};
    // Sets the placement for the dimensions of all samples, so that all of them are checked.
    field.samples = dense;
    TRY(set_placement(field, frame_of(grid), options));
    const field::IndexBox needed = samples_of_region(field.index_to_world, dense.dims, options.region);
    if (needed.min != glm::ivec3(0) || needed.max != dense.dims - 1) {
      dense.dims = needed.max - needed.min + 1;
      const glm::dvec3 shift(needed.min);
      field.index_to_world.offset += field.index_to_world.linear * shift;
      field.index_to_file.offset += field.index_to_file.linear * shift;
    }
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      selection.first[at] = static_cast<std::uint64_t>(needed.min[axis]);
      selection.count[at] = static_cast<std::uint64_t>(dense.dims[axis]);
    }
    const std::uint64_t bytes = sample_bytes(dense.dims, dense.type);
    // The samples of all components of a layer are in the plug-in's memory.
    const std::uint64_t components =
        selection.component == ISOEXTRACT_COMPONENT_LENGTH ? std::max<std::uint64_t>(grid.components, 1) : 0;
    if (prefers_file(bytes, context)) {
      auto store = SampleStore::make_in_file(dense.dims, dense.type, Error());
      if (store) return read_by_runs(visit, input, selection, dense, std::move(*store), components, context, field);
    }
    auto memory = context.reserve(bytes, fmt::format("{}: {}", input, describe_samples(dense.dims, dense.type)));
    if (!memory) {
      auto store = TRY(SampleStore::make_in_file(dense.dims, dense.type, std::move(memory.error())));
      return read_by_runs(visit, input, selection, dense, std::move(store), components, context, field);
    }
    const auto owner = std::make_shared<PluginSamples>();
    owner->box_memory = std::move(*memory);
    owner->visited = TRY(read_layers(visit, input, selection, dense));
    TRY(visit.finish());
    take_facts(visit, *owner->visited.samples, field);
    dense.data = owner->visited.box;
    dense.owner = owner;
    field.samples = std::move(dense);
    return {};
  }

  // Reads the box that `selection` states, which has dense.dims samples.
  Result<plugin_host::SessionSamples> read_layers(plugin_host::VolumeSession& visit, const std::string& input,
                                                  plugin_host::VolumeSelection& selection,
                                                  const field::DenseSamples& dense) const {
    selection.box_bytes = sample_bytes(dense.dims, dense.type);
    auto visited = TRY(visit.open(selection));
    if (visited.samples->filled != selection.box_bytes) {
      return refused(input, fmt::format("{} bytes, expected {} ({})", visited.samples->filled, selection.box_bytes,
                                        describe_samples(dense.dims, dense.type)));
    }
    return visited;
  }

  // Reads a box into the temporary file of `store`, a run of layers after the other. While it reads, the plug-in holds
  // `components` arrays of a run besides that of the result.
  Result<void> read_by_runs(plugin_host::VolumeSession& visit, const std::string& input,
                            plugin_host::VolumeSelection& selection, field::DenseSamples dense, SampleStore store,
                            std::uint64_t components, const Context& context, field::ScalarField& field) const {
    const int layers = dense.dims.z;
    dense.dims.z = 1;
    const std::uint64_t layer_bytes = sample_bytes(dense.dims, dense.type);
    const int run = layers_at_once(layer_bytes * (1 + components), layers, context);
    const std::uint64_t first = selection.first[2];
    std::uint64_t parts_read = 0;
    context.progress().begin("reading", static_cast<std::uint64_t>(layers));
    for (int z = 0; z < layers; z += run) {
      dense.dims.z = std::min(run, layers - z);
      selection.first[2] = first + static_cast<std::uint64_t>(z);
      selection.count[2] = static_cast<std::uint64_t>(dense.dims.z);
      const auto memory = TRY(context.reserve(sample_bytes(dense.dims, dense.type),
                                              fmt::format("{}: {}", input, describe_samples(dense.dims, dense.type))));
      const auto visited = TRY(read_layers(visit, input, selection, dense));
      const auto part = store.bytes().subspan(static_cast<std::size_t>(layer_bytes) * static_cast<std::size_t>(z),
                                              static_cast<std::size_t>(selection.box_bytes));
      std::memcpy(part.data(), visited.box, part.size());
      store.leave(part);
      context.progress().advance(static_cast<std::uint64_t>(dense.dims.z));
      parts_read += visited.samples->parts_read;
      if (z + run < layers) continue;
      TRY(visit.finish());
      take_facts(visit, *visited.samples, field);
      // A part in two runs was read twice.
      field.parts.read = std::min(parts_read, field.parts.of);
    }
    field.samples = std::move(store).finish(field.notes);
    return {};
  }

  static field::SampleType type_of_lengths(field::SampleType type) {
    const bool is_wide =
        type == field::SampleType::f64 || type == field::SampleType::i32 || type == field::SampleType::u32;
    return is_wide ? field::SampleType::f64 : field::SampleType::f32;
  }

  // Returns the index box of the samples that a world region needs, with two more beyond each face for gradients; the
  // box of all samples if the region meets none.
  static field::IndexBox samples_of_region(const field::Affine& index_to_world, const glm::ivec3& dims,
                                           const std::optional<field::Box>& region) {
    const field::IndexBox all{glm::ivec3(0), dims - 1};
    if (!region) return all;
    const field::Box wanted = field::image_of(index_to_world.inverse(), *region);
    field::IndexBox box = all;
    for (int axis = 0; axis < 3; ++axis) {
      const auto last = static_cast<double>(dims[axis] - 1);
      const double low = std::floor(wanted.min[axis]) - 2;
      const double high = std::ceil(wanted.max[axis]) + 2;
      if (!(low <= last && high >= 0)) return all;
      box.min[axis] = static_cast<int>(std::max(low, 0.0));
      box.max[axis] = static_cast<int>(std::min(high, last));
    }
    return box;
  }

  plugin_host::PluginTable table_;
  plugin_host::PluginLibrary library_;
};

FormatDescription describe_plugin(const plugin_host::PluginTable& table, const plugin_host::PluginFolders& folders) {
  const auto uses = [&](const char* what) { return std::ranges::count(table.uses, what) > 0; };
  FormatDescription about;
  about.id = table.id;
  about.title = table.title;
  about.extensions = table.extensions;
  about.has_grids = true;
  about.has_volumes = true;
  about.has_components = true;
  about.has_levels = uses("level");
  about.takes_slices = uses("slices");
  about.library = table.library;
  about.package = table.package;
  about.plugin = plugin_host::PluginLibrary(plugin_host::kVolumePlugins, table.id, folders).path();
  about.is_plugin = true;
  return about;
}

}  // namespace

std::unique_ptr<const VolumeFormat> make_plugin_format(FormatDescription about, plugin_host::PluginFolders folders) {
  return std::make_unique<const PluginFormat>(std::move(about), plugin_host::PluginTable(), std::move(folders));
}

std::vector<std::unique_ptr<const VolumeFormat>> find_plugin_formats(const plugin_host::PluginFolders& folders) {
  std::vector<std::unique_ptr<const VolumeFormat>> formats;
  for (const plugin_host::PluginTable& table :
       plugin_host::find_plugin_tables(folders, plugin_host::kVolumePlugins.name_start)) {
    if (table.id == plugin_host::kOpenVdbPlugin) continue;
    formats.push_back(std::make_unique<const PluginFormat>(describe_plugin(table, folders), table, folders));
  }
  return formats;
}

}  // namespace isoextract::volume_io
