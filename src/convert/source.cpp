#include "convert/source.hpp"

#include <algorithm>
#include <filesystem>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/printable.hpp"
#include "convert/detail/lost_labels.hpp"
#include "convert/detail/mesh_source.hpp"
#include "convert/detail/place_report.hpp"
#include "convert/field_label.hpp"
#include "convert/json_values.hpp"
#include "convert/particle_choice.hpp"
#include "convert/particle_field.hpp"
#include "convert/placement_record.hpp"
#include "convert/simulation_box.hpp"
#include "convert/stages/field_blur.hpp"
#include "convert/stages/level_set_filter.hpp"
#include "convert/stages/level_set_rebuild.hpp"
#include "convert/stages/mesh_clip.hpp"
#include "field/resample.hpp"
#include "files/file_bytes.hpp"
#include "points/neighbor_counts.hpp"
#include "points/region.hpp"
#include "points/simulation_box.hpp"

namespace isoextract::convert {
namespace {

StageReport report_of_reading(const std::string& input, const field::ScalarField& field, const StageTime& time) {
  const field::IndexBox box = field.extents();
  const std::size_t size = field::sample_size(field.type());
  std::uint64_t samples = 0;  // all samples, for sparse fields the active voxels
  std::uint64_t stored = 0;
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  if (dense != nullptr) {
    samples = stored = dense->count();
  } else {
    constexpr std::uint64_t kSide = field::SparseBlock::kSize;
    const auto& sparse = std::get<field::SparseSamples>(field.samples);
    samples = sparse.active_voxels;
    stored = sparse.blocks.size() * kSide * kSide * kSide;
  }
  std::error_code none;
  const std::uintmax_t file_bytes = std::filesystem::file_size(input, none);
  const glm::i64vec3 dims = box.empty() ? glm::i64vec3(0) : box.dims();
  StageReport report = report_on(StageName::read, field_label(field));
  report.time = time;
  report.did = "read";
  report.entries.push_back(
      {{Key::path, input},
       {Key::format, field.format},
       {Key::name, field.name},
       {Key::file_bytes, none ? Value() : Value(file_bytes)},
       {Key::sparse, dense == nullptr},
       {Key::sample_type, field::sample_type_name(field.type())},
       {Key::samples, samples},
       {Key::stored_bytes, stored * size},
       {Key::box, Value(box)},
       {Key::dims, Value::List{dims.x, dims.y, dims.z}},
       {Key::kind, kind_name(field.kind)},
       {Key::inside, word_of(field.kind)},
       {Key::value_scale, Figures{{Key::slope, field.scale.slope}, {Key::intercept, field.scale.intercept}}},
       {Key::index_to_world, Value(field.index_to_world)},
       {Key::world_space, field.world_space},
       {Key::length_unit, field.length_unit},
       {Key::creator, field.creator}});
  return report;
}

// Notes the actual voxel size if it differs from the requested one by more than rounding.
void tell_voxel_size(const glm::dvec3& asked, const field::ScalarField& grid, Events& events) {
  const glm::dmat3& axes = grid.index_to_world.linear;
  const glm::dvec3 made(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2]));
  constexpr double kRounding = 1e-6;
  if (glm::all(glm::lessThanEqual(glm::abs(made - asked), kRounding * asked))) return;
  events.note(
      {NoteId::voxel_size,
       fmt::format("{}: voxels of {:.6g} x {:.6g} x {:.6g} instead of {:.6g} x {:.6g} x {:.6g}, so that whole voxels "
                   "fill the box of the data",
                   field_label(grid), made.x, made.y, made.z, asked.x, asked.y, asked.z)});
}

// Replaces the field by one resampled at the requested resolution.
Result<void> change_resolution(const SourceOptions& options, const SourceUse& use, const Context& context,
                               Events& events, Source& source) {
  if (use.field_format) {
    auto rebuilt = TRY(rebuild_level_set(options, *use.field_format, source.field, context, events));
    if (rebuilt) {
      source.field = std::move(*rebuilt);
      return context.check();
    }
  }
  const Stopwatch watch;
  auto resolution = TRY(options.resolution ? Result<glm::ivec3>(*options.resolution)
                                           : field::resolution_of_voxel_size(source.field, *options.voxel_size));
  auto grid = TRY(field::resample(source.field, resolution, options.kernel, use.nan, context));
  const StageReport report = report_on_field(StageName::resample, field_label(source.field),
                                             resolution_fact(source.field, grid), watch.elapsed());
  for (const Note& text : grid.notes) events.note(text);
  events.end(report);
  const auto is_all = [](const IsoChoice& iso) { return iso.kind == IsoChoice::Kind::all_labels; };
  if (std::ranges::any_of(use.isos, is_all)) tell_lost_labels(source.field, grid, use.background, context, events);
  if (options.voxel_size) tell_voxel_size(*options.voxel_size, grid, events);
  if (use.keep_data && !source.data) source.data = std::move(source.field);
  source.field = std::move(grid);
  return context.check();
}

