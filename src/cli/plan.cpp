#include "cli/plan.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "cli/batch_plan.hpp"
#include "cli/mask_plan.hpp"
#include "cli/particle_plan.hpp"
#include "cli/plan_parts.hpp"
#include "cli/rank_run.hpp"
#include "field/demo_field.hpp"
#include "files/file_bytes.hpp"
#include "files/frame_pattern.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

// Returns a frame or tile placeholder of another program in a name that is no file: *, <UDIM>, <f4>, $FF, or # within a
// word. Empty if there is none.
std::string foreign_numbering(const std::string& input) {
  if (input.starts_with(field::kDemoPrefix)) return {};
  const std::size_t at = input.find_first_of("*<#$");
  if (at == std::string::npos || files::is_there(input)) return {};
  const auto pattern = files::FramePattern::parse(input);
  if (!pattern || pattern->has_value()) return {};
  if (input[at] == '*') return "*";
  const std::size_t end = input[at] == '<' ? input.find('>', at) : input.find_first_of("._-/ ", at);
  if (input[at] == '<' && end == std::string::npos) return {};
  return printable(input.substr(at, end == std::string::npos ? end : end - at + (input[at] == '<' ? 1 : 0)));
}

// Commands that support all volumes check the flags before they call this.
Result<std::optional<std::int64_t>> plan_one_volume(const InputFlags& flags) {
  if (!flags.volume) return std::nullopt;
  if (const auto* number = std::get_if<std::int64_t>(&*flags.volume)) return *number;
  return refuse_usage("--volume all selects several volumes, and this command needs one volume",
                      "give the number of one volume; 'isoextract info INPUT' shows the number of volumes");
}

}  // namespace

MemoryBudget plan_memory(const std::optional<std::uint64_t>& limit) {
  const auto share = memory_of_rank();
  return limit ? MemoryBudget(*limit) : share ? MemoryBudget(*share) : MemoryBudget();
}

Result<mesh_io::MeshFormat> format_of_path(const std::string& path, std::string hint, std::string_view besides) {
  if (const auto format = mesh_io::mesh_format_by_path(path)) return *format;
  std::vector<std::string_view> names;
  for (const mesh_io::MeshFormatInfo& info : mesh_io::mesh_formats()) names.push_back(info.name);
  return refuse_usage(fmt::format("{}: expected a name that ends in .{}{}", path, fmt::join(names, ", ."), besides),
                      std::move(hint));
}

convert::SurfaceOptions plan_surface(const SurfaceFlags& flags, const InputFlags& input) {
  convert::SurfaceOptions surface;
  surface.method = flags.method.value_or(surface.method);
  surface.nan = flags.nan.value_or(default_nan_policy(input));
  surface.cap = flags.cap;
  return surface;
}

Result<void> plan_region(const SurfaceFlags& flags, convert::SourceOptions& source) {
  if (flags.roi_snap && !flags.roi) {
    return refuse_usage("--roi-snap needs --roi: --roi-snap sets where the region of --roi ends",
                        "give --roi X0,Y0,Z0,X1,Y1,Z1");
  }
  source.roi = flags.roi;
  source.roi_snap = flags.roi_snap;
  source.clip = flags.clip;
  return {};
}

Result<void> plan_resolution(const SurfaceFlags& flags, convert::SourceOptions& source) {
  if (flags.resolution && flags.voxel_size) {
    return refuse_usage("--resolution and --voxel-size both set the grid of the extraction", "leave one of them out");
  }
  if (flags.kernel && !flags.resolution && !flags.voxel_size) {
    return refuse_usage("--kernel sets the interpolation of resampling and needs --resolution or --voxel-size",
                        "give --resolution N or --voxel-size S, or leave --kernel out");
  }
  source.resolution = flags.resolution;
  source.voxel_size = flags.voxel_size;
  source.kernel = flags.kernel.value_or(source.kernel);
  return {};
}

extract::NanPolicy default_nan_policy(const InputFlags& input) {
  return input.no_data ? extract::NanPolicy::outside : extract::NanPolicy::error;
}

std::string extension_of(const std::string& path) { return to_lower(std::filesystem::path(path).extension().string()); }

