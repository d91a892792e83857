#include "cli/voxel_plan.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "cli/particle_file_plan.hpp"
#include "cli/particle_plan.hpp"
#include "cli/plan.hpp"
#include "cli/plan_parts.hpp"
#include "convert/particle_source.hpp"
#include "extract/method.hpp"
#include "field/demo_field.hpp"
#include "files/file_bytes.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {

namespace {

constexpr std::string_view kNoTable = "none";  // of --label-names

bool is_for_labels(extract::Method method) {
  return method == extract::Method::voxels || method == extract::Method::surface_nets;
}

// Returns whether the grid that the options choose names its labels.
bool names_labels(const std::string& input, const volume_io::ReadOptions& read, const Context& context) {
  const auto grids = volume_io::list_grids(input, read, context.beside());
  if (!grids) return false;
  return std::ranges::any_of(*grids, [&](const volume_io::GridInfo& grid) {
    return !grid.labels.empty() && (!read.grid || grid.matches_name(*read.grid));
  });
}

// Returns whether the grid that the options choose stores integers.
bool stores_integers(const std::string& input, const volume_io::ReadOptions& read, const Context& context) {
  constexpr std::array kIntegers{"u8", "i8", "u16", "i16", "u32", "i32", "u64", "i64", "int32", "int64", "bool"};
  const auto grids = volume_io::list_grids(input, read, context.beside());
  if (!grids) return false;
  const auto fits = [&](const volume_io::GridInfo& grid) { return !read.grid || grid.matches_name(*read.grid); };
  const auto grid = std::ranges::find_if(*grids, fits);
  return grid != grids->end() && std::ranges::find(kIntegers, grid->type) != kIntegers.end();
}

bool is_table_named(const LabelFlags& flags) { return flags.names && *flags.names != kNoTable; }

}  // namespace

Result<std::string> set_default_labels(ConvertFlags& flags, const std::string& input, const Context& context) {
  const bool chooses = flags.labels.chosen || !flags.isos.empty() || flags.batch.iso_table || !makes_surfaces(flags);
  if (chooses || flags.input.grids.size() > 1) return std::string();
  if (flags.surface.method && !is_for_labels(*flags.surface.method)) return std::string();
  volume_io::ReadOptions read = TRY(plan_read(flags.input));
  auto particles = TRY(plan_particles(flags.particles, flags.surface.nan, has_attributes(flags)));
  if (particles.expected || (files::is_standard_input(input) && !read.format)) return std::string();
  convert::SourceOptions source;
  source.input = input;
  source.read = read;
  source.particles = std::move(particles);
  if (convert::is_particles(source, context.beside()).value_or(true)) return std::string();
  if (!names_labels(input, read, context)) {
    const bool wants_nets = flags.surface.method == extract::Method::surface_nets;
    if (!wants_nets || !stores_integers(input, read, context)) return std::string();
    constexpr double kAboveZero = 0.5;
    flags.isos.emplace_back(kAboveZero);
    return fmt::format(
        "iso {}, because the samples are integers, such as those of a mask: all above 0 are inside; choose another "
        "with "
        "--iso V, or give --labels all for a surface of each label",
        kAboveZero);
  }
  flags.labels.choose_all(std::string(kLabelsOfFile));
  return std::string("all labels, because the file names its labels; choose some with --labels L,..., or give --iso V");
}

bool draws_all_labels(const RenderFlags& flags, const std::string& volume, const Context& context) {
  const bool chooses = flags.labels.chosen || !flags.isos.empty() || flags.transfer || flags.particles.method;
  if (chooses || (flags.surface.method && !is_for_labels(*flags.surface.method))) return false;
  if (files::is_standard_input(volume) || volume.starts_with(field::kDemoPrefix)) return false;
  const auto read = plan_read(flags.input);
  return read && names_labels(volume, *read, context);
}

Result<void> take_labels(const LabelFlags& flags, SurfaceFlags& surface, IsoOption& isos) {
  if (!flags.chosen) {
    if (is_table_named(flags)) return refuse_usage("--label-names needs --labels", "give --labels all");
    if (flags.min_voxels) return refuse_usage("--labels-min-voxels needs --labels", "give --labels all");
    if (flags.background) return refuse_usage("--background needs --labels", "give --labels all");
    return {};
  }
  if (!surface.method) surface.method = extract::Method::surface_nets;
  const extract::MethodInfo& method = extract::method_info(*surface.method);
  if (!is_for_labels(method.method)) {
    return refuse_usage(
        fmt::format("{} does not work with {}, which places surfaces between ordered values, and labels have no order",
                    flags.asked_by, method.title),
        "leave out --method, or give --method voxels");
  }
  TRY(refuse_both(flags.chosen, isos));
  isos = *flags.chosen;
  return {};
}

Result<void> take_labels(ConvertFlags& flags) {
  TRY(take_labels(flags.labels, flags.surface, flags.isos));
  if (!flags.labels.chosen) return {};
  TRY(refuse_both(flags.labels.chosen, flags.batch.iso_table));
  if (flags.labels.is_set_of_labels() && flags.output && flags.output->find("{iso}") != std::string::npos) {
    return refuse_usage(
        "only numbers of labels work with {iso} in -o: isoextract needs the file names before it reads the labels",
        "put {label} or {name} into the name instead, or write all labels into one glb");
  }
  return {};
}

