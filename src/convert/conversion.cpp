#include "convert/conversion.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iterator>
#include <new>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/machine.hpp"
#include "base/pages.hpp"
#include "base/parallel.hpp"
#include "base/stopwatch.hpp"
#include "convert/detail/conversion_backends.hpp"
#include "convert/detail/error_memory.hpp"
#include "convert/detail/field_file.hpp"
#include "convert/detail/label_choice.hpp"
#include "convert/detail/label_looks.hpp"
#include "convert/detail/no_surface.hpp"
#include "convert/detail/output_meshes.hpp"
#include "convert/detail/particle_file.hpp"
#include "convert/detail/partwise_output.hpp"
#include "convert/detail/recorder.hpp"
#include "convert/detail/several_grids.hpp"
#include "convert/detail/skipped_surfaces.hpp"
#include "convert/detail/surface_maker.hpp"
#include "convert/mask_layers.hpp"
#include "convert/mesh_packing.hpp"
#include "convert/mesh_pieces.hpp"
#include "convert/output_checks.hpp"
#include "convert/picture_file.hpp"
#include "convert/placement_record.hpp"
#include "convert/stages/mesh_relax.hpp"
#include "convert/stages/mesh_touching.hpp"
#include "extract/voxels.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::convert {
namespace {

class Conversion {
 public:
  Conversion(const ConversionJob& job, const Context& context, Outcome& outcome, Events& listener,
             const ConversionOptions& extras, BackendCache* kept, MeshCollector* collector)
      : job_(job),
        meshes_(job.meshes()),
        picture_(job.writes<PictureFileOptions>()),
        context_(context),
        outcome_(outcome),
        events_(outcome, listener),
        extras_(extras),
        backends_(job, outcome, events_, kept),
        collector_(collector) {}

  Result<void> run() {
    if (Ranks* ranks = this->ranks(); ranks != nullptr && !writes_shared_parts(job_)) {
      ranks->work_alone("an option or the output needs the whole mesh in one process");
      if (!ranks->is_first()) return leave_to_first_rank();
    }
    // Before the input is read, so that missing tools are reported at once.
    if (job_.writes<FieldFileOptions>() != nullptr) {
      TRY(check_field_tools(job_, job_.outputs.empty() ? source_.label : job_.outputs.front().path));
    }
    if (job_.extracts()) TRY(backends_.open());
    if (collector_ == nullptr || collector_->checks_files) {
      if (extras_.read == nullptr) add_read_files(own_read_, job_, context_);
      for (const OutputFileJob& output : job_.outputs) {
        TRY(check_mesh_files(output, meshes_.format, read()));
      }
    }
    TRY(check_grids(job_.source, context_));
    if (!job_.source.masks.empty()) {
      masks_ = TRY(MaskLayers::read(job_.source.masks, job_.source.read, {job_.isos(), job_.surface.least_voxels},
                                    context_, events_));
    }
    for (const OutputFileJob& output : job_.outputs) {
      TRY(write(output));
      ++output_;
    }
    if (const auto text = note_of_relaxing(outcome_.reports); text && !extras_.volume_hint.empty()) {
      events_.note({NoteId::volume_changed, *text + extras_.volume_hint});
    }
    outcome_.front = front_azimuth(source_.field, source_.placement);
    if (const auto text = note_of_touching(outcome_.reports)) events_.note({NoteId::moved_apart, *text});
    if (wants_source()) collector_->source = std::move(source_);
    return {};
  }

 private:
  Result<void> write_samples(const OutputFileJob& output) {
    TRY(context_.check());
    if (source_.empty && job_.empty != EmptyPolicy::write)
      return leave_out_empty(source_, job_, output, context_, events_);
    outcome_.files.push_back(TRY(write_field(source_, job_, output, context_, events_)));
    return {};
  }

