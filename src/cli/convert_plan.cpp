#include <algorithm>
#include <array>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/printable.hpp"
#include "batch/find_frames.hpp"
#include "batch/output_names.hpp"
#include "cli/edit_plan.hpp"
#include "cli/field_plan.hpp"
#include "cli/height_plan.hpp"
#include "cli/mask_plan.hpp"
#include "cli/mesh_plan.hpp"
#include "cli/output_folders.hpp"
#include "cli/output_plan.hpp"
#include "cli/packing_plan.hpp"
#include "cli/pages_plan.hpp"
#include "cli/particle_file_plan.hpp"
#include "cli/particle_plan.hpp"
#include "cli/picture_plan.hpp"
#include "cli/plan.hpp"
#include "cli/plan_parts.hpp"
#include "cli/rank_run.hpp"
#include "cli/vertex_plan.hpp"
#include "cli/voxel_plan.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::cli {
namespace {

Result<mesh_io::MeshFormat> plan_format(const ConvertFlags& flags) {
  if (!makes_surfaces(flags) || writes_picture(flags))
    return mesh_io::MeshFormat::glb;  // a placeholder: no mesh is written
  if (flags.format) return *flags.format->mesh;
  if (!flags.output || is_folder(*flags.output)) return mesh_io::MeshFormat::glb;
  if (*flags.output == "-") return refuse_usage("-o - needs --format", "for example --format ply");
  return format_of_path(*flags.output, "choose the format with --format",
                        ", .png for a picture, .vdb, .nrrd, .npy or .vti for the field itself, or .bgeo, .vtu or .xyz "
                        "for particles");
}

Result<convert::Normals> plan_normals(const ConvertFlags& flags, mesh_io::MeshFormat format) {
  if (format == mesh_io::MeshFormat::stl) {
    if (flags.normals.value_or(convert::Normals::flat) == convert::Normals::flat) return convert::Normals::flat;
    return refuse_usage(fmt::format("--normals {} does not work with stl, which always stores one normal per triangle",
                                    word_of(*flags.normals)),
                        "leave out --normals, or choose another format");
  }
  if (reads_mesh(flags) && flags.normals == convert::Normals::smooth) {
    return refuse_usage("--normals smooth: these normals are the gradient of a field, and the input is a mesh",
                        "use --normals area or --normals flat");
  }
  if (flags.heightfield || reads_mesh(flags))
    return flags.normals.value_or(is_gltf(format) ? convert::Normals::area : convert::Normals::none);
  const extract::MethodInfo& method = extract::method_info(plan_surface(flags.surface, flags.input).method);
  if (!method.traits.gradient_normals) {
    // Pictures of surface nets are shaded like the smooth surfaces they approximate.
    const bool shades_smoothly = writes_picture(flags) && method.method == extract::Method::surface_nets;
    const convert::Normals usual = shades_smoothly ? convert::Normals::area : convert::Normals::none;
    if (flags.normals != convert::Normals::smooth) return flags.normals.value_or(usual);
    return refuse_usage(fmt::format("--normals smooth: {}", extract::why_no_gradient_normals(method)),
                        "use --normals flat or --normals area");
  }
  return flags.normals.value_or(is_gltf(format) ? convert::Normals::smooth : convert::Normals::none);
}

std::string_view format_name(const ConvertFlags& flags, const mesh_io::MeshFormatInfo& format) {
  const std::string_view other = non_mesh_extension(flags);
  return other.empty() ? format.name : other;
}

// Checks the output of a single conversion; batches check their outputs elsewhere.
Result<void> check_output_name(const ConvertFlags& flags, const mesh_io::MeshFormatInfo& format) {
  if (!flags.output && files::is_standard_input(flags.input.inputs.front())) {
    return refuse_usage(fmt::format("stdin has no file name, so isoextract cannot name the {}",
                                    writes_field(flags)       ? "field"
                                    : writes_particles(flags) ? "particle file"
                                                              : "mesh"),
                        "give -o FILE, or -o - --format FORMAT for stdout");
  }
  const bool is_mesh = non_mesh_extension(flags).empty();
  if (flags.output != "-" || format.can_stream || !is_mesh) return {};
  return refuse_usage(fmt::format("isoextract cannot write {} to stdout", format.name),
                      format.format == mesh_io::MeshFormat::gltf ? "gltf consists of two files; use --format glb"
                                                                 : "give a file with -o");
}

// Refuses options that cannot be combined with several grids, and says why.
Result<void> check_grids(const ConvertFlags& flags, const convert::ConversionJob& job) {
  const std::vector<std::string>& grids = flags.input.grids;
  for (auto grid = grids.begin(); grid != grids.end(); ++grid) {
    if (std::find(grids.begin(), grid, *grid) == grid) continue;
    return refuse_usage(fmt::format("--grid {} occurs twice", printable(*grid)), "give each grid once");
  }
  if (grids.size() < 2) return {};
  struct OfOneGrid {
    bool given;
    std::string_view why;
  };
  const std::array<OfOneGrid, 7> of_one_grid{
      OfOneGrid{flags.labels.chosen.has_value(), "--labels needs one label map"},
      OfOneGrid{job.writes<convert::FieldFileOptions>() != nullptr, "a field as output is one grid"},
      OfOneGrid{flags.placement.center,
                "--center moves each grid by the center of its own samples, which shifts the "
                "grids against each other"},
      OfOneGrid{job.source.placement.space == convert::Space::index,
                "--space index gives each grid its own voxel coordinates, so the grids do not line up"},
      OfOneGrid{flags.edits.split, "--split-components numbers the components of one grid"},
      OfOneGrid{job.meshes().packing.packs(),
                "--draco, --meshopt, --quantize and .drc files round positions by the voxels of one grid"},
      OfOneGrid{job.source.particles.expected, "particle options are for one set of particles"}};
  const auto* const found = std::ranges::find(of_one_grid, true, &OfOneGrid::given);
  if (found == of_one_grid.end()) return {};
  return refuse_usage(fmt::format("{}; expected one --grid, found {}", found->why, grids.size()),
                      "convert each grid in a run of its own");
}

// Returns how the output would look for a volume with y up, if the output depends on the up axis and no option sets it.
std::optional<std::string> on_side_text(const ConvertFlags& flags, const convert::ConversionJob& job) {
  const convert::Placement& placement = job.source.placement;
  if (flags.placement.up || placement.space == convert::Space::index) return std::nullopt;
  if (job.writes<convert::PictureFileOptions>() != nullptr) return "the picture shows it on its side";
  if (placement.turn_z_up_to_y_up) return "the mesh lies on its side";
  if (flags.html || flags.contact_sheet) {
    return fmt::format("{} shows it on its side", flags.html ? flags.html.name() : flags.contact_sheet.name());
  }
  return std::nullopt;
}

}  // namespace