Result<convert::Placement> plan_placement(const PlacementFlags& flags, mesh_io::MeshFormat format, MeshUse use,
                                          Notes& notes) {
  convert::Placement placement;
  placement.space = flags.space.value_or(convert::Space::world);
  placement.up = flags.up.value_or(convert::UpAxis::z);
  if (placement.space == convert::Space::index) {
    TRY(flags.refuse(About::world, "--space index gives voxel coordinates, which {} cannot change",
                     "leave out {} or --space index"));
    return placement;
  }
  TRY(refuse_both(flags.scale, flags.unit));
  if (flags.to_unit && !flags.unit) {
    return refuse_usage("--to-unit needs the unit of the input's world as well",
                        "give --unit file if the input states its unit, or for example --unit mm");
  }
  const std::string_view format_name = mesh_io::mesh_format_info(format).name;
  const convert::UpAxis up_out = flags.up_out.value_or(is_gltf(format) ? convert::UpAxis::y : placement.up);
  placement.turn_z_up_to_y_up = placement.up == convert::UpAxis::z && up_out == convert::UpAxis::y;
  placement.turn_y_up_to_z_up = placement.up == convert::UpAxis::y && up_out == convert::UpAxis::z;
  if (flags.up && !flags.up_out && !is_gltf(format) && use == MeshUse::file) {
    notes.push_back(
        {NoteId::no_effect,
         fmt::format("--up changes nothing: {} prescribes no up axis, so the mesh keeps the input's axes; --up-out "
                     "turns the mesh",
                     format_name)});
  }
  if (is_gltf(format) && up_out == convert::UpAxis::z) {
    notes.push_back(
        {NoteId::up_axis,
         fmt::format("--up-out z: {} prescribes y up, so other programs show the mesh on its side", format_name)});
  }
  placement.to_space = flags.to_space;
  if (flags.scale) placement.scale = *flags.scale;
  placement.center = flags.center;
  if (!flags.unit) return placement;
  // Without --to-unit, the unit of the file stays.
  const std::optional<convert::LengthUnit> to = flags.to_unit     ? flags.to_unit
                                                : is_gltf(format) ? std::optional(convert::meter())
                                                                  : flags.unit->unit;
  if (to) placement.to_unit = to->name;
  placement.unit = flags.unit->unit ? flags.unit->unit->name : convert::kFileUnit;
  if (flags.unit->unit) placement.scale = convert::unit_ratio(*flags.unit->unit, *to);
  if (is_gltf(format) && use != MeshUse::picture && placement.to_unit != convert::meter().name) {
    notes.push_back({NoteId::length_unit,
                     fmt::format("--to-unit {}: {} prescribes meters, so other programs read the coordinates as meters",
                                 placement.to_unit, format_name)});
  }
  return placement;
}

Result<void> check_isos(const std::vector<convert::IsoChoice>& isos) {
  std::vector<convert::IsoChoice> sorted = isos;
  std::sort(sorted.begin(), sorted.end());
  const auto repeated = std::adjacent_find(sorted.begin(), sorted.end());
  if (repeated != sorted.end()) return refuse_usage(fmt::format("--iso {} occurs twice", text_of(*repeated)));
  return {};
}

Result<volume_io::ReadOptions> plan_read(const InputFlags& flags) {
  for (const std::string& input : flags.inputs) {
    if (input.empty()) return refuse_usage("INPUT is an empty text, expected the name of a file");
    if (const std::string mark = foreign_numbering(input); !mark.empty()) {
      return refuse_usage(
          fmt::format("{}: there is no such file, and isoextract does not expand {}", printable(input), mark),
          "write {} in place of the frame number, {:04} for a frame number of 4 or more digits, or let the shell "
          "expand * without quotes");
    }
  }
  if (std::ranges::count_if(flags.inputs, files::is_standard_input) > 1) {
    return refuse_usage("INPUT '-' occurs twice, but isoextract can read stdin only once");
  }
  const auto volume = TRY(plan_one_volume(flags));
  volume_io::ReadOptions read;
  read.volume = volume;
  read.format = flags.format;
  read.grid = flags.grid();
  read.component = flags.component;
  read.axis_order = flags.axis_order;
  read.no_data = flags.no_data;
  read.level = flags.level;
  read.resamples = flags.resample;
  read.spacing = flags.spacing;
  read.origin = flags.origin;
  if (flags.inside == InsideChoice::above) read.kind = field::FieldKind::density;
  if (flags.inside == InsideChoice::below) read.kind = field::FieldKind::level_set;
  if (flags.dims) {
    volume_io::RawLayout raw;
    raw.dims = *flags.dims;
    raw.type = flags.dtype.value_or(raw.type);
    raw.endian = flags.endian.value_or(raw.endian);
    raw.skip = flags.skip.value_or(raw.skip);
    raw.components = flags.components.value_or(raw.components);
    raw.planar = flags.planar;
    if (raw.planar && raw.components == 1) {
      return refuse_usage("--planar needs samples of several components, found 1", "give --components N as well");
    }
    read.raw = raw;
  } else {
    TRY(flags.refuse(About::raw_file, "{} describes a raw file and needs --dims as well", "give --dims NX,NY,NZ"));
  }
  return read;
}