  // Reads a grid of the input, or one of its volumes, unless it is loaded. Only one grid is in memory at a time.
  Result<void> open_grid(const std::optional<std::string>& grid, std::optional<std::int64_t> volume) {
    if (opened_ == OpenedVolume(grid, volume)) return {};
    opened_.reset();
    labels_.reset();
    lost_.clear();
    source_ = Source();  // releases its memory before the next grid is read
    SourceUse use = use_of(job_);
    use.isos = isos_of(job_, grid);
    use.masks = masks_ ? &*masks_ : nullptr;
    if (wants_source()) use.only_iso.reset();
    use.outside_region = wants_source();
    use.by_layers = collector_ == nullptr && takes_layers(job_, backends_.extractor());
    use.is_in_meters &= collector_ == nullptr || collector_->becomes_file;
    if (!job_.source.more_grids.empty()) events_.begin_grid(grid);
    SourceOptions options = with_grid(job_.source, grid);
    options.read.volume = volume;
    layer_ = volume == job_.source.read.volume ? std::nullopt : volume;
    source_ = TRY(open_source(options, use, context_, events_));
    opened_.emplace(grid, volume);
    const field::ScalarField& field = source_.field;
    if (!job_.source.more_grids.empty()) events_.name_grid(field.grid.empty() ? field.name : field.grid);
    const bool has_notes = extras_.field_notes && !job_.source.mesh;
    for (const Note& note : has_notes ? extras_.field_notes(field) : Notes()) events_.note(note);
    events_.end_reading();
    TRY(find_labels());
    std::vector<SurfaceId> ids;
    for (const ResolvedIso& iso : labels_ ? expand_labels(source_.isos, chosen_.labels) : source_.isos)
      ids.push_back(iso.id);
    all_ = SurfaceList(std::move(ids));
    return check_error_memory(job_, source_, context_);
  }

  // Writes one output: extracts, writes and frees one surface after another, if the format allows it.
  Result<void> write(const OutputFileJob& output) {
    if (job_.writes<ParticleFileOptions>() != nullptr) {
      const auto written = TRY(write_particle_file(job_, output, context_, events_));
      if (written) outcome_.files.push_back(*written);
      return {};
    }
    std::optional<OutputMeshes> file;
    std::vector<SkippedSurfaces> skipped;
    bool in_pieces = false;
    label_counts_ = {};
    for (const std::optional<std::string>& grid : grids_of(job_.source, output)) {
      const auto volumes =
          TRY(masks_ ? masks_->layers() : volumes_of(with_grid(job_.source, grid), isos_of(job_, grid), context_));
      is_layered_ = volumes.size() > 1;
      for (const std::optional<std::int64_t> volume : volumes) {
        TRY(open_grid(grid, volume));
        label_counts_.add(chosen_.counts);
        if (job_.writes<FieldFileOptions>() != nullptr) return write_samples(output);
        if (!file) file.emplace(open(output));
        const std::size_t before = file->written.surfaces.size();
        const std::span<const ResolvedIso> all(source_.isos);
        const auto asked = job_.source.mesh ? all : all.subspan(first_iso_of(job_, output_, grid), output.isos.size());
        const auto isos =
            chosen_.large_enough(surfaces_of(source_.field, asked, labels_ ? &chosen_.labels : nullptr, layer_));
        for (const Note& n : repeated_notes(source_.label, asked, files::output_label(output.path))) events_.note(n);
        auto added = add_surfaces(isos, *file, in_pieces);
        if (!added) label_work_.end(events_);
        TRY(std::move(added));
        skipped.push_back(skipped_of(isos, std::span<const SurfaceId>(file->ids()).subspan(before)));
      }
      label_work_.end(events_);
    }
    if (!file->written.surfaces.empty()) return finish(*file, skipped);
    // A surface split into bodies has one file for each body, so `output` itself names no file.
    return in_pieces ? Result<void>() : leave_out(output, skipped);
  }

