#include "cli/render_plan.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/ascii.hpp"
#include "base/counted.hpp"
#include "base/nearest_name.hpp"
#include "batch/find_frames.hpp"
#include "batch/frame_range.hpp"
#include "batch/output_names.hpp"
#include "batch/output_template.hpp"
#include "cli/batch_plan.hpp"
#include "cli/particle_plan.hpp"
#include "cli/plan.hpp"
#include "cli/plan_parts.hpp"
#include "cli/voxel_plan.hpp"
#include "convert/picture_file.hpp"
#include "convert/surface_edits.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"
#include "mesh_io/mesh_reader.hpp"

namespace isoextract::cli {
namespace {

constexpr int kMostTurns = 100000;

// Inputs by kind: names with a mesh extension are meshes, all other names volumes; the content decides for standard
// input.
struct Inputs {
  std::vector<std::string> volumes;
  std::vector<std::string> meshes;
};

Inputs sorted_inputs(const RenderFlags& flags, const MemoryBudget& memory) {
  Inputs inputs;
  const bool is_raw = flags.input.dims && flags.input.inputs.size() == 1;
  const bool may_be_mesh = !flags.particles.method && !flags.input.format && !is_raw;
  for (const std::string& input : flags.input.inputs) {
    const bool is_mesh = mesh_io::mesh_format_by_path(input) || (may_be_mesh && files::is_standard_input(input) &&
                                                                 mesh_io::holds_mesh(input, Context(memory)));
    (is_mesh ? inputs.meshes : inputs.volumes).push_back(input);
  }
  // Options can say that PLY and other mesh files hold particles.
  if (inputs.volumes.empty() && (flags.particles.method || flags.input.format))
    std::swap(inputs.volumes, inputs.meshes);
  if (!flags.frames) name_volume_of_files(inputs.volumes);
  return inputs;
}

// Parses the number of pictures of a turn.
Result<int> turns_of(const std::string& text) {
  int count = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (problem != std::errc() || end != text.data() + text.size() || count < 1 || count > kMostTurns) {
    const bool is_range =
        batch::FrameRange::parse(text).has_value() && text.find_first_not_of(kDigits) != std::string::npos;
    return refuse_usage(
        fmt::format("--frames: expected the number of pictures for one turn of the camera, 1 to {}, found '{}'",
                    kMostTurns, text),
        is_range ? "only a sequence takes a range of frames, and the inputs are no sequence" : "");
  }
  return count;
}

// Sets the plan's pictures and its missing frames.
Result<void> plan_frames(const RenderFlags& flags, const Inputs& inputs, RenderPlan& plan) {
  std::vector<PicturePlan>& pictures = plan.pictures;
  const bool sequence =
      inputs.volumes.size() > 1 || (inputs.volumes.size() == 1 && is_frame_pattern(inputs.volumes[0]));
  if (!sequence) {
    int count = 1;
    if (flags.frames) {
      count = TRY(turns_of(*flags.frames));
    }
    for (int i = 0; i < count; ++i) {
      PicturePlan picture;
      picture.frame = i + 1;
      if (!inputs.volumes.empty()) picture.input = inputs.volumes.front();
      picture.turn = 360.0 * i / count;
      pictures.push_back(std::move(picture));
    }
    return {};
  }
  std::optional<batch::FrameRange> range;
  if (flags.frames) {
    range = TRY(batch::FrameRange::parse(*flags.frames));
  }
  auto found = TRY(batch::find_frames(inputs.volumes, range));
  for (Note& note : found.notes) plan.notes.push_back(std::move(note));
  if (flags.frames) {
    plan.missing = std::move(found.gaps);
  } else if (!found.gaps.empty()) {
    plan.notes.push_back({NoteId::missing_frames, fmt::format("the inputs lack the frames {}",
                                                              batch::text_of(found.gaps, batch::kShownFrameRuns))});
  }
  for (batch::Frame& frame : found.frames) {
    if (frame.volume) {
      return refuse_usage(fmt::format("{}: render cannot draw the time steps of one file as frames", frame.input),
                          "choose one time step with --volume");
    }
    PicturePlan picture;
    picture.frame = frame.number;
    picture.input = std::move(frame.input);
    pictures.push_back(std::move(picture));
  }
  return {};
}

// Refuses the placeholders of surfaces: a picture shows all of them.
Result<void> check_placeholders(const std::string& output) {
  const auto name = batch::OutputTemplate::parse(output);
  if (!name) return {};  // name_outputs() reports that
  for (const batch::OutputWord word : {batch::OutputWord::iso, batch::OutputWord::label, batch::OutputWord::name}) {
    if (!name->uses(word)) continue;
    return refuse_usage(fmt::format("-o {}: a picture shows all surfaces, not one", output),
                        fmt::format("leave {{{}}} out", word_of(word)));
  }
  return {};
}

// Rewords the hint about two pictures of one name: only these placeholders tell pictures apart.
Error with_hint_of_pictures(Error error, bool is_turn) {
  for (Step& step : error.hint.steps) {
    if (step.setting != Setting::output_name || step.text.empty()) continue;
    step.text = is_turn ? "with {} or {:04} in it, the number of the picture"
                        : "with {}, {:04} or {stem} in it, the number of the frame or the name of the input";
  }
  return error;
}

Result<void> name_pictures(const RenderFlags& flags, const Inputs& inputs, std::vector<PicturePlan>& pictures) {
  if (flags.output && flags.output->empty()) return refuse_usage("-o needs the name of a file");
  if (flags.output == "-") {
    if (pictures.size() > 1)
      return refuse_usage("render writes several pictures to files, not to stdout", "give a name with -o");
    pictures.front().output = "-";
    return {};
  }
  if (!flags.output && std::ranges::any_of(flags.input.inputs, files::is_standard_input)) {
    return refuse_usage("stdin has no file name, so isoextract cannot name the picture",
                        "give -o FILE, or -o - for stdout");
  }
  std::vector<batch::OutputSource> sources;
  for (const PicturePlan& picture : pictures) {
    sources.push_back({picture.frame,
                       picture.input.value_or(inputs.meshes.empty() ? "" : inputs.meshes.front()),
                       flags.input.grid().value_or(""),
                       {}});
  }
  if (flags.output && flags.output->find(convert::kPiecePlaceholder) != std::string::npos) {
    return refuse_usage(fmt::format("-o {}: a picture shows the whole mesh, not one body", *flags.output),
                        fmt::format("leave {} out", convert::kPiecePlaceholder));
  }
  if (flags.output) TRY(check_placeholders(*flags.output));
  const auto named = batch::name_outputs(sources, flags.output, mesh_io::MeshFormat::glb, "png");
  const bool is_turn = pictures.size() > 1 && pictures[0].input == pictures[1].input;
  if (!named) return tl::unexpected(with_hint_of_pictures(named.error(), is_turn));
  const auto& names = *named;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    pictures[i].output = names[i].front().path;
    if (!picture_file_of(pictures[i].output)) {
      return refuse_usage(fmt::format("{}: expected a name that ends in .png or .exr", pictures[i].output));
    }
  }
  return {};
}

// Rejects options that have no effect on what is drawn.
Result<void> check_useful(const RenderFlags& flags, const Inputs& inputs, const RenderPlan& plan) {
  const bool surfaces = !plan.isos.empty();
  if (!surfaces) {
    TRY(flags.refuse(About::drawn_surface, "{} applies to surfaces of a volume and needs --iso or --labels",
                     "leave {} out, or give a volume and --iso V"));
  }
  if (surfaces && inputs.volumes.empty()) {
    return refuse_usage(fmt::format("{} needs a volume, but all inputs are meshes",
                                    flags.labels.chosen ? flags.labels.chosen.name() : flags.isos.name()));
  }
  if (flags.opacity && !surfaces && inputs.meshes.empty()) {
    return refuse_usage("--opacity applies to surfaces and meshes, and the scene has none",
                        "leave --opacity out, or give --iso V, or a mesh");
  }
  if (flags.mesh_colors && inputs.meshes.empty()) {
    return refuse_usage("--mesh-color applies to meshes that are inputs, and this scene has none",
                        "leave --mesh-color out, or give a mesh");
  }
  if (flags.color && flags.color->attribute) {
    return refuse_usage("--color-by: 'isoextract render' colors surfaces only by their iso values",
                        "give --color-by iso");
  }
  if (flags.opacity && flags.opacity->size() > 1 && flags.labels.is_set_of_labels()) {
    return refuse_usage("--opacity: expected one value, because a label map has any number of labels");
  }
  const std::size_t parts = plan.isos.size() + inputs.meshes.size();
  if (flags.opacity && flags.opacity->size() != 1 && flags.opacity->size() != parts) {
    return refuse_usage(fmt::format("--opacity: expected one value{}, found {} values",
                                    parts > 1 ? fmt::format(", or {}: one for each iso value and mesh", parts) : "",
                                    flags.opacity->size()));
  }
  if (!plan.draws_volume) {
    TRY(flags.refuse(About::drawn_volume, "{} applies to the drawn volume, and this scene draws none",
                     "leave {} out, or give a volume with --tf NAME"));
  }
  if (plan.transfer_file && flags.transfer_range) {
    return refuse_usage("--tf-range scales built-in transfer functions, but --tf gives a file, which states its values",
                        "leave --tf-range out");
  }
  if (!plan.draws_volume && plan.isos.empty() && inputs.meshes.empty()) {
    return refuse_usage("the scene is empty: --tf none does not draw the volume", "give --iso V, or a mesh");
  }
  return {};
}

}  // namespace

