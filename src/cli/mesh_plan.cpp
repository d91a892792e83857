#include "cli/mesh_plan.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "cli/field_plan.hpp"
#include "cli/particle_file_plan.hpp"
#include "cli/plan_parts.hpp"
#include "field/demo_field.hpp"
#include "files/file_bytes.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "particle_io/particle_format.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {
namespace {

// An option without effect on a mesh, and why.
struct Misplaced {
  const Option* option;
  std::string_view why;
};

constexpr std::string_view kSamples = "it describes the samples of a volume";
constexpr std::string_view kParticles = "it describes particles";
constexpr std::string_view kLabels = "labels are samples of a volume";
constexpr std::string_view kExtraction = "it describes the extraction of a surface from a field";
constexpr std::string_view kGrid = "it makes another grid of samples";
constexpr std::string_view kBackends = "the backends extract surfaces from a field";

void add_all(const OptionSet& set, std::string_view why, std::vector<Misplaced>& options) {
  for (const Option* option : set.options()) options.push_back({option, why});
}

// Returns the options that need a field or particles, in the order of the help.
std::vector<Misplaced> options_of_fields(const ConvertFlags& flags) {
  std::vector<Misplaced> options;
  for (const Option* option : flags.input.options()) {
    const bool is_general =
        option->is_positional() || option == &flags.input.memory_limit || option == &flags.input.in_process;
    if (!is_general) options.push_back({option, kSamples});
  }
  add_all(flags.particles, kParticles, options);
  const SurfaceFlags& surface = flags.surface;
  const std::vector<Misplaced> others{
      {&flags.isos, "only a field has iso values"},
      {&flags.batch.iso_table, "only a field has iso values"},
      {&surface.method, kExtraction},
      {&surface.roi, "it chooses samples of a field; --clip cuts a mesh at planes"},
      {&surface.roi_snap, "it chooses samples of a field; --clip cuts a mesh at planes"},
      {&surface.resolution, kGrid},
      {&surface.voxel_size, kGrid},
      {&surface.kernel, kGrid},
      {&surface.filters, "it filters the samples of a level set; --smooth smooths a mesh"},
      {&surface.blurs, "it blurs the samples of a field; --smooth smooths a mesh"},
      {&surface.nan, kSamples},
      {&flags.labels.chosen, kLabels},
      {&flags.labels.min_voxels, kLabels},
      {&flags.labels.background, kLabels},
      {&flags.labels.names, kLabels},
      {&flags.heightfield, "it makes terrain of a picture or array of heights"},
      {&flags.base, "it closes terrain of heights"},
      {&flags.relaxations, kExtraction},
      {&flags.no_merge, kExtraction},
      {&flags.t_junctions, kExtraction},
      {&flags.attributes, "attributes come from fields and particles; the output keeps those of the mesh file anyway"},
      {&flags.placement.to_space, "a mesh file states no patient space"},
      {&flags.half, "it stores the samples of a field"},
      {&flags.error, "the error of a surface is its distance to the isosurface of a field"},
      {&flags.verify, kBackends},
      {&flags.backend, kBackends}};
  options.insert(options.end(), others.begin(), others.end());
  add_all(flags.device, kBackends, options);
  return options;
}

// Refuses values that need voxels, particles or a field, and --cap without --clip.
Result<void> check_values(const ConvertFlags& flags) {
  if (flags.simplify && !flags.simplify->in_world_units) {
    return refuse_usage(
        fmt::format("--simplify {}: the distance is in voxels, which a mesh does not have", flags.simplify->distance),
        fmt::format("give it in the units of the mesh: --simplify {}world", flags.simplify->distance));
  }
  if (flags.color && !flags.color->attribute) {
    return refuse_usage("--color-by iso: only a field has iso values",
                        "give the name of a vertex attribute of the mesh");
  }
  const auto& least = flags.edits.least;
  if (least && least->measure != edit::ComponentMeasure::triangles && !least->in_world_units) {
    return refuse_usage(fmt::format("--drop-components {}:{}: the size is in voxels, which a mesh does not have",
                                    word_of(least->measure), least->amount),
                        fmt::format("give it in the units of the mesh: --drop-components {}:{}world",
                                    word_of(least->measure), least->amount));
  }
  if (flags.edits.hollow && flags.edits.hollow->unit == convert::kVoxelUnit) {
    return refuse_usage(
        fmt::format("--hollow {}voxel: the thickness is in voxels, which a mesh does not have",
                    flags.edits.hollow->thickness),
        fmt::format("give it in the units of the mesh: --hollow {}world", flags.edits.hollow->thickness));
  }
  if (flags.edits.smooth && flags.edits.smooth->method == edit::SmoothMethod::weighted) {
    return refuse_usage("--smooth weighted: the weights are those of particles, which a mesh does not have",
                        "use --smooth N:taubin or --smooth N:sinc");
  }
  if (flags.surface.cap && flags.surface.clip.empty()) {
    return refuse_usage("--cap: without --clip there is no cut of the mesh to close",
                        "give --clip, or leave --cap out");
  }
  if (flags.placement.space == convert::Space::index) {
    return refuse_usage("--space index: a mesh has no voxel coordinates", "leave --space out");
  }
  return {};
}

Result<void> check_output(const ConvertFlags& flags, const std::string& name) {
  if (!makes_surfaces(flags)) {
    return refuse_usage(
        fmt::format("{}: {} is a mesh, which cannot become {}",
                    flags.output ? "-o " + *flags.output : flags.format.name(), name,
                    writes_field(flags) ? "a field" : "particles"),
        fmt::format("a mesh becomes another mesh ({}) or a picture (.png)", mesh_io::mesh_extensions()));
  }
  if (flags.output && flags.output->find("{iso}") != std::string::npos) {
    return refuse_usage(fmt::format("-o {}: only a field has iso values, and {} is a mesh", *flags.output, name),
                        "leave {iso} out of the name");
  }
  return {};
}

// Returns whether the file is a mesh, mostly by its name; nullopt if the name does not tell or the file is unreadable.
std::optional<bool> is_mesh_file(const std::string& input, const Context& context) {
  const auto format = mesh_io::mesh_format_by_path(input);
  if (format == mesh_io::MeshFormat::ply) {
    if (mesh_io::find_mesh_format(input, context.beside())) return true;
    // Reading a damaged file gives a better message than its kind.
    return mesh_io::holds_mesh(input, context.beside()) ? std::optional(false) : std::nullopt;
  }
  if (format) return true;
  const bool is_other = input.starts_with(field::kDemoPrefix) || volume_io::has_volume_extension(input) ||
                        volume_io::has_picture_extension(input) || particle_io::has_particle_extension(input);
  return is_other ? std::optional(false) : std::nullopt;
}

// Refuses meshes beside other inputs. Does not open frames with numbers in their names: they come from one program.
// With --empty, PLY files without faces may be empty meshes. With --input-format, names do not tell what files are.
Result<void> check_kinds(const ConvertFlags& flags, const batch::Frames& found, const Context& context) {
  if (found.have_numbers || found.frames.size() < 2 || flags.empty.is_set()) return {};
  if (flags.heightfield || flags.input.format) return {};
  const std::string* mesh = nullptr;
  const std::string* other = nullptr;
  for (const batch::Frame& frame : found.frames) {
    const auto is_mesh = is_mesh_file(frame.input, context);
    if (is_mesh && (*is_mesh ? mesh : other) == nullptr) (*is_mesh ? mesh : other) = &frame.input;
    if (mesh != nullptr && other != nullptr) {
      return refuse_usage(
          fmt::format("{} is a mesh, {} is none: expected inputs of one kind", printable(*mesh), printable(*other)),
          "convert the meshes, and the particles or volumes, in runs of their own: list the files of one kind, or give "
          "their pattern");
    }
  }
  return {};
}

// Returns the mesh format of the output; nullopt if the output is no mesh or its name does not state a format.
std::optional<mesh_io::MeshFormat> output_format(const ConvertFlags& flags) {
  if (flags.format) return flags.format->mesh;
  return flags.output ? mesh_io::mesh_format_by_path(*flags.output) : std::nullopt;
}

}  // namespace

