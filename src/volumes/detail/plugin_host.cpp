#include "volumes/detail/plugin_host.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include <volume_plugin.h>
#include "base/printable.hpp"
#include "volumes/detail/dense_format.hpp"
#include "volumes/detail/file_start.hpp"
#include "volumes/detail/grid_choice.hpp"

namespace isoextract::volumes {
namespace {

namespace fs = std::filesystem;
using Plugin = isoextract_volume_plugin_v1;

const PluginKind kVolumePlugins{"isoextract-volume-", "isoextract_volume_plugin", ISOEXTRACT_VOLUME_PLUGIN_VERSION};

std::optional<field::SampleType> sample_type_of(std::int32_t type) {
  switch (type) {
    case ISOEXTRACT_U8: return field::SampleType::u8;
    case ISOEXTRACT_I8: return field::SampleType::i8;
    case ISOEXTRACT_U16: return field::SampleType::u16;
    case ISOEXTRACT_I16: return field::SampleType::i16;
    case ISOEXTRACT_U32: return field::SampleType::u32;
    case ISOEXTRACT_I32: return field::SampleType::i32;
    case ISOEXTRACT_F16: return field::SampleType::f16;
    case ISOEXTRACT_F32: return field::SampleType::f32;
    case ISOEXTRACT_F64: return field::SampleType::f64;
    default: return std::nullopt;
  }
}

std::string text_of(const char* text) { return text == nullptr ? std::string() : std::string(text); }

// A list or samples of a plug-in, given back in the end.
template <class T>
class Given {
 public:
  using Free = void (*)(T*);
  explicit Given(Free free) : free_(free) {}
  Given(const Given&) = delete;
  Given& operator=(const Given&) = delete;
  ~Given() {
    if (is_given) free_(&value);
  }

  T value{};
  bool is_given = false;

 private:
  Free free_;
};

using GivenList = Given<isoextract_volume_list>;

// Samples of a plug-in, and what is reserved for them.
struct PluginSamples {
  PluginSamples(Given<isoextract_volume_samples>::Free free, Reservation reserved)
      : samples(free), memory(std::move(reserved)) {}

  Given<isoextract_volume_samples> samples;
  Reservation memory;
};

class PluginFormat final : public VolumeFormat {
 public:
  PluginFormat(FormatDescription described, PluginFolders folders)
      : VolumeFormat(std::move(described)), library_(kVolumePlugins, about().id, std::move(folders)) {}

  [[nodiscard]] Result<std::vector<GridInfo>> list(const std::string& input, const ReadOptions& /*options*/,
                                                   const Context& context) const override {
    const auto plugin = plugin_for(input, context);
    if (!plugin) return tl::unexpected(plugin.error());
    GivenList list((*plugin)->free_list);
    if (auto listed = fill_list(**plugin, input, list); !listed) return tl::unexpected(listed.error());
    return describe(input, list.value);
  }

  [[nodiscard]] Result<std::vector<fs::path>> files(const std::string& input, const ReadOptions& /*options*/,
                                                    const Context& /*context*/) const override {
    return std::vector<fs::path>{input};
  }

  [[nodiscard]] Result<field::ScalarField> open(const std::string& input, const ReadOptions& options,
                                                const Context& context) const override {
    const auto plugin = plugin_for(input, context);
    if (!plugin) return tl::unexpected(plugin.error());
    context.progress().begin("reading", 0);
    GivenList list((*plugin)->free_list);
    if (auto listed = fill_list(**plugin, input, list); !listed) return tl::unexpected(listed.error());
    const auto grids = describe(input, list.value);
    if (!grids) return tl::unexpected(grids.error());
    const auto chosen = choose_grid(input, *grids, options.grid);
    if (!chosen) return tl::unexpected(chosen.error());

    const isoextract_volume_grid& grid = list.value.grids[*chosen];
    field::ScalarField field;
    field.source = input;
    field.name = text_of(grid.name);
    if (grids->size() > 1 || !field.name.empty()) {
      field.grids = grids->size();
      field.grid = (*grids)[*chosen].label;
    } else {
      field.name = stem_of(input);
    }
    field.format = text_of((*plugin)->format);
    field.world_space = text_of(grid.world_space);
    if (grid.kind == ISOEXTRACT_LEVEL_SET) field.kind = field::FieldKind::level_set;
    auto samples = read_samples(**plugin, input, *chosen, grid, context);
    if (!samples) return tl::unexpected(samples.error());
    field.samples = std::move(*samples);
    Frame frame;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        frame.index_to_world.linear[column][row] = grid.index_to_world[4 * row + column];
      }
      frame.index_to_world.offset[row] = grid.index_to_world[4 * row + 3];
    }
    if (auto placed = set_frame(field, frame, options); !placed) return tl::unexpected(placed.error());
    return field;
  }