std::optional<PictureFile> picture_file_of(const std::string& path) {
  const std::string extension = extension_of(path);
  if (path == "-" || extension == ".png") return PictureFile::png;
  if (extension == ".exr") return PictureFile::exr;
  return std::nullopt;
}

Result<RenderPlan> plan_render(const RenderFlags& given) {
  RenderFlags flags = given;
  if (flags.input.inputs.empty())
    return refuse_usage("INPUT is missing", "isoextract render INPUT [MESH...] -o FILE.png");
  RenderPlan plan;
  plan.memory = plan_memory(flags.input.memory_limit);
  const Inputs inputs = sorted_inputs(flags, plan.memory);
  TRY(refuse_several_grids(flags.input, "render"));
  plan.job.source.read = TRY(plan_read(flags.input));
  if (!inputs.volumes.empty() && !is_frame_pattern(inputs.volumes.front()) &&
      draws_all_labels(flags, inputs.volumes.front(), Context(plan.memory))) {
    flags.labels.choose_all(std::string(kLabelsOfFile));
    plan.notes.push_back({NoteId::iso_chosen,
                          "all labels, because the file names its labels; choose some with --labels L,..., or give "
                          "--iso V or --tf NAME"});
  }
  TRY(take_labels(flags.labels, flags.surface, flags.isos));
  plan.job.source.particles = TRY(plan_particles(flags.particles, flags.surface.nan));
  plan.has_radius_of_each_frame = flags.particles.radius && flags.particles.radius->is_of_each_frame;
  plan.job.source.away_from_zero = flags.input.inside == InsideChoice::away_from_zero;
  TRY(plan_region(flags.surface, plan.job.source));
  TRY(plan_resolution(flags.surface, plan.job.source));
  plan.job.source.filters = flags.surface.filters;
  plan.job.source.blurs = flags.surface.blurs;
  plan.job.surface = plan_surface(flags.surface, flags.input);
  TRY(plan_labels(flags.labels, flags.surface, flags.input, plan.job));
  plan.isos = flags.isos;
  TRY(check_isos(plan.isos));
  plan.meshes = inputs.meshes;
  const bool has_voxel_faces = plan.job.surface.method == extract::Method::voxels;
  plan.shading = flags.shading.value_or(has_voxel_faces ? render::Shading::flat : render::Shading::smooth);
  const bool gradients = extract::method_info(plan.job.surface.method).traits.gradient_normals;
  plan.job.normals =
      plan.shading == render::Shading::smooth && gradients ? convert::Normals::smooth : convert::Normals::none;
  if (flags.color) {
    plan.job.color = convert::ColorChoice{std::nullopt, flags.color->map, flags.color->range};
  }
  plan.opacity = flags.opacity.value_or(plan.opacity);
  plan.draws_volume = !inputs.volumes.empty() && !flags.labels.chosen;
  if (flags.transfer) {
    if (inputs.volumes.empty()) return refuse_usage("--tf needs a volume, but all inputs are meshes");
    const auto named = transfer_of(*flags.transfer);
    plan.draws_volume = *flags.transfer != "none";
    if (!plan.draws_volume) {
      // Surfaces only.
    } else if (named) {
      plan.transfer = *named;
    } else {
      const std::vector<std::string> names = transfer_names();
      if (!files::is_there(*flags.transfer)) {
        const std::string near = nearest_name(*flags.transfer, names);
        return refuse_usage(
            fmt::format("--tf: expected one of {}, or a file, found '{}'", fmt::join(names, ", "), *flags.transfer),
            near.empty() ? "" : fmt::format("did you mean '{}'?", near));
      }
      plan.transfer_file = *flags.transfer;
    }
  }
  TRY(check_useful(flags, inputs, plan));
  if (plan.draws_volume && (flags.surface.roi || !flags.surface.clip.empty())) {
    plan.notes.push_back(
        {NoteId::no_effect, fmt::format("{} cuts only the surfaces: render draws the whole volume",
                                        flags.surface.roi ? flags.surface.roi.name() : flags.surface.clip.name())});
  }
  plan.transfer_range = flags.transfer_range;
  plan.unit_length = flags.unit_length;
  plan.emission = flags.emission;
  plan.camera = flags.view.angles();
  plan.fovy = flags.view.fovy();
  if (flags.up) plan.up = convert::render_up_axis(*flags.up);
  plan.options.size = flags.view.size.value_or(plan.options.size);
  plan.options.samples_per_voxel = flags.samples.value_or(plan.options.samples_per_voxel);
  plan.options.early_termination = flags.termination != 0.0;
  if (flags.termination.value_or(0) > 0) plan.options.termination = *flags.termination;
  plan.rays_across = flags.antialias;
  plan.options.empty_space_skipping = !flags.no_skipping;
  plan.background = flags.view.background.value_or(plan.background);
  plan.mesh_colors = flags.mesh_colors.value_or(plan.mesh_colors);
  if (plan.mesh_colors.size() > 1 && plan.mesh_colors.size() != plan.meshes.size()) {
    return refuse_usage(
        fmt::format("--mesh-color: expected one color or one color for each mesh, found {} colors for {}",
                    plan.mesh_colors.size(), counted(plan.meshes.size(), "mesh", "meshes")));
  }
  plan.backend = flags.backend.value_or(plan.backend);
  plan.gpu = plan_gpu(flags.device);
  if (flags.json && (flags.json->empty() || *flags.json == "-")) {
    return refuse_usage(fmt::format("--json needs the name of a file, found '{}'", *flags.json));
  }
  plan.json = flags.json;
  TRY(plan_frames(flags, inputs, plan));
  plan.is_sequence = plan.pictures.size() > 1 && plan.pictures[1].input != plan.pictures[0].input;
  if (plan.is_sequence && !plan.camera.is_fixed()) {
    plan.notes.push_back({NoteId::one_camera,
                          "the first picture sets the camera for all pictures, so later frames may leave the view; "
                          "--camera AZ,EL,DISTANCE and --look-at X,Y,Z set another camera"});
  }
  TRY(name_pictures(flags, inputs, plan.pictures));
  if (const auto& volume = plan.pictures.front().input) {
    TRY(plan_found_table(flags.labels, *volume, Context(plan.memory), plan.notes, plan.job));
  }
  return plan;
}

}  // namespace isoextract::cli