Result<ConvertPlan> plan_conversion(const ConvertFlags& flags, const std::vector<convert::IsoChoice>& isos,
                                    const Context& context) {
  if (flags.report && (flags.report->empty() || *flags.report == "-")) {
    return refuse_usage(fmt::format("--report needs the name of a file, found '{}'", *flags.report));
  }
  if (flags.output && flags.output->empty()) return refuse_usage("-o needs the name of a file");
  TRY(check_particle_file_options(flags));
  TRY(check_field_options(flags));
  const bool has_surfaces = makes_surfaces(flags);
  TRY(has_surfaces ? check_isos(isos) : Result<void>());
  TRY(check_filters(flags.surface, flags.particles));
  auto shown = TRY(plan_messages(flags.run));
  TRY(refuse_both(flags.run.quiet, flags.explain));

  ConvertPlan plan;
  plan.shown = std::move(shown);
  plan.threads = flags.run.threads;
  if (!plan.threads) plan.threads = threads_of_rank();
  convert::ConversionJob& job = plan.job;
  job.source.read = TRY(plan_read(flags.input));
  job.source.mesh = reads_mesh(flags);
  job.source.particles = TRY(plan_particles(flags.particles, flags.surface.nan, has_attributes(flags)));
  plan.context = context;

  const auto format = TRY(plan_format(flags));
  const mesh_io::MeshFormatInfo& info = mesh_io::mesh_format_info(format);
  const auto picture = TRY(plan_picture(flags));
  const auto by_name = flags.output ? mesh_io::mesh_format_by_path(*flags.output) : std::nullopt;
  if (by_name && (!has_surfaces || writes_picture(flags) || *by_name != format)) {
    plan.notes.push_back(
        {NoteId::format_not_by_name,
         fmt::format("{}: isoextract writes {} because of --format, although the file name suggests another format",
                     *flags.output, format_name(flags, info))});
  }
  if (flags.ascii && format == mesh_io::MeshFormat::obj) {
    return refuse_usage("--ascii applies to ply and stl only, found obj, which is always text", "leave --ascii out");
  }
  if (flags.ascii && !info.has_text_option) {
    return refuse_usage(fmt::format("--ascii applies to ply and stl only, found {}", info.name),
                        "leave --ascii out, or write ply or stl");
  }
  job.normals = TRY(plan_normals(flags, format));
  job.file = convert::MeshFileOptions{format};
  TRY(plan_vertices(flags, isos.size(), job));
  job.file = convert::MeshFileOptions{format, flags.ascii, TRY(plan_packing(flags, format))};
  if (const auto field = field_format(flags)) job.file = convert::FieldFileOptions{flags.half, *field};
  if (const auto particles = particle_file_format(flags)) {
    job.file = convert::ParticleFileOptions{*particles};
    job.source.particles.expected = true;
  }
  if (picture) job.file = *picture;

  auto placement = TRY(!has_surfaces ? convert::Placement()
                                     : plan_placement(flags.placement, format,
                                                      picture                             ? MeshUse::picture
                                                      : flags.html || flags.contact_sheet ? MeshUse::file_and_pictures
                                                                                          : MeshUse::file,
                                                      plan.notes));
  job.source.placement = std::move(placement);
  if (picture) {
    job.source.placement.turn_z_up_to_y_up = false;
    job.source.placement.turn_y_up_to_z_up = false;
  }

  job.surface = plan_surface(flags.surface, flags.input);
  TRY(plan_voxels(flags, plan.notes, job.surface));
  job.verify = flags.verify;
  job.backend = {flags.backend.value_or(convert::Backend::cpu), plan_gpu(flags.device)};
  if (job.backend.backend == convert::Backend::cpu && !job.verify) {
    TRY(flags.refuse(About::gpu, "{} sets up the GPU, which --backend cpu does not use",
                     "give --backend gpu or --backend auto"));
  }
  job.source.away_from_zero = flags.input.inside == InsideChoice::away_from_zero;
  TRY(plan_region(flags.surface, job.source));
  TRY(plan_resolution(flags.surface, job.source));
  TRY(plan_labels(flags.labels, flags.surface, flags.input, job));
  plan_heights(flags, job);
  job.source.filters = flags.surface.filters;
  TRY(plan_edits(flags, job));
  job.empty = flags.empty.value_or(job.empty);
  job.error = flags.error;
  plan.explain = flags.explain;
  plan.report = flags.report;
  plan.pages = TRY(plan_pages(flags, job));
  plan.on_side_text = on_side_text(flags, job);
  TRY(check_grids(flags, job));
  job.source.more_grids = flags.input.more_grids();
  return plan;
}