// Reports the iso values that were found in the field.
void tell_isos(const std::optional<StageTime>& time, Events& events, const Source& source) {
  if (std::ranges::all_of(source.isos, [](const ResolvedIso& iso) { return !iso.asked.is_found(); })) return;
  StageReport report = report_on(StageName::statistics, field_label(source.field));
  report.time = time;
  if (time) report.did = "iso values found";
  for (const ResolvedIso& iso : source.isos) {
    report.entries.push_back(
        {{Key::asked, iso.asked.is_number() ? Value(iso.asked.id.iso()) : Value(text_of(iso.asked))},
         {Key::iso, iso.id},
         {Key::found_by, iso.asked.is_found() ? Value(iso.found_by) : Value()}});
  }
  events.end(report);
  for (const ResolvedIso& iso : source.isos) {
    if (!iso.asked.is_found()) continue;
    const std::string word = iso.asked.by_default ? "" : text_of(iso.asked) + " is ";
    events.note({NoteId::iso_chosen,
                 fmt::format("{}: iso {}{}: {}", field_label(source.field), word, iso.id.text(), iso.found_by)});
  }
}

// Returns whether samples outside the region, and not next to it, cannot change the result. Such samples
// matter if an iso value or attribute depends on all samples, or if a step reads samples that are farther away.
bool needs_region_only(const SourceOptions& options, const SourceUse& use) {
  return options.roi && options.placement.space != Space::index && !use.outside_region && options.filters.empty() &&
         options.blurs.empty() && !options.resamples() && options.attributes.empty() &&
         std::ranges::all_of(use.isos, &IsoChoice::is_number);
}

Result<void> read_volume_field(const SourceOptions& options, const SourceUse& use, const Context& context,
                               Events& events, Source& source) {
  volume_io::ReadOptions read = options.read;
  read.sampling = options.voxel_size;
  read.by_layers = use.by_layers;
  read.label_ids = std::ranges::any_of(use.isos, &IsoChoice::is_label);
  if (needs_region_only(options, use)) read.region = options.roi;
  source.field = TRY(use.masks != nullptr ? use.masks->layer(read.volume.value_or(0), context)
                                          : read_field(options.input, read, context, events));
  StageReport facts = report_on(StageName::read, field_label(source.field));
  facts.work = reading_facts(source.field, options.more_grids.size());
  if (!facts.work.empty()) events.end(facts);
  const Stopwatch watch;
  source.isos = TRY(resolve_isos(use.isos, source.field, use.empty_is_fine, context));
  tell_isos(watch.elapsed(), events, source);
  if (options.attributes.empty()) return {};
  const Stopwatch reading;
  auto attributes = TRY(read_volume_attributes(options, source.field, use.empty_is_fine, context));
  StageReport report = report_on(StageName::read_attributes, field_label(source.field));
  report.time = reading.elapsed();
  report.did = "attributes read";
  events.end(report);
  for (const VolumeAttribute& attribute : attributes.found) {
    for (const Note& text : attribute.notes) events.note(text);
    report = report_on(StageName::read_attributes, field_label(source.field));
    report.work.push_back(attribute_fact(attribute));
    events.end(report);
  }
  source.attributes.emplace();
  source.attributes->from = std::move(attributes.found);
  source.attributes->missing = std::move(attributes.missing);
  return {};
}

// Notes missing optional attributes. Missing required attributes fail later, and only if there is a surface.
void tell_missing(const std::vector<MissingAttribute>& missing, const std::string& label, Events& events) {
  for (const MissingAttribute& attribute : missing) {
    if (!attribute.choice.optional) continue;
    events.note({NoteId::attribute_missing, fmt::format("{}: converted without the optional attribute '{}': {}", label,
                                                        printable(attribute.choice.name), attribute.error.message)});
    StageReport report = report_on(StageName::read_attributes, label);
    report.entries.push_back({{Key::attribute, attribute.choice.name}});
    events.end(report);
  }
}