 private:
  // The plug-in, opened, if it takes the file.
  Result<const Plugin*> plugin_for(const std::string& input, const Context& context) const {
    if (files::is_standard_input(input)) {
      return fail(ErrorKind::input,
                  fmt::format("{}: plug-ins, such as the one for {}, read files by their paths",
                              files::kStandardInputName, about().id),
                  "write the data to a file first");
    }
    const auto opened = library_.opened(input);
    if (!opened) return tl::unexpected(opened.error());
    const auto* plugin = static_cast<const Plugin*>(*opened);
    const auto file = files::InputFile::open(input, context);
    if (!file) return tl::unexpected(file.error());
    // As they lie in the file: first_bytes() would unpack them.
    std::vector<std::byte> start(static_cast<std::size_t>(std::min<std::uint64_t>(file->size(), kStartBytes)));
    if (auto read = file->read_at(0, start); !read) return tl::unexpected(read.error());
    if (plugin->probe(reinterpret_cast<const unsigned char*>(start.data()), start.size(), input.c_str()) == 0) {
      return fail(ErrorKind::input, fmt::format("{}: not a file of the format {}; it starts with '{}'", input,
                                                about().id, printable(start, 16)));
    }
    return plugin;
  }

  Error failed(const Plugin& plugin, const std::string& input) const {
    const std::string text = text_of(plugin.error_text());
    return {ErrorKind::input, fmt::format("{}: {}", input, text.empty() ? "cannot be read" : text), {}};
  }

  // What is wrong with what the plug-in gives, not with the file.
  tl::unexpected<Error> refused(const std::string& input, const std::string& what) const {
    return fail(ErrorKind::input, fmt::format("{}: the plug-in for {} gives {}", input, about().id, what));
  }

  Result<void> fill_list(const Plugin& plugin, const std::string& input, GivenList& list) const {
    if (plugin.list(input.c_str(), &list.value) != 0) return tl::unexpected(failed(plugin, input));
    list.is_given = true;
    if (list.value.grids == nullptr && list.value.count > 0) return refused(input, "a list of grids that is not there");
    return {};
  }

  Result<std::vector<GridInfo>> describe(const std::string& input, const isoextract_volume_list& list) const {
    std::vector<GridInfo> grids;
    for (std::size_t i = 0; i < list.count; ++i) {
      const isoextract_volume_grid& grid = list.grids[i];
      const auto type = sample_type_of(grid.sample_type);
      GridInfo info;
      info.name = text_of(grid.name);
      if (type) {
        const auto dims = checked_dims(input, {grid.dims[0], grid.dims[1], grid.dims[2]}, *type);
        if (!dims) return tl::unexpected(dims.error());
        info = dense_grid(std::move(info.name), *dims, *type);
        info.kind = grid.kind == ISOEXTRACT_LEVEL_SET ? field::FieldKind::level_set : field::FieldKind::density;
      } else if (grid.sample_type != ISOEXTRACT_NOT_SCALAR) {
        return refused(input, fmt::format("samples of an unknown type ({})", grid.sample_type));
      }
      info.type = printable(text_of(grid.type_name), 80);
      grids.push_back(std::move(info));
    }
    label_grids(grids);
    return grids;
  }

  // Those of a scalar grid, whose sizes were checked.
  Result<field::DenseSamples> read_samples(const Plugin& plugin, const std::string& input, std::size_t index,
                                           const isoextract_volume_grid& grid, const Context& context) const {
    field::DenseSamples dense;
    dense.type = *sample_type_of(grid.sample_type);
    dense.dims = {static_cast<int>(grid.dims[0]), static_cast<int>(grid.dims[1]), static_cast<int>(grid.dims[2])};
    const std::uint64_t expected = sample_bytes(dense.dims, dense.type);
    const std::string what = describe_samples(dense.dims, dense.type);
    auto memory = context.reserve(expected, fmt::format("{}: {}", input, what));
    if (!memory) return tl::unexpected(memory.error());
    const auto owner = std::make_shared<PluginSamples>(plugin.free_samples, std::move(*memory));
    if (plugin.open(input.c_str(), index, &owner->samples.value) != 0) return tl::unexpected(failed(plugin, input));
    owner->samples.is_given = true;
    const isoextract_volume_samples& samples = owner->samples.value;
    if (samples.data == nullptr) return refused(input, fmt::format("no samples, expected {}", what));
    if (samples.bytes != expected) {
      return refused(input, fmt::format("{} bytes, expected {} ({})", samples.bytes, expected, what));
    }
    if (reinterpret_cast<std::uintptr_t>(samples.data) % field::sample_size(dense.type) != 0) {
      return refused(input, "samples that are not aligned for their type");
    }
    dense.data = samples.data;
    dense.owner = owner;
    return dense;
  }

  PluginLibrary library_;
};

FormatDescription describe_plugin(PluginTable table) {
  FormatDescription about;
  about.id = std::move(table.id);
  about.title = std::move(table.title);
  about.extensions = std::move(table.extensions);
  about.has_grids = true;
  return about;
}

}  // namespace

std::vector<std::unique_ptr<const VolumeFormat>> find_plugin_formats(const PluginFolders& folders) {
  std::vector<std::unique_ptr<const VolumeFormat>> formats;
  for (PluginTable& table : find_plugin_tables(folders, kVolumePlugins.name_start)) {
    formats.push_back(std::make_unique<const PluginFormat>(describe_plugin(std::move(table)), folders));
  }
  return formats;
}

}  // namespace isoextract::volumes