bool reads_mesh(const ConvertFlags& flags) {
  return !flags.isos.empty() && flags.isos.front() == convert::IsoChoice::file_meshes();
}

Result<void> take_mesh(ConvertFlags& flags, const std::string& input, const Context& context) {
  const bool is_raw = flags.input.dims && files::is_standard_input(input);
  if (flags.heightfield || flags.input.format || is_raw) return {};
  const auto found = mesh_io::find_mesh_format(input, context.beside());
  // The reader of particles says best what a PLY with faces lacks.
  if (!found || (*found == mesh_io::MeshFormat::ply && flags.particles.any_set())) return {};
  const std::string name = printable(files::input_label(input));
  TRY(check_output(flags, name));
  for (const Misplaced& misplaced : options_of_fields(flags)) {
    if (!misplaced.option->is_set()) continue;
    const std::string& option = misplaced.option->name();
    return refuse_usage(fmt::format("{} has no effect on the mesh {}: {}", option, name, misplaced.why),
                        fmt::format("leave out {}", option));
  }
  TRY(check_values(flags));
  flags.isos = std::vector{convert::IsoChoice::file_meshes()};
  if (!mesh_io::is_gltf(*found) || flags.placement.up) return {};
  flags.placement.up = convert::UpAxis::y;
  const auto format = output_format(flags);
  if (format && !mesh_io::is_gltf(*format) && !flags.placement.up_out) flags.placement.up_out = convert::UpAxis::z;
  return {};
}

Result<void> check_mesh_frames(const ConvertFlags& flags, const batch::Frames& found, const Context& context) {
  TRY(check_kinds(flags, found, context));
  if (!reads_mesh(flags)) return {};
  const auto is_gltf_named = [](const batch::Frame& frame) {
    const auto format = mesh_io::mesh_format_by_path(frame.input);
    return format && mesh_io::is_gltf(*format);
  };
  const bool first = is_gltf_named(found.frames.front());
  const auto other =
      std::ranges::find_if(found.frames, [&](const batch::Frame& frame) { return is_gltf_named(frame) != first; });
  if (other == found.frames.end()) return {};
  return refuse_usage(
      fmt::format("{} and {}: expected all inputs in glTF, or all in other formats; glTF has y up, other formats z",
                  printable(found.frames.front().input), printable(other->input)),
      "convert the files of each format in a run of its own");
}

}  // namespace isoextract::cli