Result<ConvertPlan> plan_convert(const ConvertFlags& given) {
  const std::vector<std::string>& inputs = given.input.inputs;
  if (inputs.empty()) return refuse_usage("INPUT is missing", "isoextract INPUT --iso V -o OUT.glb");
  ConvertFlags flags = given;
  TRY(take_heights(flags));
  const Context context(plan_memory(flags.input.memory_limit));
  TRY(take_masks(flags));
  Notes found_notes;
  const auto masks = TRY(flags.masks ? find_masks(inputs, found_notes) : std::vector<std::string>());
  if (masks.empty()) TRY(take_mesh(flags, inputs.front(), context));
  const std::string labels_note = TRY(set_default_labels(flags, inputs.front(), context));
  TRY(take_labels(flags));
  auto note = TRY(makes_surfaces(flags) ? set_default_iso(flags, inputs.front(), context) : std::string());
  auto plan = plan_conversion(flags, flags.isos, context);
  if (!plan) return plan;
  if (!note.empty()) plan->notes.push_back({NoteId::iso_chosen, std::move(note)});
  if (!labels_note.empty()) plan->notes.push_back({NoteId::iso_chosen, labels_note});
  plan->notes.insert(plan->notes.end(), found_notes.begin(), found_notes.end());
  plan->job.source.input = inputs.front();
  plan->job.source.masks = masks;
  if (masks.empty()) TRY(plan_found_table(flags.labels, inputs.front(), context, plan->notes, plan->job));
  const mesh_io::MeshFormatInfo& format = mesh_io::mesh_format_info(plan->job.meshes().format);
  TRY(check_output_name(flags, format));
  std::int64_t number = 1;
  if (masks.empty()) number = TRY(batch::find_frames(inputs, std::nullopt, flags.heightfield)).frames.front().number;
  const std::string named_after = masks.empty() ? inputs.front() : name_of_masks(masks);
  batch::OutputSource source{number,     named_after, flags.input.grid().value_or(""),
                             flags.isos, true,        flags.input.more_grids()};
  TRY(find_steps(flags, plan->job.source, context, {&source, 1}));
  std::optional<batch::OutputTemplate> report;
  if (plan->report) {
    auto name = TRY(plan_report_name(*plan->report));
    plan->report = report_path(name, source);
    report = std::move(name);
  }
  auto outputs = TRY(plan_outputs(flags, {&source, 1}, format.format, other_files(flags, {&source, 1}, report)));
  plan->job.outputs = std::move(outputs.front());
  plan->make_folders = flags.batch.make_folders || (flags.output && flags.output->ends_with('/'));
  return plan;
}

std::vector<convert::ConversionJob> plan_named_files(const ConvertFlags& flags) {
  std::vector<std::string> inputs = flags.input.inputs;
  if (inputs.empty()) inputs.emplace_back();
  const auto by_name = flags.output ? mesh_io::mesh_format_by_path(*flags.output) : std::nullopt;
  const auto by_word = flags.format ? flags.format->mesh : std::nullopt;
  const mesh_io::MeshFormat format = by_word.value_or(by_name.value_or(mesh_io::MeshFormat::glb));
  std::vector<convert::ConversionJob> jobs;
  for (const std::string& input : inputs) {
    convert::ConversionJob& job = jobs.emplace_back();
    job.source.input = input;
    job.source.read = plan_read(flags.input).value_or(volume_io::ReadOptions{});
    job.file = convert::MeshFileOptions{format};
    const batch::OutputSource source{1,          input, flags.input.grid().value_or(""),
                                     flags.isos, true,  flags.input.more_grids()};
    auto named = batch::name_outputs_unchecked({&source, 1}, flags.output, format, non_mesh_extension(flags));
    if (named) job.outputs = std::move(named->front());
    if (flags.output) job.outputs.push_back({*flags.output, {}});
  }
  return jobs;
}

}  // namespace isoextract::cli
