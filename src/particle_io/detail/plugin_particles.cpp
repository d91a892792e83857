#include "particle_io/detail/plugin_particles.hpp"

#include <algorithm>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include <particle_plugin.h>
#include "base/checked.hpp"
#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/detail/vtk_cells.hpp"
#include "plugin_host/plugin_kinds.hpp"
#include "plugin_host/plugin_session.hpp"
#include "volume_io/vdb_points.hpp"

namespace isoextract::particle_io {
namespace {

std::string plain_text(const char* text, std::size_t most) { return text == nullptr ? "" : printable(text, most); }

std::optional<AttributeKind> kind_of(std::int32_t kind) {
  switch (kind) {
    case ISOEXTRACT_KIND_SCALAR: return AttributeKind::scalar;
    case ISOEXTRACT_KIND_COLOR: return AttributeKind::color;
    case ISOEXTRACT_KIND_VECTOR: return AttributeKind::vector;
    case ISOEXTRACT_KIND_POINT: return AttributeKind::point;
    case ISOEXTRACT_KIND_NORMAL: return AttributeKind::normal;
    default: return std::nullopt;
  }
}

// Adds the library and package from the plug-in's table, and the path of the plug-in.
ParticleFormatDescription with_plugin(ParticleFormatDescription about, const plugin_host::PluginFolders& folders,
                                      std::span<const plugin_host::PluginTable> tables) {
  about.is_plugin = true;
  about.plugin = plugin_host::PluginLibrary(plugin_host::kParticlePlugins, about.id, folders).path();
  const auto table = std::ranges::find(tables, about.id, &plugin_host::PluginTable::id);
  if (table == tables.end()) return about;
  about.library = table->library;
  about.package = table->package;
  return about;
}

class PluginParticles : public ParticleFormat {
 public:
  PluginParticles(ParticleFormatDescription described, plugin_host::PluginFolders folders,
                  std::span<const plugin_host::PluginTable> tables)
      : ParticleFormat(with_plugin(std::move(described), folders, tables)),
        library_(plugin_host::kParticlePlugins, about().id, std::move(folders), about().package) {}

  [[nodiscard]] ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const override {
    return OpenedFile(*this, file, options).info(options);
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    const OpenedFile opened(*this, file, options);
    if (!options.frame && opened.value().frames > 1) throw_frame_error(options, opened.value().frames);
    return opened.read(options);
  }

  // Uses one worker process for the info and the particles.
  [[nodiscard]] DescribedParticles describe(const files::InputFile& file,
                                            const ParticleReadOptions& options) const override {
    const OpenedFile opened(*this, file, options);
    return describe_by_reading(opened.info(options), options,
                               [&](const ParticleReadOptions& all) { return opened.read(all); });
  }

 private:
  // A file opened with the plug-in, with a reservation for its memory.
  class OpenedFile {
   public:
    OpenedFile(const PluginParticles& format, const files::InputFile& file, const ParticleReadOptions& options)
        : id_(format.about().id), name_(file.name()), context_(file.context()) {
      const std::string what = file.name() + ": the memory of the plug-in that reads it";
      // The plug-in's memory is known only after opening; until then reserves twice the size of the file.
      memory_ = must(
          file.context().reserve(checked_product(file.size(), std::uint64_t{2}).value_or(~std::uint64_t{0}), what));
      file.context().progress().begin("reading", 0);
      const plugin_host::ParticleSelection wanted{wanted_frame(options), options.grid ? &*options.grid : nullptr};
      visit_ = must(plugin_host::open_particle_session(format.library_, id_, file, wanted));
      memory_.release();
      memory_ = must(file.context().reserve(value().held_bytes, what));
      check(options);
      make_table();
    }

    [[nodiscard]] const isoextract_particle_file& value() const { return visit_->file(); }