  // Makes the surfaces and adds them to the file, each as soon as all earlier surfaces are added.
  Result<void> add_surfaces(std::span<const ResolvedIso> isos, OutputMeshes& file, bool& in_pieces) {
    if (labels_ && !isos.empty()) {
      TRY(check_sharing(false));
      return maker().make_labels(isos, [&](MadeSurface made, const ResolvedIso& iso) {
        return add_made(std::move(made), iso, file, in_pieces);
      });
    }
    for (const ResolvedIso& iso : isos) {
      TRY(context_.check());
      source_.set_inside_side(iso.id.iso_or_zero());
      const StageContext stage{job_, source_, maker().facts(false), context_};
      const std::unique_ptr<PartwiseOutput> sink = sink_of(isos, file, stage);
      TRY(check_sharing(sink != nullptr && sink->ranks() != nullptr));
      MadeSurface made = maker(sink.get()).make(iso);
      if (!made.surface && backends_.fall_back_to_cpu(made.surface.error())) made = maker(sink.get()).make(iso);
      if (!made.surface && sink == nullptr && !source_.of_meshes) add_partwise_hint(made.surface.error());
      TRY(add_made(std::move(made), iso, file, in_pieces));
    }
    return {};
  }

  // Returns a sink that writes the only surface of a file during extraction; null if a stage needs the whole mesh.
  std::unique_ptr<PartwiseOutput> sink_of(std::span<const ResolvedIso> isos, OutputMeshes& file,
                                          const StageContext& stage) const {
    const bool is_only = file.job.isos.size() == 1 && isos.size() == 1 && job_.source.more_grids.empty() && !labels_;
    if (!is_only || collector_ != nullptr) return nullptr;
    return partwise_output(stage, isos.front().id, file.writer, ranks());
  }

  // Returns the ranks that share the conversion; null if this process does all of it.
  [[nodiscard]] Ranks* ranks() const {
    return extras_.ranks != nullptr && extras_.ranks->is_shared() ? extras_.ranks : nullptr;
  }

  // Leaves the conversion to rank 0 if the ranks cannot share it.
  Result<void> check_sharing(bool has_sink) const {
    Ranks* const ranks = this->ranks();
    if (ranks == nullptr) return {};
    const extract::Extractor* extractor = backends_.extractor();
    std::string reason =
        reason_against_sharing(job_, source_, has_sink, extractor != nullptr ? extractor->name() : "cpu");
    if (reason.empty()) return {};
    ranks->work_alone(std::move(reason));
    return ranks->is_first() ? Result<void>() : leave_to_first_rank();
  }

  // Adds a surface to the file, whole or split into bodies, or writes it to the file of its label.
  Result<void> add_made(MadeSurface made, const ResolvedIso& iso, OutputMeshes& file, bool& in_pieces) {
    if (made.exception) std::rethrow_exception(made.exception);
    made.events.send(events_);
    open_ = made.open;
    outcome_.bytes_uploaded += made.bytes_uploaded;
    std::ranges::move(made.lost, std::back_inserter(lost_));
    if (!made.surface) return tl::unexpected(with_kept_files(std::move(made.surface.error()), outcome_.files));
    auto surface = std::move(*made.surface);
    if (!surface) return {};
    if (!labels_ || collector_ != nullptr || !file.label_names.in_use()) {
      return add_surface(std::move(*surface), iso, file, in_pieces);
    }
    const std::int64_t label = iso.id.label();
    const OutputFileJob own_job{file.label_names.next(label, looks_.given_name(label)), {iso.asked}};
    TRY(check_mesh_files(own_job, meshes_.format, read()));
    OutputMeshes own = open(own_job);
    TRY(add_surface(std::move(*surface), iso, own, in_pieces));
    if (own.written.surfaces.empty()) return {};
    auto files = TRY(close(own));
    file.take(own);
    locate(std::move(files));
    return {};
  }

  Result<void> add_surface(Surface surface, const ResolvedIso& iso, OutputMeshes& file, bool& in_pieces) {
    mesh::Mesh& mesh = surface.mesh;
    if (!events_.grid().empty()) mesh.name = events_.grid();
    if (labels_) {
      mesh.name = looks_.name(mesh.name, iso.id.label());
    } else if (file.job.isos.size() > 1) {
      mesh.name = fmt::format("{} {}", mesh.name, surface_text(iso.asked));
    }
    if (!job_.edits.pieces.split) return add(std::move(surface), file);
    in_pieces = true;
    return add_pieces(std::move(surface), iso, file);
  }

  [[nodiscard]] OutputMeshes open(const OutputFileJob& output) const {
    return {
        output, {output.path, write_options(job_, source_, extras_.hash_files), context_}, LabelFileNames(output.path)};
  }