Result<void> plan_labels(const LabelFlags& flags, const SurfaceFlags& surface, const InputFlags& input,
                         convert::ConversionJob& job) {
  if (!flags.chosen) return {};
  if (input.inside) {
    return refuse_usage(
        fmt::format("--inside does not work with {}: the inside of a label always consists of its own samples",
                    flags.asked_by),
        "leave --inside out");
  }
  if (input.component && !input.component->number) {
    return refuse_usage(
        fmt::format("--component length does not work with {}: the length of a vector is no label", flags.asked_by),
        "choose one component with --component K");
  }
  if (!surface.blurs.empty()) {
    return refuse_usage(
        fmt::format("--blur does not work with {}: the average of two labels is no label", flags.asked_by),
        "leave --blur out, or smooth the meshes with --smooth");
  }
  const field::ResampleKernel kernel = surface.kernel.value_or(field::ResampleKernel::majority);
  if (kernel != field::ResampleKernel::majority && kernel != field::ResampleKernel::nearest) {
    return refuse_usage(fmt::format("--kernel {} does not work with {}: a value between two labels is no label",
                                    word_of(kernel), flags.asked_by),
                        "leave --kernel out: resampling then takes the label of most voxels");
  }
  if (job.source.resamples()) job.source.kernel = kernel;
  job.surface.background = flags.background.value_or(0);
  job.surface.least_voxels = flags.min_voxels.value_or(0);
  if (!is_table_named(flags)) return {};
  const auto table = TRY(volume_io::LabelTable::read(*flags.names, Context()));
  job.label_names = convert::LabelTableFile{*flags.names, table.hash()};
  return {};
}

std::optional<TableBeside> read_table_beside(const std::string& input, const Context& context, Notes& notes) {
  if (input.starts_with(field::kDemoPrefix) || files::is_standard_input(input)) return std::nullopt;
  const auto path = volume_io::find_label_table(input);
  if (!path) return std::nullopt;
  auto table = volume_io::LabelTable::read(path->string(), context.beside());
  if (!table) {
    notes.push_back({NoteId::label_table, fmt::format("{} lies beside the input and has the name of a label table, but "
                                                      "isoextract does not use it: {}",
                                                      printable(path->string()), table.error().message)});
    return std::nullopt;
  }
  return TableBeside{path->string(), std::move(*table)};
}

Result<void> plan_found_table(const LabelFlags& flags, const std::string& input, const Context& context, Notes& notes,
                              convert::ConversionJob& job) {
  if (!flags.chosen || flags.names) return {};
  Notes unusable;
  const auto found = read_table_beside(input, context, unusable);
  if ((!found && unusable.empty()) || names_labels(input, job.source.read, context)) return {};
  notes.insert(notes.end(), unusable.begin(), unusable.end());
  if (!found) return {};
  job.label_names = convert::LabelTableFile{found->path, found->table.hash()};
  notes.push_back(
      {NoteId::label_table,
       fmt::format("names and colors of labels come from {}, which lies beside {} (--label-names none: from no table)",
                   printable(found->path), printable(input))});
  return {};
}

Result<void> plan_voxels(const ConvertFlags& flags, Notes& notes, convert::SurfaceOptions& surface) {
  const extract::MethodInfo& method = extract::method_info(surface.method);
  if (method.traits.always_closed && surface.cap && flags.surface.clip.empty()) {
    notes.push_back({NoteId::no_effect,
                     fmt::format("--cap changes nothing: the surface of {} is closed everywhere", method.title)});
  }
  if (surface.nan == extract::NanPolicy::hole && !extract::why_no_holes(method).empty()) {
    return refuse_usage(fmt::format("--nan hole: {}", extract::why_no_holes(method)), "use --nan outside");
  }
  if (flags.relaxations && surface.method != extract::Method::surface_nets) {
    return refuse_usage(fmt::format("--relax does not work with {}", method.title), "give --method surface-nets");
  }
  surface.relaxations = flags.relaxations.value_or(surface.relaxations);
  if (flags.labels.chosen && flags.edits.smooth) {
    notes.push_back({NoteId::labels_part,
                     "--smooth changes the mesh of each label separately, so the shared faces of neighboring labels no "
                     "longer match"});
  }
  if (flags.edits.smooth && flags.t_junctions) {
    return refuse_usage(
        "--smooth does not work with --t-junctions: smoothing would move vertices away from the edges they lie on",
        "leave --t-junctions out");
  }
  const bool simplifies_labels = flags.labels.chosen && (flags.simplify || flags.triangles);
  const std::string_view simplifier = flags.simplify ? flags.simplify.name() : flags.triangles.name();
  if (simplifies_labels && flags.t_junctions) {
    return refuse_usage(
        fmt::format(
            "{} does not work with --t-junctions on labels: neighboring labels would have no triangles in common",
            simplifier),
        "leave --t-junctions out");
  }
  if (simplifies_labels && surface.method == extract::Method::voxels) {
    // Each label merges its faces in its own way.
    surface.voxel_faces = extract::VoxelFaces::plain;
  }
  if (flags.edits.smooth && surface.method == extract::Method::voxels && !flags.no_merge) {
    // Merged faces can be as long as the mesh; smoothing such triangles would destroy the shape.
    surface.voxel_faces = extract::VoxelFaces::plain;
    notes.push_back(
        {NoteId::faces_not_merged, "--smooth needs the separate faces of voxels, so the extraction merges no faces"});
  }
  if (!flags.no_merge && !flags.t_junctions) return {};
  TRY(refuse_both(flags.no_merge, flags.t_junctions, "separate faces have no T-junctions"));
  if (surface.method != extract::Method::voxels) {
    TRY(flags.refuse(About::voxel_faces,
                     fmt::format("{{}} does not work with {}, which makes no faces of voxels", method.title),
                     "give --method voxels"));
  }
  surface.voxel_faces = flags.no_merge ? extract::VoxelFaces::plain : extract::VoxelFaces::rectangles;
  return {};
}

}  // namespace isoextract::cli