// Runs two stages: reads particles, and makes a field from them.
Result<void> read_particle_field(const SourceOptions& options, const SourceUse& use, const Context& context,
                                 Events& events, Source& source) {
  source.isos = TRY(resolve_isos(use.isos, options.particles.method, printable(files::input_label(options.input))));
  Stopwatch watch;
  auto file =
      TRY(particle_io::read_particles(options.input, particle_read_options(options, use.empty_is_fine), context));
  const StageTime reading = watch.elapsed();
  const auto tell_notes = [&] {
    for (const Note& text : std::exchange(file.notes, {})) events.note(text);
  };
  tell_notes();
  TRY(context.check());
  const auto chosen = TRY(keep_chosen(file.particles, options.particles, context));
  TRY(give_element_radii(file, options, context));
  tell_notes();
  file.particles.words.clear();
  if (chosen && chosen->chosen == 0) source.why_no_particles = why_none_chosen(*chosen, options.particles);
  TRY(apply_box_options(options.particles.simulation_box, file.particles));
  points::FieldOptions asked = field_options(options, use.only_iso);
  std::optional<ParticleCount> near_region;
  if (const auto region = region_of_particles(options); region && !use.outside_region) {
    const std::uint64_t all = file.particles.size();
    const std::uint64_t removed = TRY(points::keep_region(file.particles, *region, asked, context));
    near_region = {all - removed, all};
  }
  auto found = TRY(find_attributes(file.particles, options.attributes, use.empty_is_fine));
  watch.restart();
  const SphereSpacing chosen_spacing = TRY(choose_sphere_spacing(file.particles, options, context));
  for (const Note& text : chosen_spacing.notes) events.note(prefixed(printable(file.particles.label) + ": ", text));
  asked.spacing = chosen_spacing.spacing;
  // Vertices get attributes from the particles near them.
  const bool is_needed = !options.attributes.empty() || use.counts_neighbors;
  auto made = TRY(make_particle_field(file.particles, is_needed ? Positions::keep : Positions::free, asked, context));
  if (made.region && options.resamples()) {
    return fail(
        ErrorCode::usage,
        fmt::format("{}: a periodic box does not allow resampling, because a whole number of cells has to fill the box",
                    printable(file.particles.label)),
        {{Remedy::leave_out, Setting::resampling, "the cell size is the distance between samples"},
         {Remedy::change, Setting::cell_size},
         {Remedy::set, Setting::periodic_edges, "none to convert the particles without periods"}});
  }
  source.period = made.region;
  made.field.name = stem_of_file(files::input_label(options.input));
  made.field.length_unit = file.length_unit;
  made.field.creator = std::move(file.creator);
  events.end(report_of_reading(options.input, made.field, reading));
  const points::ParticleFieldStatistics& figures = made.figures;
  const points::Method method = options.particles.method;
  StageReport report = report_on(StageName::particles_to_field, field_label(made.field));
  report.did = "particles to field";
  report.add_timed(
      {{Key::format, file.format},
       {Key::length_unit, file.length_unit},
       {Key::frame, frame_figures(file.time)},
       {Key::method, word_of(method)},
       {Key::radius, figures.radius},
       {Key::radius_suggested, figures.radius_suggested},
       {Key::smoothing_length, points::has_kernels(method) ? Value(options.particles.smoothing_length) : Value()},
       {Key::spacing, figures.spacing},
       {Key::support, figures.support},
       {Key::particles, figures.particles},
       {Key::chosen, chosen ? Value(chosen->chosen) : Value()},
       {Key::chosen_of, chosen ? Value(chosen->of) : Value()},
       {Key::outside_region, near_region ? Value(near_region->of - near_region->chosen) : Value()},
       {Key::not_finite, figures.particles_dropped},
       {Key::left_out_inside, figures.particles_deep_inside},
       {Key::too_small, figures.particles_too_small},
       {Key::radius_attribute, figures.radius_attribute.empty() ? Value() : Value(figures.radius_attribute)},
       {Key::bricks_stored, figures.bricks_stored},
       {Key::bricks_inside, figures.inside_tiles},
       {Key::simulation_box, box_figures(file.particles.box)}},
      watch.elapsed());
  events.end(report);
  if (figures.particles == 0 && near_region && near_region->of > 0) {
    source.set_empty_region(*near_region, *options.roi, true);
  }
  if (figures.particles_dropped > 0) {
    events.note({NoteId::particles_left_out,
                 fmt::format("{}: the conversion left out {}", printable(file.particles.label),
                             counted(figures.particles_dropped, "particle whose position is not finite",
                                     "particles whose positions are not finite"))});
  }
  const bool tells_periods = figures.particles > 0 && !options.particles.simulation_box.periodic;
  if (tells_periods && file.particles.box && file.particles.box->is_periodic()) {
    events.note(
        {NoteId::periodic_box,
         fmt::format("{}: the box is periodic along {}, so the surface continues from each face to the opposite "
                     "one",
                     printable(file.particles.label), points::periodic_text(*file.particles.box))});
  }
  for (const Note& text : made.field.notes) {
    events.note(prefixed(printable(file.particles.label) + ": ", text));
  }
  report = report_on(StageName::particles_to_field, field_label(made.field));
  if (chosen) report.work.push_back(choice_fact(*chosen, options.particles));
  if (near_region) report.work.push_back(region_fact(*near_region));
  for (WorkFact& fact : particle_facts(figures)) report.work.push_back(std::move(fact));
  events.end(report);
  source.field = std::move(made.field);
  tell_isos(std::nullopt, events, source);
  const double smoothing_length = options.particles.smoothing_length;
  const bool counts_neighbors = use.counts_neighbors && figures.particles > 0;
  std::size_t counts = 0;
  if (counts_neighbors) {
    counts = TRY(points::add_neighbor_counts(file.particles, figures.radius, smoothing_length, context));
  }
  if (!counts_neighbors && options.attributes.empty()) return context.check();
  const auto kept = std::make_shared<const points::ParticleSet>(std::move(file.particles));
  if (counts_neighbors) source.neighbors = NeighborCounts{kept, counts, figures.radius, smoothing_length};
  if (!options.attributes.empty()) {
    source.attributes.emplace();
    source.attributes->from = ParticleAttributes{kept, std::move(found.choices), std::move(found.attributes),
                                                 figures.radius, smoothing_length};
    source.attributes->missing = std::move(found.missing);
  }
  return context.check();
}

}  // namespace