    [[nodiscard]] ParticleInfo info(const ParticleReadOptions& options) const {
      ParticleInfo info;
      info.frames = value().frames;
      info.particles = value().particles;
      info.frame_name = plain_text(value().frame_name, 80);
      describe_table(table_, options, info);
      info.length_unit = plain_text(value().length_unit, 80);
      return info;
    }

    // Call once.
    [[nodiscard]] ParticleFile read(const ParticleReadOptions& options) const {
      const ColumnChoice choice = choose_columns(table_, options);
      ParticleFile result;
      result.particles = make_particles(context_, label_of_frame(name_, options), value().particles, choice);
      if (result.particles.size() > 0) fill(result.particles, choice);
      result.length_unit = plain_text(value().length_unit, 80);
      result.notes = choice.notes;
      if (std::string printed = finish(); !printed.empty())
        result.notes.push_back({NoteId::plugin_output, std::move(printed)});
      return result;
    }

   private:
    void fill(points::ParticleSet& set, const ColumnChoice& choice) const {
      static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));
      must(visit_->positions({&set.positions[0].x, 3 * set.positions.size()}));
      for (std::size_t a = 0; a < choice.attributes.size(); ++a) {
        const std::size_t first = choice.attributes[a].columns.front();
        const auto group = std::ranges::find_if(
            table_.groups, [&](const ColumnTuple& g) { return g.columns == choice.attributes[a].columns; });
        if (group == table_.groups.end()) {
          throw InvalidParticleFile(fmt::format("expected the name of an attribute, not of a component, found '{}'",
                                                printable(table_.columns[first].name, 80)));
        }
        const std::span<float> values = set.attributes[a].values.span();
        if (group == table_.groups.begin()) {  // the position, which plug-ins do not list as an attribute
          float* to = values.data();
          for (const glm::dvec3& p : set.positions) {
            for (int axis = 0; axis < 3; ++axis) *to++ = static_cast<float>(p[axis]);
          }
          continue;
        }
        must(visit_->quantity(static_cast<std::size_t>(group - table_.groups.begin()) - 1, values));
      }
    }

    // Call last. Returns the plug-in's output as a note; may be empty.
    [[nodiscard]] std::string finish() const {
      must(visit_->finish());
      const std::string printed = visit_->printed();
      return printed.empty() ? printed : fmt::format("the plug-in for {} printed: {}", id_, printed);
    }

    void check(const ParticleReadOptions& options) const {
      const auto refused = [&](std::string_view what) {
        throw InvalidParticleFile(fmt::format("the plug-in for {} returns {}", id_, what));
      };
      const isoextract_particle_file& opened = value();
      if (opened.quantities == nullptr && opened.quantity_count > 0) refused("a null list of attributes");
      if (opened.frames == 0) refused("a file without frames");
      if (wanted_frame(options) >= opened.frames) throw_frame_error(options, opened.frames);
      std::uint64_t columns = 3;
      for (std::size_t i = 0; i < opened.quantity_count; ++i) {
        const std::uint64_t components = opened.quantities[i].components;
        if (components == 0 || components > kMaxParticleColumns - columns)
          refused("an attribute with an invalid number of components");
        columns += components;
      }
    }

    void make_table() {
      add_tuple(table_, "position", "number", 3);
      table_.position = {0, 1, 2};
      for (std::size_t i = 0; i < value().quantity_count; ++i) {
        const isoextract_particle_quantity& quantity = value().quantities[i];
        add_tuple(table_, quantity.name == nullptr ? "" : quantity.name, plain_text(quantity.type_name, 80),
                  static_cast<std::size_t>(quantity.components), quantity.is_numeric != 0, kind_of(quantity.kind));
      }
      make_group_names_unique(table_);
    }

    std::string id_;
    std::string name_;
    Context context_;
    Reservation memory_;
    std::unique_ptr<plugin_host::ParticleSession> visit_;
    ParticleTable table_;
  };

  plugin_host::PluginLibrary library_;
};

