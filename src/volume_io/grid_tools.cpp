#include "volume_io/grid_tools.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <grid_tools_plugin.h>
#include "base/printable.hpp"
#include "files/output_file.hpp"
#include "plugin_host/plugin_kinds.hpp"
#include "plugin_host/plugin_library.hpp"
#include "plugin_host/plugin_samples.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::volume_io {
namespace {

using Tools = isoextract_grid_tools_plugin_v4;

// Searches the folders on every call, which is cheap beside the work; the loaded library stays open.
plugin_host::PluginLibrary grid_tools_library() {
  return {
      {"isoextract-grids-", "isoextract_grid_tools_plugin",
       plugin_host::call_plugin_function<isoextract_grid_tools_plugin_v4>, ISOEXTRACT_GRID_TOOLS_PLUGIN_VERSION, false},
      plugin_host::kOpenVdbPlugin,
      plugin_host::plugin_folders()};
}

Result<const Tools*> grid_tools_for(const std::string& work) {
  const auto opened = TRY(grid_tools_library().opened(work));
  return static_cast<const Tools*>(opened);
}

Error tools_failed(const Tools& tools, const std::string& work, ErrorCode code = ErrorCode::input) {
  const char* text = tools.error_text();
  return {code,
          fmt::format("{}: {}", work, text == nullptr ? "the plug-in failed and gave no reason" : printable(text, 400)),
          {}};
}

// A grid made by the plug-in, with the memory the plug-in requested.
struct MadeGrid {
  MadeGrid(const Tools& the_tools, const Context& context, const std::string& work)
      : tools(the_tools), memory(context, work) {}
  MadeGrid(const MadeGrid&) = delete;
  MadeGrid& operator=(const MadeGrid&) = delete;
  ~MadeGrid() {
    if (is_given) tools.free_output(&output);
  }

  const Tools& tools;
  plugin_host::PluginMemory memory;
  isoextract_grid_output output{};
  bool is_given = false;
};

// A field in the plug-in's format; refers to the field.
class GridInput {
 public:
  explicit GridInput(const field::ScalarField& field) {
    if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
      input_.data = dense->data;
      for (int axis = 0; axis < 3; ++axis) input_.dims[axis] = static_cast<std::uint64_t>(dense->dims[axis]);
    } else {
      sparse_ = plugin_host::plugin_sparse_of(std::get<field::SparseSamples>(field.samples));
      input_.sparse = &sparse_->samples;
    }
    input_.sample_type = plugin_host::plugin_type_of(field.type());
    input_.slope = field.scale.slope;
    input_.intercept = field.scale.intercept;
    input_.kind = field.kind == field::FieldKind::level_set ? ISOEXTRACT_LEVEL_SET : ISOEXTRACT_DENSITY;
    const auto rows = plugin_host::plugin_rows_of(field.index_to_world);
    std::ranges::copy(rows, input_.index_to_world);
  }

  [[nodiscard]] const isoextract_grid_input& get() const { return input_; }

 private:
  isoextract_grid_input input_{};
  std::unique_ptr<const plugin_host::PluginSparse> sparse_;
};

// Returns the bytes of a sparse field's lists in the plug-in's format.
std::uint64_t list_bytes(const field::ScalarField& field) {
  const auto* sparse = std::get_if<field::SparseSamples>(&field.samples);
  if (sparse == nullptr) return 0;
  return sparse->blocks.size() * sizeof(isoextract_sparse_block) +
         sparse->tiles.size() * sizeof(isoextract_sparse_tile);
}

Result<field::ScalarField> made_field(std::shared_ptr<MadeGrid> made, const std::string& work) {
  field::ScalarField field;
  field.format = "OpenVDB";
  field.index_to_world = plugin_host::affine_of(made->output.index_to_world);
  if (made->output.kind == ISOEXTRACT_LEVEL_SET) field.kind = field::FieldKind::level_set;
  const isoextract_sparse_samples& given = made->output.samples;
  auto samples = plugin_host::sparse_samples_of(given, std::move(made));
  if (!samples) return fail(ErrorCode::input, fmt::format("{}: the plug-in returns {}", work, samples.error()));
  field.samples = std::move(*samples);
  return field;
}

// Returns `field` with the samples of `made`.
Result<field::ScalarField> with_samples_of(const field::ScalarField& field, Result<field::ScalarField> made) {
  if (!made) return made;
  field::ScalarField result = field;
  result.scale = {};
  result.samples = std::move(made->samples);
  return result;
}