Result<field::ScalarField> read_field(const std::string& input, const volume_io::ReadOptions& options,
                                      const Context& context, Events& events) {
  const Stopwatch watch;
  auto field = volume_io::read_volume(input, options, context);
  if (!field) return field;
  const StageTime time = watch.elapsed();
  for (const Note& text : field->notes) events.note(text);
  events.end(report_of_reading(input, *field, time));
  TRY(context.check());
  TRY(volume_io::check_mapping_intact(*field));
  return field;
}

Value frame_figures(const particle_io::FrameTime& frame) {
  if (frame == particle_io::FrameTime()) return {};
  return Figures{{Key::step, frame.step}, {Key::time, frame.time}};
}

Value box_figures(const std::optional<points::SimulationBox>& box) {
  if (!box) return {};
  return Figures{{Key::origin, Value(box->origin)},
                 {Key::edges, Value::List{box->edges[0], box->edges[1], box->edges[2]}},
                 {Key::periodic, Value(box->periodic)}};
}

void Source::set_empty_region(const ParticleCount& count, const field::Box& roi, bool or_near) {
  why_no_particles = fmt::format("none of {} particles lies in the region {}{}", count.of, box_text(roi),
                                 or_near ? " or near it" : "");
  region_is_empty = true;
}

void Source::set_inside_side(double iso) {
  if (!kind_at_zero) return;
  const field::FieldKind side = iso > 0   ? field::FieldKind::density
                                : iso < 0 ? field::FieldKind::level_set
                                          : *kind_at_zero;
  field.kind = side;
  if (data) data->kind = side;
}

std::vector<NamedKind> Source::written_kinds() const {
  if (of_meshes) return mesh_kinds;
  return attributes ? convert::written_kinds(*attributes) : std::vector<NamedKind>();
}

std::string Source::length_text(const std::string& voxels, const std::string& units) const {
  return of_meshes ? fmt::format("{} of the mesh's units", units)
                   : fmt::format("{} voxels, in the mesh's units {}", voxels, units);
}

std::string Source::placement_record(mesh_io::MeshFormat format) const {
  return write_placement_record(from_world.value_or(placement), format, written_kinds());
}

extract::ExtractOptions Source::extract_options(const SurfaceOptions& surface, double iso) const {
  extract::ExtractOptions options;
  options.method = surface.method;
  options.nan = surface.nan;
  options.cap = surface.cap;
  options.voxel_faces = surface.voxel_faces;
  options.relaxations = surface.relaxations;
  options.iso = iso;
  options.region = region;
  options.output_from_index = output_from_index;
  return options;
}