  // Adds the bodies as meshes of one file, or writes each to its own file.
  Result<void> add_pieces(Surface surface, const ResolvedIso& iso, OutputMeshes& file) {
    const std::string& pattern = file.job.path;
    const bool into_files = collector_ == nullptr && pattern.find(kPiecePlaceholder) != std::string::npos;
    const StageContext stage{job_, source_, maker().facts(open_), context_};
    const std::string name = surface.mesh.name;
    auto pieces = split_mesh(std::move(surface.mesh), into_files, context_);
    if (!pieces) return tl::unexpected(about_surface(std::move(pieces.error()), name, stage.subject(surface)));
    for (std::size_t i = 0; into_files && i < pieces->size(); ++i) {
      TRY(check_mesh_files({piece_path(pattern, i + 1), {}}, meshes_.format, read()));
    }
    for (std::size_t i = 0; i < pieces->size(); ++i) {
      Surface piece{.asked = surface.asked,
                    .id = surface.id,
                    .mesh = std::move((*pieces)[i]),
                    .open_boundary = surface.open_boundary,
                    .counts_open_edges = surface.counts_open_edges};
      TRY(run_stage(stage_info(StageName::normals), stage, events_, piece));
      if (!into_files) {
        TRY(add(std::move(piece), file));
        continue;
      }
      const OutputFileJob own_job{piece_path(pattern, i + 1), {iso.asked}};
      OutputMeshes own = open(own_job);
      TRY(add(std::move(piece), own));
      TRY(finish(own, {}));
    }
    if (!into_files) return {};
    if (pieces->empty()) return leave_out(file.job, {skipped_of({&iso, 1}, {})});
    const auto removed = TRY(remove_old_pieces(file.job, pieces->size() + 1, meshes_.format, read(), context_));
    if (!removed.empty()) {
      events_.note({NoteId::old_pieces, fmt::format("{}: {} bodies; the run removed files of an earlier run: {}",
                                                    source_.label, pieces->size(), first_and_last(removed))});
    }
    return {};
  }

  // Finds all labels that the job asks for in one pass over the samples.
  Result<void> find_labels() {
    const std::optional<extract::LabelChoice> choice = chosen_labels(source_.isos, job_.surface.background);
    chosen_ = {};
    if (!choice) return {};
    return_large_blocks();
    looks_ = TRY(LabelAppearance::open(job_, source_.field, opened_->second, context_));
    if (masks_) looks_.add_names_without_voxels(masks_->names_without_voxels());
    TRY(backends_.require(job_.surface.method));
    const Stopwatch watch;
    labels_ = TRY(extract::LabelVoxels::find(source_.field, extract_options_of(job_, source_, 0), *choice, context_));
    label_work_.finding += watch.elapsed();
    TRY(volume_io::check_mapping_intact(source_.field));
    release_free_memory();  // finding and relaxing labels takes more memory than keeping them
    for (const Note& note : labels_->notes()) events_.note(note);
    const auto missing =
        looks_.note_of_missing(source_.label, labels_->labels(), job_.surface.background, job_.source.roi.has_value());
    if (missing && source_.isos.front().asked.kind == IsoChoice::Kind::all_labels) events_.note(*missing);
    chosen_ = TRY(choose_labels(source_.isos, *labels_, looks_, job_.surface.least_voxels, job_.empty, source_.label));
    TRY(check_piece_names(job_, chosen_, looks_, source_.label));
    for (const Note& note : chosen_.notes) events_.note(note);
    // A layer may have none of the chosen labels if there are several layers.
    if (is_layered_ || !chosen_.labels.empty() || job_.empty != EmptyPolicy::error) return {};
    return tl::unexpected(no_label(source_, job_.surface.background, chosen_.counts));
  }

  [[nodiscard]] SurfaceMaker maker(PartwiseOutput* sink = nullptr) {
    const extract::LabelVoxels* const labels = labels_ ? &*labels_ : nullptr;
    return {job_, source_,        backends_.extractor(), backends_.other(), labels, looks_,
            all_, source_.meshes, extras_.mesh_facts,    context_,          sink,   &label_work_.extracting};
  }