Result<void> check_sphere_options(const points::ParticleSet& particles, const SphereOptions& options) {
  const auto refuse = [](const std::string& what) { return fail(ErrorCode::usage, what); };
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!options.radii.empty() && options.radii.size() != particles.size()) {
    return refuse(
        fmt::format("expected a radius for each of {} particles, found {}", particles.size(), options.radii.size()));
  }
  if (options.radii.empty() && !positive(options.radius)) {
    return refuse(fmt::format("the radius of particles: expected a number greater than 0, found {}", options.radius));
  }
  if (!positive(options.voxel)) {
    return refuse(fmt::format("the size of voxels: expected a number greater than 0, found {}", options.voxel));
  }
  if (!(options.half_band >= 2 && options.half_band <= 1000)) {
    return refuse(fmt::format("the band around the surface: expected 2 to 1000 voxels, found {}", options.half_band));
  }
  if (!(std::isfinite(options.least_radius) && options.least_radius >= 0)) {
    return refuse(
        fmt::format("the minimum radius in voxels: expected a number of 0 or more, found {}", options.least_radius));
  }
  if (options.method == SphereMethod::smooth && !positive(options.search_radius)) {
    return refuse(fmt::format("the search radius: expected a number greater than 0, found {}", options.search_radius));
  }
  return {};
}

std::string work_on(const points::ParticleSet& particles) {
  return (particles.label.empty() ? "the particles" : particles.label) + ": their surface";
}

// Returns a job that refers to the particles and their radii.
isoextract_sphere_job sphere_job(const points::ParticleSet& particles, const SphereOptions& options) {
  isoextract_sphere_job job{};
  static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));
  job.positions = particles.size() == 0 ? nullptr : &particles.positions[0].x;
  job.count = particles.size();
  job.radii = options.radii.empty() ? nullptr : options.radii.data();
  job.radius = options.radius;
  job.search_radius = options.search_radius;
  job.voxel = options.voxel;
  job.half_band = options.half_band;
  job.least_radius = options.least_radius;
  job.method = options.method == SphereMethod::smooth ? ISOEXTRACT_SMOOTH_SPHERES : ISOEXTRACT_SPHERES;
  job.kind = options.kind == field::FieldKind::level_set ? ISOEXTRACT_LEVEL_SET : ISOEXTRACT_DENSITY;
  return job;
}

// Receives the bytes of a VDB file; `error` is the first failure.
struct VdbSink {
  files::OutputFile& file;
  std::optional<Error> error;

  bool took(Result<void> written) {
    if (!written) error = std::move(written.error());
    return written.has_value();
  }
};

std::span<const std::byte> bytes_of(const void* bytes, std::uint64_t count) {
  return {static_cast<const std::byte*>(bytes), static_cast<std::size_t>(count)};
}

// A field with the name of its grid.
struct NamedField {
  const field::ScalarField* field;
  std::string name;
};

Result<std::uint64_t> write_grids(const std::filesystem::path& path, std::span<const NamedField> fields, bool as_half,
                                  const Context& context) {
  const std::string work = path.string();
  const auto tools = TRY(grid_tools_for(work));
  std::uint64_t listed = 0;
  for (const NamedField& named : fields) listed += list_bytes(*named.field);
  const auto lists = TRY(context.reserve(listed, work));
  auto file = TRY(files::OutputFile::create(path));
  VdbSink sink{file, {}};
  std::vector<GridInput> inputs;
  std::vector<isoextract_named_grid> grids;
  for (const NamedField& named : fields) {
    inputs.emplace_back(*named.field);
    grids.push_back({inputs.back().get(), named.name.c_str()});
  }
  isoextract_vdb_job job{};
  job.grids = grids.data();
  job.count = grids.size();
  job.is_half = as_half ? 1 : 0;
  job.sink = &sink;
  job.append = [](void* to, const void* bytes, std::uint64_t count) {
    auto& sink_of = *static_cast<VdbSink*>(to);
    return sink_of.took(sink_of.file.write(bytes_of(bytes, count))) ? 0 : 1;
  };
  if (!files::is_stream(path)) {
    job.overwrite = [](void* to, std::uint64_t place, const void* bytes, std::uint64_t count) {
      auto& sink_of = *static_cast<VdbSink*>(to);
      return sink_of.took(sink_of.file.overwrite(place, bytes_of(bytes, count))) ? 0 : 1;
    };
  }
  const plugin_host::PluginMemory memory(context, work);
  if (tools->write_vdb(&job, &memory.host()) != 0) {
    if (sink.error) return tl::unexpected(*sink.error);
    return tl::unexpected(memory.refusal_or(tools_failed(*tools, work, ErrorCode::output)));
  }
  for (const NamedField& named : fields) {
    TRY(check_mapping_intact(*named.field));
  }
  const std::uint64_t bytes = file.bytes_written();
  TRY(file.commit());
  return bytes;
}

}  // namespace

std::string grid_tools_path() { return grid_tools_library().path(); }

Result<void> check_grid_tools(const std::string& work) {
  const auto tools = grid_tools_for(work);
  return tools ? Result<void>() : tl::unexpected(tools.error());
}