SourceUse use_of(const ConversionJob& job) {
  SourceUse use;
  use.keep_data = job.error.has_value();
  use.isos = job.isos();
  use.background = job.surface.background;
  use.empty_is_fine = job.empty != EmptyPolicy::error;
  const auto* file = job.writes<FieldFileOptions>();
  if (file != nullptr) use.field_format = file->format;
  const auto* meshes = job.writes<MeshFileOptions>();
  use.is_in_meters = meshes != nullptr && mesh_io::is_gltf(meshes->format);
  use.mesh_format = job.meshes().format;
  // Each body has a file: the bodies of several surfaces would have the same names.
  const auto has_piece = [](const OutputFileJob& output) {
    return output.path.find(kPiecePlaceholder) != std::string::npos;
  };
  const bool into_files = job.edits.pieces.split && std::ranges::any_of(job.outputs, has_piece);
  use.meshes_apart = mesh_io::mesh_format_info(use.mesh_format).can_hold_several_meshes && !into_files;
  use.counts_neighbors = job.edits.smooth && job.edits.smooth->method == edit::SmoothMethod::weighted;
  // With NanPolicy::error the extractor finds spread NaN samples, and only those in its region.
  if (job.surface.nan == extract::NanPolicy::error && file == nullptr) use.nan = field::NanHandling::spread;
  // Methods with whole voxels cannot cut a voxel at a face of the region.
  if (job.source.roi_snap || extract::method_info(job.surface.method).traits.always_closed)
    use.region_ends = RegionEnds::samples;
  if (use.isos.size() != 1 || job.error || job.source.resamples()) return use;
  const IsoChoice& only = use.isos.front();
  if (only.is_number()) use.only_iso = only.id.iso();
  if (only.kind == IsoChoice::Kind::suggested) use.only_iso = points::method_info(job.source.particles.method).iso;
  return use;
}

Result<Source> open_source(const SourceOptions& options, const SourceUse& use, const Context& context, Events& events) {
  if (options.mesh) return open_mesh_source(options, use, context, events);
  const auto of_particles = TRY(is_particles(options, context));
  Source source;
  source.of_particles = of_particles;
  if (use.counts_neighbors && !(of_particles && points::has_kernels(options.particles.method))) {
    return fail(
        ErrorCode::usage,
        fmt::format("{}: weighted smoothing needs particles and a method with kernels or averaged positions, found {}",
                    printable(files::input_label(options.input)),
                    of_particles ? points::method_info(options.particles.method).title : "a volume"),
        {Remedy::set, Setting::smoothing, "N:taubin or N:sinc, which work for all surfaces"});
  }
  TRY(of_particles ? read_particle_field(options, use, context, events, source)
                   : read_volume_field(options, use, context, events, source));
  source.label = field_label(source.field);
  if (source.attributes) tell_missing(source.attributes->missing, source.label, events);
  const auto* sparse = std::get_if<field::SparseSamples>(&source.field.samples);
  source.empty = sparse != nullptr && sparse->blocks.empty() && sparse->tiles.empty() && sparse->active_voxels == 0;
  TRY(filter_field(options.filters, source.label, context, events, source.field));
  if (use.keep_data && !options.blurs.empty()) source.data = source.field;
  TRY(blur_field(options.blurs, source.label, context, events, source.field));
  if (options.resamples() && !source.field.is_sampled) {
    TRY(change_resolution(options, use, context, events, source));
  }
  if (options.away_from_zero) source.kind_at_zero = source.field.kind;
  auto placed = TRY(place_field(source.field, options.placement, options.roi, use.region_ends));
  events.end(report_of_placing(placed, source.field));
  for (const Note& text : placed.notes) events.note(text);
  if (use.is_in_meters) tell_other_unit(options.placement, source.field, source.label, events);
  source.placement = placed.placement;
  source.output_from_index = placed.output_from_index;
  source.region = placed.region;
  if (source.period) source.region = TRY(common_region(*source.period, placed.region, source.label));
  std::vector<ClipPlane> planes = options.clip;
  planes.insert(planes.end(), placed.cuts.begin(), placed.cuts.end());
  source.clip = half_spaces_of(source.field, source.output_from_index, options.placement.space, planes);
  if (source.attributes) {
    const field::Affine& world = source.field.index_to_world;
    const field::Affine output_from_world = options.placement.space == Space::index
                                                ? source.output_from_index.after(world.inverse())
                                                : source.placement.output_from_world();
    TRY(set_attribute_maps(*source.attributes, world.after(source.output_from_index.inverse()), output_from_world));
    for (const Note& text : source.attributes->kind_notes) {
      events.note(prefixed(source.label + ": ", text));
    }
  }
  return source;
}

}  // namespace isoextract::convert