  Result<void> add(Surface surface, OutputMeshes& file) {
    measuring_time_ += surface.measuring_time;
    context_.progress().begin("writing", 0);
    const Stopwatch watch;
    file.note(surface, source_.label, events_.grid());
    outcome_.written.push_back({surface.id, output_, surface.triangles(), 0, 0, events_.grid()});
    Result<void> added;
    if (collector_ != nullptr || picture_ != nullptr) {
      file.held.push_back(std::move(surface.mesh));
    } else if (!surface.taken) {
      added = file.writer.add(std::move(surface.mesh));
    }
    file.time += watch.elapsed();
    return added;
  }

  Result<mesh_io::MeshWriteResult> complete(OutputMeshes& file) {
    if (collector_ == nullptr && picture_ != nullptr) {
      auto picture = TRY(write_picture(file.held, *picture_, source_.placement.placement,
                                       front_azimuth(source_.field, source_.placement), file.job, context_));
      if (picture.misses_surfaces) outcome_.empty_picture = true;
      return std::move(picture.written);
    }
    if (collector_ == nullptr) return file.writer.finish();
    file.collect(write_options(job_, source_, extras_.hash_files), *collector_);
    return mesh_io::MeshWriteResult();
  }

  // Completes a file and returns its files.
  Result<std::vector<mesh_io::WrittenFile>> close(OutputMeshes& file) {
    context_.progress().begin("writing", 0);
    const Stopwatch watch;
    auto result = TRY(complete(file));
    const mesh_io::MeshPacking packing = mesh_packing(meshes_.packing, source_);
    for (const StageReport& packed : file.packed(result.packed, packing)) events_.end(packed);
    file.time += watch.elapsed();
    if (extras_.mesh_facts) {
      StageReport report(StageName::mesh_facts, files::output_label(file.job.path));
      report.time = std::exchange(measuring_time_, {});
      report.entries = std::move(file.facts);
      events_.end(report);
    }
    for (const Note& text : result.notes) events_.note(text);
    for (const mesh_io::WrittenFile& written : result.files) file.written.bytes += written.bytes;
    file.written.files += result.files.size();
    return std::move(result.files);
  }

  // Completes the file, unless each label has a file of its own.
  Result<void> finish(OutputMeshes& file, const std::vector<SkippedSurfaces>& skipped) {
    std::vector<mesh_io::WrittenFile> files;
    const std::string path = file.written.files == 1 ? outcome_.files.back().path : file.job.path;  // of the only label
    if (file.written.files == 0) files = TRY(close(file));
    tell_skipped(file.job, skipped, true, "");
    file.written.placement = job_.source.mesh ? file_text(source_.placement) : world_text(source_.placement);
    tell_written(std::move(file.written), path, file.time, std::move(files));
    return {};
  }

  // Records the files of the surfaces that were added since the last call.
  void locate(std::vector<mesh_io::WrittenFile> files) {
    for (; located_ < outcome_.written.size(); ++located_) {
      outcome_.written[located_].first_file = outcome_.files.size();
      outcome_.written[located_].files = files.size();
    }
    std::ranges::move(files, std::back_inserter(outcome_.files));
  }

  // Reports no time if `time` is empty: the output then has no surfaces.
  void tell_written(WrittenOutput output, const std::string& path, const std::optional<StageTime>& time,
                    std::vector<mesh_io::WrittenFile> files) {
    locate(std::move(files));
    StageReport report(StageName::write, files::output_label(path));
    report.time = time;
    if (time) report.did = "written";
    report.output = std::move(output);
    events_.end(report);
  }

  Result<void> leave_out(const OutputFileJob& output, const std::vector<SkippedSurfaces>& skipped) {
    const bool in_pieces = job_.edits.pieces.split && output.path.find(kPiecePlaceholder) != std::string::npos;
    const bool has_label = !labels_ || !std::ranges::all_of(skipped, is_nothing);
    const Error none = no_label(source_, job_.surface.background, label_counts_);
    if (!has_label && job_.empty == EmptyPolicy::error) return tl::unexpected(none);
    const auto removed = TRY(collector_ != nullptr ? Result<std::vector<std::string>>()
                             : in_pieces           ? remove_old_pieces(output, 1, meshes_.format, read(), context_)
                                                   : remove_old_meshes(output, meshes_.format, context_));
    const std::string besides = removed.empty() ? "" : fmt::format(" and removed the old {}", first_and_last(removed));
    tell_skipped(output, skipped, false, besides);
    if (!has_label) events_.note(note_of_no_label(none, output, besides));
    tell_written({}, output.path, std::nullopt, {});
    return {};
  }