Result<std::uint64_t> sphere_bytes(const points::ParticleSet& particles, const SphereOptions& options,
                                   const Context& context) {
  TRY(check_sphere_options(particles, options));
  const std::string work = work_on(particles);
  const auto tools = TRY(grid_tools_for(work));
  const isoextract_sphere_job job = sphere_job(particles, options);
  const plugin_host::PluginMemory memory(context, work);
  std::uint64_t bytes = 0;
  if (tools->sphere_bytes(&job, &memory.host(), &bytes) != 0) {
    return tl::unexpected(memory.refusal_or(tools_failed(*tools, work)));
  }
  return bytes;
}

Result<SphereField> rasterize_spheres(const points::ParticleSet& particles, const SphereOptions& options,
                                      const Context& context) {
  TRY(check_sphere_options(particles, options));
  const std::string work = work_on(particles);
  const auto tools = TRY(grid_tools_for(work));
  const isoextract_sphere_job job = sphere_job(particles, options);
  const auto made = std::make_shared<MadeGrid>(*tools, context, work);
  if (tools->spheres(&job, &made->memory.host(), &made->output) != 0) {
    return tl::unexpected(made->memory.refusal_or(tools_failed(*tools, work)));
  }
  made->is_given = true;
  const std::uint64_t left_out = made->output.left_out;
  auto field = TRY(made_field(made, work));
  field.name = "surface";
  field.source = particles.label;
  if (left_out > 0) {
    field.notes.push_back(
        {NoteId::particles_left_out,
         fmt::format("the surface leaves out {} of {} particles, those with a radius below {:g} voxels", left_out,
                     particles.size() - options.images, options.least_radius)});
  }
  return SphereField{std::move(field), left_out};
}

Result<field::ScalarField> filter_level_set(const field::ScalarField& field, LevelSetFilter filter, int width,
                                            int iterations, const Context& context) {
  if (width < 1 || width > kMaxFilterWidth || iterations < 0) {
    return fail(
        ErrorCode::usage,
        fmt::format("level set filter: expected a width of 1 to {} voxels and 0 or more iterations, found a width of "
                    "{} and {} iterations",
                    kMaxFilterWidth, width, iterations));
  }
  const std::string work = field.source + ": filtering the level set";
  const auto tools = TRY(grid_tools_for(work));
  const auto lists = TRY(context.reserve(list_bytes(field), work));
  const GridInput input(field);
  isoextract_filter_job job{input.get(), ISOEXTRACT_GAUSSIAN, static_cast<std::uint32_t>(width),
                            static_cast<std::uint32_t>(iterations)};
  if (filter == LevelSetFilter::median) job.filter = ISOEXTRACT_MEDIAN;
  if (filter == LevelSetFilter::mean) job.filter = ISOEXTRACT_MEAN;
  const auto made = std::make_shared<MadeGrid>(*tools, context, work);
  if (tools->filter(&job, &made->memory.host(), &made->output) != 0) {
    return tl::unexpected(made->memory.refusal_or(tools_failed(*tools, work)));
  }
  made->is_given = true;
  return with_samples_of(field, made_field(made, work));
}

Result<field::ScalarField> rebuild_level_set(const field::ScalarField& field, const field::Affine& old_from_new,
                                             double half_band, const Context& context) {
  const std::string work = field.source + ": rebuilding the level set";
  const auto tools = TRY(grid_tools_for(work));
  const auto lists = TRY(context.reserve(list_bytes(field), work));
  const GridInput input(field);
  isoextract_rebuild_job job{};
  job.grid = input.get();
  job.half_band = half_band;
  for (int axis = 0; axis < 3; ++axis) {
    job.first[axis] = old_from_new.offset[axis];
    job.step[axis] = old_from_new.linear[axis][axis];
  }
  const auto made = std::make_shared<MadeGrid>(*tools, context, work);
  if (tools->rebuild(&job, &made->memory.host(), &made->output) != 0) {
    return tl::unexpected(made->memory.refusal_or(tools_failed(*tools, work)));
  }
  made->is_given = true;
  auto result = TRY(with_samples_of(field, made_field(made, work)));
  result.index_to_world = field.index_to_world.after(old_from_new);
  result.index_to_file = field.index_to_file.after(old_from_new);
  return result;
}

Result<std::uint64_t> write_vdb(const std::filesystem::path& path, const field::ScalarField& field,
                                const VdbWriteOptions& options, const Context& context) {
  const NamedField named{&field, options.name.empty() ? field.name : options.name};
  return write_grids(path, {&named, 1}, options.as_half, context);
}

Result<std::uint64_t> write_vdb(const std::filesystem::path& path, std::span<const field::ScalarField> fields,
                                const Context& context) {
  std::vector<NamedField> named;
  for (const field::ScalarField& field : fields) named.push_back({&field, field.name});
  return write_grids(path, named, false, context);
}

}  // namespace isoextract::volume_io