class VtkParticles final : public PluginParticles {
 public:
  VtkParticles(plugin_host::PluginFolders folders, std::span<const plugin_host::PluginTable> tables)
      : PluginParticles({.id = "vtk",
                         .title = "VTK, legacy and XML: unstructured grids and poly data of points",
                         .extensions = {".vtk", ".vtu", ".vtp"}},
                        std::move(folders), tables) {}

  // Other kinds of VTK data are volumes or tables.
  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    if (start.packed) return false;
    const std::string_view text(reinterpret_cast<const char*>(start.bytes.data()), start.bytes.size());
    const auto has = [&](std::string_view part) { return text.find(part) != std::string_view::npos; };
    if (text.starts_with("# vtk DataFile")) return has("DATASET UNSTRUCTURED_GRID") || has("DATASET POLYDATA");
    return has("<VTKFile") && (has("\"UnstructuredGrid\"") || has("\"PolyData\""));
  }

  // Grids of cells are volumes.
  [[nodiscard]] bool claims(const files::InputFile& file, const files::FileStart& start,
                            const ParticleReadOptions& /*options*/) const override {
    const std::string_view text(reinterpret_cast<const char*>(start.bytes.data()), start.bytes.size());
    return probe(start) && !has_vtk_cells(file, text);
  }
};

// OpenVDB's point grids. The list of grids is read without the plug-in.
class OpenVdbParticles final : public PluginParticles {
 public:
  OpenVdbParticles(plugin_host::PluginFolders folders, std::span<const plugin_host::PluginTable> tables)
      : PluginParticles({.id = plugin_host::kOpenVdbPlugin,
                         .title = "OpenVDB's point grids",
                         .extensions = {".vdb"},
                         .has_grids = true},
                        std::move(folders), tables) {}

  // Claims files that only have points, or whose selected grid is a point grid.
  [[nodiscard]] bool claims(const files::InputFile& file, const files::FileStart& start,
                            const ParticleReadOptions& options) const override {
    constexpr std::string_view kStart(" BDV\0\0\0\0", 8);
    const std::string_view text(reinterpret_cast<const char*>(start.bytes.data()), start.bytes.size());
    if (start.packed || !text.starts_with(kStart)) return false;
    return must(volume_io::has_vdb_points(file, options.grid));
  }

  [[nodiscard]] ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const override {
    return PluginParticles::info(file, checked(file, options));
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    return PluginParticles::read(file, checked(file, options));
  }

  [[nodiscard]] DescribedParticles describe(const files::InputFile& file,
                                            const ParticleReadOptions& options) const override {
    return PluginParticles::describe(file, checked(file, options));
  }

 private:
  // Checks the header. Returns the options with OpenVDB's name of the selected grid.
  static ParticleReadOptions checked(const files::InputFile& file, const ParticleReadOptions& options) {
    must(volume_io::check_vdb_header(file));
    ParticleReadOptions named = options;
    if (named.grid) named.grid = must(volume_io::vdb_points_name(file, *named.grid));
    return named;
  }
};

}  // namespace

std::vector<std::unique_ptr<const ParticleFormat>> find_particle_plugins(const plugin_host::PluginFolders& folders) {
  const auto tables = plugin_host::find_plugin_tables(folders, plugin_host::kParticlePlugins.name_start);
  std::vector<std::unique_ptr<const ParticleFormat>> formats;
  formats.push_back(std::make_unique<const VtkParticles>(folders, tables));
  formats.push_back(std::make_unique<const OpenVdbParticles>(folders, tables));
  for (const plugin_host::PluginTable& table : tables) {
    if (table.id == formats[0]->about().id || table.id == formats[1]->about().id) continue;
    formats.push_back(std::make_unique<const PluginParticles>(ParticleFormatDescription{.id = table.id,
                                                                                        .title = table.title,
                                                                                        .extensions = table.extensions,
                                                                                        .has_frames = true,
                                                                                        .needs_extension = true},
                                                              folders, tables));
  }
  return formats;
}

}  // namespace isoextract::particle_io