  [[nodiscard]] bool wants_source() const { return collector_ != nullptr && collector_->wants_source; }
  [[nodiscard]] const files::InputFileSet& read() const { return extras_.read != nullptr ? *extras_.read : own_read_; }

  [[nodiscard]] SkippedSurfaces skipped_of(std::span<const ResolvedIso> asked, std::span<const SurfaceId> made) const {
    return skipped_surfaces(source_.label, asked, made, lost_);
  }

  void tell_skipped(const OutputFileJob& output, const std::vector<SkippedSurfaces>& skipped, bool is_written,
                    const std::string& besides) {
    const std::string path = files::output_label(output.path);
    const std::string what = is_written || collector_ != nullptr ? path + " contains only the other surfaces"
                                                                 : "the conversion did not write " + path;
    for (const SkippedSurfaces& grid : skipped) {
      if (!grid.reasons.empty()) events_.note({NoteId::no_surface, note_of(grid, what + besides)});
    }
  }

  const ConversionJob& job_;
  MeshFileOptions meshes_;
  const PictureFileOptions* picture_;  // null if no picture is drawn
  const Context& context_;
  Outcome& outcome_;
  Recorder events_;
  ConversionOptions extras_;
  ConversionBackends backends_;
  MeshCollector* collector_;      // null if files are written
  files::InputFileSet own_read_;  // used if files are written and the caller gave no list of read files
  Source source_;
  // The grid and the volume that source_ was read from; each empty if none was chosen.
  using OpenedVolume = std::pair<std::optional<std::string>, std::optional<std::int64_t>>;
  std::optional<OpenedVolume> opened_;
  std::optional<std::int64_t> layer_;           // the volume, if the job takes each layer of a label map
  bool is_layered_ = false;                     // the grid has several layers
  std::optional<MaskLayers> masks_;             // if the job has masks
  std::optional<extract::LabelVoxels> labels_;  // if the job asks for labels
  ChosenLabels chosen_;                         // of labels_
  LabelCounts label_counts_;                    // of all layers of the current output
  LabelWork label_work_;                        // of all layers of the current grid
  SurfaceList all_;                             // surfaces of the current grid
  LabelAppearance looks_;                       // of the same labels
  std::size_t output_ = 0;                      // index of the current output
  std::size_t located_ = 0;                     // entries of Outcome::written whose files are known
  StageTime measuring_time_;                    // time spent measuring meshes of the current file, for reports
  bool open_ = false;                           // the current surface may have boundary edges
  std::vector<LostSurface> lost_;               // of the current grid
};

}  // namespace

Outcome run(const ConversionJob& job, const Context& context, Events& events, const ConversionOptions& extras,
            BackendCache* kept, MeshCollector* collector) {
  const Stopwatch watch;
  Outcome outcome;
  outcome.threads = usable_threads();
  Result<void> done;
  try {
    done = Conversion(job, context, outcome, events, extras, kept, collector).run();
  } catch (const std::bad_alloc&) {
    done = tl::unexpected(allocation_error(fmt::format("{}: not enough memory", files::input_label(job.source.input)),
                                           {Remedy::use, Setting::parts}));
  } catch (const std::exception& error) {
    done = fail(ErrorCode::input,
                fmt::format("{}: unexpected error: {}", files::input_label(job.source.input), error.what()));
  }
  if (!done) outcome.error = std::move(done.error());
  outcome.total = watch.elapsed();
  outcome.bytes_read = context.counters().bytes_read;
  outcome.peak_memory = peak_memory();
  outcome.reserved_memory = context.memory().peak();
  return outcome;
}

}  // namespace isoextract::convert