gpu::GpuChoice plan_gpu(const DeviceFlags& flags) {
  gpu::GpuChoice gpu;
  if (flags.device) gpu.device = *flags.device;
  gpu.memory_bytes = flags.gpu_memory;
  return gpu;
}

std::vector<NamedBackend> plan_backends(std::vector<NamedBackend> backends, const DeviceFlags& flags) {
  for (NamedBackend& backend : backends) {
    if (flags.device) backend.gpu.device = *flags.device;
    backend.gpu.memory_bytes = flags.gpu_memory;
  }
  return backends;
}

Result<void> refuse_several_grids(const InputFlags& flags, std::string_view command) {
  if (flags.grids.size() < 2) return {};
  return refuse_usage(fmt::format("{} takes one --grid, found {}", command, flags.grids.size()),
                      "run it once for each grid; only a conversion takes several grids");
}

Result<void> refuse_away_from_zero(const InputFlags& flags, std::string_view command) {
  if (flags.inside != InsideChoice::away_from_zero) return {};
  return refuse_usage(
      fmt::format("{} does not support --inside away-from-zero, which orients each surface by its iso value", command),
      "give --inside above or below");
}

Result<MessageChoice> plan_messages(const RunFlags& flags) {
  TRY(refuse_both(flags.quiet, flags.verbose));
  return MessageChoice{flags.quiet     ? Verbosity::quiet
                       : flags.verbose ? Verbosity::verbose
                                       : Verbosity::normal,
                       flags.no_note.value_or(std::vector<NoteId>())};
}

Result<InfoPlan> plan_info(const InfoFlags& flags) {
  if (flags.input.inputs.empty()) return refuse_usage("INPUT is missing", "isoextract info INPUT");
  InfoPlan plan;
  TRY(refuse_away_from_zero(flags.input, "info"));
  TRY(refuse_several_grids(flags.input, "info"));
  auto read = TRY(plan_read(flags.input));
  auto particles = TRY(plan_particles(flags.particles, std::nullopt));
  plan.inputs = flags.input.inputs;
  if (!flags.frames && !flags.masks) name_volume_of_files(plan.inputs);
  if (flags.masks) {
    TRY(check_mask_input(flags.input, flags.particles, flags.masks));
    TRY(refuse_both(flags.masks, flags.frames, "masks are no sequence"));
    plan.masks = TRY(find_masks(plan.inputs, plan.notes));
  }
  plan.frames = flags.frames;
  plan.read = std::move(read);
  plan.particles = std::move(particles);
  plan.has_radius_of_each_frame = flags.particles.radius && flags.particles.radius->is_of_each_frame;
  plan.memory = plan_memory(flags.input.memory_limit);
  plan.json = flags.json;
  for (const OptionGroup group : {OptionGroup::input, OptionGroup::particles}) {
    for (const Option* option : flags.in_group(group)) {
      if (option->is_positional() || option->texts().empty()) continue;
      plan.input_arguments.push_back(option->name());
      if (option->takes_value()) plan.input_arguments.push_back(shell_quoted(option->texts().front()));
    }
  }
  return plan;
}

Result<ComparePlan> plan_compare(const CompareFlags& flags) {
  if (flags.meshes.size() != 2) {
    return refuse_usage(fmt::format("compare takes two meshes, found {}{}{}", flags.meshes.size(),
                                    flags.meshes.empty() ? "" : ": ", fmt::join(flags.meshes, ", ")),
                        "isoextract compare A.glb B.glb");
  }
  if (std::ranges::any_of(flags.meshes, files::is_standard_input)) {
    return refuse_usage("compare cannot read a mesh from stdin", "give the paths of two files");
  }
  ComparePlan plan;
  plan.meshes = {flags.meshes[0], flags.meshes[1]};
  plan.up = flags.up;
  plan.max_distance = flags.max_distance;
  plan.memory = plan_memory(flags.memory_limit);
  plan.json = flags.json;
  return plan;
}

}  // namespace isoextract::cli
