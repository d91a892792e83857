#include "convert/conversion.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "base/machine.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "convert/detail/recorder.hpp"
#include "convert/field_file.hpp"
#include "convert/mesh_packing.hpp"
#include "convert/output_checks.hpp"
#include "convert/picture_file.hpp"
#include "convert/source.hpp"
#include "extract/voxels.hpp"
#include "field/statistics.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"
#include "meshes/mesh_reader.hpp"

namespace isoextract::convert {
namespace {

int thread_count() {
  const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::min(static_cast<int>(std::min<std::size_t>(allowed, 1 << 16)), tbb::this_task_arena::max_concurrency());
}

class Conversion {
 public:
  Conversion(const ConversionJob& job, const Context& context, Outcome& outcome, Events& listener,
             const OutcomeExtras& extras, KeptBackends* kept, MeshSink* sink)
      : job_(job),
        context_(context),
        outcome_(outcome),
        events_(outcome, listener),
        extras_(extras),
        kept_backends_(kept),
        sink_(sink) {}

  Result<void> run() {
    if (auto opened = job_.field_file ? open_tools() : open_backends(); !opened) return opened;
    if (auto checked = check_mesh_files(job_); !checked) return checked;
    SourceUse use = use_of(job_);
    if (sink_ != nullptr && sink_->wants_source()) use.only_iso.reset();
    auto source = open_source(job_.source, use, context_, events_);
    if (!source) return tl::unexpected(std::move(source.error()));
    source_ = std::move(*source);
    if (auto found = find_labels(); !found) return found;
    std::span<const ResolvedIso> isos = source_.isos;
    for (const OutputFileJob& output : job_.outputs) {
      if (auto done = job_.field_file ? write_samples(output) : write(output, isos.first(output.isos.size())); !done)
        return done;
      isos = isos.subspan(output.isos.size());
    }
    if (sink_ != nullptr && sink_->wants_source()) sink_->take_source(std::move(source_));
    return {};
  }

 private:
  struct Surface {
    double iso = 0;
    mesh::Mesh mesh;
    std::optional<MeshError> error;
  };

  // A file while its surfaces are made.
  struct OutputFile {
    WrittenOutput written;
    meshes::MeshWriter writer;
    std::vector<mesh::Mesh> held;     // for the sink or the picture, which have no writer
    std::vector<MeshRecord> records;  // where they were asked for
    StageTime recording;
  };

  // Before the input is read: a missing GPU is told at once.
  Result<void> open_backends() {
    outcome_.backend = word_of(job_.backend.backend);
    const Stopwatch watch;
    gpu::GpuOptions gpu{job_.backend.gpu};
    gpu.keep_samples = job_.isos().size() > 1;
    const auto open = [&](Backend backend) {
      return kept_backends_ != nullptr ? kept_backends_->open(backend, gpu) : open_backend(backend, gpu);
    };
    auto opened = open(job_.backend.backend);
    if (!opened) return tl::unexpected(std::move(opened.error()));
    extract_with(std::move(*opened), watch.elapsed());
    if (!job_.verify) return {};
    opened = open(extractor_->name() == word_of(Backend::gpu) ? Backend::cpu : Backend::gpu);
    if (!opened) return tl::unexpected(std::move(opened.error()));
    other_extractor_ = std::move(opened->extractor);
    return {};
  }

  // Before the input is read, too.
  Result<void> open_tools() {
    return volumes::check_grid_tools(job_.outputs.empty() ? source_.label : job_.outputs.front().path);
  }

  Result<void> write_samples(const OutputFileJob& output) {
    if (auto go_on = context_.check(); !go_on) return go_on;
    if (!source_.empty || job_.empty == EmptyPolicy::write)
      return write_field(source_, job_, output, context_, events_);
    if (job_.empty == EmptyPolicy::error) return tl::unexpected(empty_source());
    const auto removed = remove_old_files(output);
    if (!removed) return tl::unexpected(removed.error());
    events_.note(fmt::format("{}: {}; {} was not written{}", source_.label, why_empty(),
                             files::shown_output_name(output.path),
                             removed->empty() ? "" : "; the old one was removed"));
    return {};
  }

  // From now on.
  void extract_with(OpenedBackend backend, const StageTime& time) {
    extractor_ = std::move(backend.extractor);
    events_.opened(*extractor_, time);
    if (!backend.reason.empty()) events_.note("backend: " + backend.reason);
  }

  // One surface is made, written and let go after the other, where the format allows.
  Result<void> write(const OutputFileJob& output, std::span<const ResolvedIso> asked) {
    OutputFile file{{output, {}, 0, 0, {}, {}}, meshes::MeshWriter(output.path, write_options(), context_), {}, {}, {}};
    const std::vector<ResolvedIso> isos = labels_ ? each_label(asked, labels_->labels()) : each_once(asked);
    if (isos.size() < asked.size()) tell_repeated(output, asked);
    for (const ResolvedIso& iso : isos) {
      if (auto go_on = context_.check(); !go_on) return go_on;
      auto surface = make_surface(iso);
      if (!surface) return tl::unexpected(std::move(surface.error()));
      if (!*surface) continue;
      if (output.isos.size() > 1 || labels_) {
        (*surface)->mesh.name = fmt::format("{} {}", (*surface)->mesh.name, surface_text(iso.asked));
      }
      if (auto added = add(std::move(**surface), file); !added) return added;
    }
    return file.written.isos.empty() ? leave_out(output, isos) : finish(file, isos);
  }

  [[nodiscard]] meshes::MeshWriteOptions write_options() const {
    return {job_.format, job_.normals == Normals::flat, job_.ascii, mesh_packing(job_.packing, source_)};
  }

  // All labels that are asked for, in one look at the samples.
  Result<void> find_labels() {
    extract::LabelChoice choice;
    for (const ResolvedIso& iso : source_.isos) {
      if (!iso.asked.is_label()) return {};
      choice.all = choice.all || iso.asked.kind == IsoChoice::Kind::all_labels;
      choice.values.push_back(static_cast<std::int64_t>(iso.value));
    }
    if (source_.isos.empty()) return {};
    if (!extractor_->has(job_.surface.method)) {
      const Error error{ErrorKind::unavailable,
                        fmt::format("the {} backend does not have {}", extractor_->name(), method().title),
                        Remedy::use_cpu};
      if (!gave_way(error)) return tl::unexpected(error);
    }
    auto found = extract::LabelVoxels::find(source_.field, extract_options(0), choice, context_);
    if (!found) return tl::unexpected(std::move(found.error()));
    if (auto whole = volumes::check_not_lost(source_.field); !whole) return whole;
    labels_ = std::move(*found);
    if (!labels_->labels().empty() || job_.empty != EmptyPolicy::error) return {};
    return tl::unexpected(source_.empty ? empty_source()
                                        : Error{ErrorKind::input, source_.label + ": no sample has a label but 0",
                                                Remedy::allow_empty, Reason::no_surface});
  }

  // Nothing where it is empty and empty surfaces are skipped.
  Result<std::optional<Surface>> make_surface(const ResolvedIso& asked) {
    const double iso = asked.value;
    auto mesh = extract(asked);
    if (!mesh) return tl::unexpected(std::move(mesh.error()));
    if (mesh->triangles.empty() && job_.empty != EmptyPolicy::write) {
      if (job_.empty == EmptyPolicy::error) return tl::unexpected(no_surface(asked));
      return std::optional<Surface>();
    }
    Surface surface{iso, std::move(*mesh), {}};
    if (auto carried = carry_attributes(surface); !carried) return tl::unexpected(std::move(carried.error()));
    if (job_.simplify) {
      auto simplified = simplify_mesh(surface.mesh, iso, *job_.simplify, source_.output_from_index, context_);
      if (!simplified) return tl::unexpected(std::move(simplified.error()));
      events_.simplified(*simplified);
    }
    if (auto coloured = colour(surface); !coloured) return tl::unexpected(std::move(coloured.error()));
    if (const std::string reason = extract::why_no_error(method()); job_.error && !reason.empty()) {
      events_.note("the error of the mesh is not measured: " + reason);
    } else if (job_.error) {
      const Stopwatch watch;
      const field::ScalarField& data = source_.data ? *source_.data : source_.field;
      surface.error = measure_mesh_error(surface.mesh, data, extract_options(iso), *job_.error,
                                         source_.data ? &source_.field : nullptr, context_);
      if (auto whole = volumes::check_not_lost(data); !whole) return tl::unexpected(std::move(whole.error()));
      events_.measured(*surface.error, watch.elapsed());
    }
    return surface;
  }

  // While every vertex is where the field puts it.
  Result<void> carry_attributes(Surface& surface) {
    if (!source_.attributes) return {};
    const Stopwatch watch;
    auto records = add_attributes(*source_.attributes, surface.mesh, context_);
    if (!records) return tl::unexpected(std::move(records.error()));
    for (AttributeRecord& record : *records) {
      record.iso = surface.iso;
      for (const std::string& text : notes_of(record, source_.label)) events_.note(text);
    }
    // Of particles all attributes have the same reach.
    if (!records->empty() && records->front().out_of_reach > 0) {
      events_.note(
          fmt::format("{} iso {}: {} of {} vertices have the attributes of the nearest particle, as none is "
                      "near enough to be interpolated",
                      source_.label, surface.iso, records->front().out_of_reach, surface.mesh.positions.size()));
    }
    events_.carried({surface.iso, surface.mesh.positions.size(), std::move(*records), watch.elapsed()});
    return {};
  }

  // When the vertices are those that are written. Attributes that are only for that go.
  Result<void> colour(Surface& surface) {
    std::vector<double> isos;
    for (const ResolvedIso& iso : labels_ ? each_label(source_.isos, labels_->labels()) : source_.isos)
      isos.push_back(iso.value);
    surface.mesh.material = material_of(job_, isos, surface.iso, source_.field.kind);
    if (!job_.colour || !job_.colour->attribute) return {};
    auto record = add_colours(*job_.colour, job_.format, surface.mesh, context_);
    if (!record) return tl::unexpected(std::move(record.error()));
    record->iso = surface.iso;
    if (record->not_numbers > 0) {
      events_.note(fmt::format("{} iso {}: {} of {} vertices are grey, as '{}' is no number there", source_.label,
                               surface.iso, record->not_numbers, surface.mesh.positions.size(),
                               printable(record->attribute)));
    }
    events_.coloured(*record);
    for (const AttributeChoice& choice : job_.source.attributes) {
      if (choice.written) continue;
      std::erase_if(surface.mesh.attributes, [&](const mesh::Attribute& a) {
        return a.role != mesh::AttributeRole::colour && a.name == choice.name;
      });
    }
    return {};
  }

  [[nodiscard]] const extract::MethodInfo& method() const { return extract::method_info(job_.surface.method); }

  [[nodiscard]] extract::ExtractOptions extract_options(double iso) const {
    extract::ExtractOptions options = source_.extract_options(job_.surface, iso);
    options.smooth_normals = job_.normals == Normals::smooth;
    options.shared_frame = write_options().packing.quantizes();
    options.edge_keys = job_.verify && method().traits.vertices_on_edges;
    return options;
  }

  Result<mesh::Mesh> extract(const ResolvedIso& asked_iso) {
    const double iso = asked_iso.value;
    const Stopwatch watch;
    const extract::ExtractOptions options = extract_options(iso);
    auto extraction =
        labels_ ? extract_label(asked_iso, options) : extractor_->extract(source_.field, options, context_);
    if (!extraction && gave_way(extraction.error())) extraction = extractor_->extract(source_.field, options, context_);
    if (!extraction) return tl::unexpected(std::move(extraction.error()));
    if (auto whole = volumes::check_not_lost(source_.field); !whole) return tl::unexpected(std::move(whole.error()));
    const AskedFor asked{.flat_normals = job_.normals == Normals::flat, .error = job_.error.has_value()};
    events_.extracted({iso, asked_iso.asked, extraction->mesh.triangles.size(), extraction->stats,
                       extraction_facts(extraction->stats, options, asked), watch.elapsed()});
    if (other_extractor_ != nullptr) {
      auto record = compare_backends(source_.field, options, method(), extraction->mesh, *extractor_, *other_extractor_,
                                     context_);
      if (!record) return tl::unexpected(std::move(record.error()));
      if (auto whole = volumes::check_not_lost(source_.field); !whole) return tl::unexpected(std::move(whole.error()));
      extraction->mesh.edges = {};  // they have done their work
      events_.verified(*record);
      if (auto same = check_verification(source_.label, *record); !same) return tl::unexpected(std::move(same.error()));
    }
    return std::move(extraction->mesh);
  }

  Result<extract::Extraction> extract_label(const ResolvedIso& asked, const extract::ExtractOptions& options) {
    auto extraction = labels_->extract(source_.field, static_cast<std::int64_t>(asked.value), options, context_);
    if (extraction) extraction->mesh.name = source_.field.name;
    return extraction;
  }

  // Where the choice was the program's, a GPU that cannot do the work is no reason to end: the processor takes over,
  // and that is told. With verification it is one: nothing would be left to verify.
  bool gave_way(const Error& error) {
    const bool may = job_.backend.backend == Backend::automatic && extractor_->name() == word_of(Backend::gpu) &&
                     other_extractor_ == nullptr;
    if (!may || error.kind != ErrorKind::unavailable) return false;
    extract_with({extract::make_cpu_extractor(), fmt::format("cpu, because {}", error.message)}, {});
    return true;
  }

  [[nodiscard]] const char* why_empty() const {
    return source_.of_particles ? "there are no particles" : "the grid is empty: it has no voxels";
  }

  [[nodiscard]] Error empty_source() const {
    return {ErrorKind::input, fmt::format("{}: {}", source_.label, why_empty()), Remedy::allow_empty,
            Reason::empty_grid};
  }

  Error no_surface(const ResolvedIso& asked) {
    const double iso = asked.value;
    if (source_.empty) return empty_source();
    if (labels_) {
      return {ErrorKind::input, fmt::format("{}: no sample has {}", source_.label, text_of(asked)), Remedy::allow_empty,
              Reason::no_surface};
    }
    const Stopwatch watch;
    const field::FieldStatistics statistics = field::measure_statistics(source_.field);
    outcome_.stages.push_back({"statistics", std::nullopt, watch.elapsed()});
    if (statistics.samples == 0) {
      // Active voxels of the background's value are not stored.
      const bool all_alike = statistics.nan == 0 && statistics.infinite == 0;
      return {ErrorKind::input,
              fmt::format("{}: there is no surface: {}", source_.label,
                          all_alike ? "every voxel has the background's value" : "no sample is a finite number"),
              Remedy::allow_empty, Reason::no_surface};
    }
    const bool region_hides_it = source_.region && statistics.min <= iso && iso <= statistics.max;
    const field::IsoSuggestion suggestion = field::suggest_iso(source_.field, statistics);
    const Hint other = suggestion.separates
                           ? Hint(Remedy::try_iso, fmt::format("{} ({})", suggestion.iso, suggestion.method))
                           : Hint(Remedy::no_surface_or_skip);
    return {ErrorKind::input,
            fmt::format("{}: no surface at iso {}{}{}; the values {}run from {:.6g} to {:.6g}", source_.label,
                        text_of(asked), source_.region ? " in the region" : "",
                        job_.source.resolution ? " on the grid of another resolution" : "",
                        source_.region ? "of the whole field " : "", statistics.min, statistics.max),
            region_hides_it ? Hint(Remedy::widen_region_or_skip) : other, Reason::no_surface};
  }

  Result<void> add(Surface surface, OutputFile& file) {
    if (extras_.mesh_facts) {
      if (auto recorded = record(surface, file); !recorded) return recorded;
    }
    context_.progress().begin("writing", 0);
    const Stopwatch watch;
    file.written.isos.push_back(surface.iso);
    file.written.triangles += surface.mesh.triangles.size();
    file.written.vertices += surface.mesh.positions.size();
    Result<void> added;
    if (sink_ != nullptr || job_.picture_file) {
      file.held.push_back(std::move(surface.mesh));
    } else {
      added = file.writer.add(std::move(surface.mesh));
    }
    file.written.time += watch.elapsed();
    return added;
  }

  Result<meshes::MeshWriteResult> complete(OutputFile& file) {
    if (sink_ == nullptr && job_.picture_file) return write_picture(file.held, job_, file.written.job, context_);
    if (sink_ == nullptr) return file.writer.finish();
    if (auto taken = sink_->take({file.written.job, file.written.isos, std::move(file.held), write_options().packing});
        !taken) {
      return tl::unexpected(std::move(taken.error()));
    }
    return meshes::MeshWriteResult();
  }

  Result<void> finish(OutputFile& file, std::span<const ResolvedIso> asked) {
    context_.progress().begin("writing", 0);
    const Stopwatch watch;
    auto result = complete(file);
    if (!result) return tl::unexpected(std::move(result.error()));
    file.written.files = std::move(result->files);
    tell_packed(file.written, result->packed);
    file.written.time += watch.elapsed();
    if (extras_.mesh_facts) events_.recorded(file.records, file.recording);
    for (const std::string& text : result->notes) events_.note(text);
    tell_skipped(file.written.job, asked, file.written.isos, "");
    events_.written(file.written);
    return {};
  }

  void tell_packed(const WrittenOutput& written, const std::vector<meshes::PackedFacts>& packed) {
    for (std::size_t m = 0; m < packed.size(); ++m) {
      if (packed[m].bytes_before == 0) continue;  // it has no triangles
      events_.packed(
          {written.isos[m], written.job.path, job_.packing, shortest_voxel_side(source_.output_from_index), packed[m]});
    }
  }

  Result<void> leave_out(const OutputFileJob& output, std::span<const ResolvedIso> asked) {
    const auto removed = sink_ == nullptr ? remove_old_files(output) : Result<std::vector<std::string>>();
    if (!removed) return tl::unexpected(removed.error());
    tell_skipped(output, asked, {},
                 removed->empty() ? "" : fmt::format("; the old {} was removed", fmt::join(*removed, " and ")));
    events_.written({output, {}, 0, 0, {}, {}});
    return {};
  }

  // An old file of that name would pass for what this run made, among the frames of a sequence for example.
  Result<std::vector<std::string>> remove_old_files(const OutputFileJob& output) {
    std::vector<std::string> removed;
    std::vector<std::string> data;
    if (job_.format == meshes::MeshFormat::gltf) data = meshes::data_file_names(output.path, context_);
    for (const std::filesystem::path& file : mesh_files(output, job_.format)) {
      const bool is_data = file != std::filesystem::path(output.path);
      // One that the old model does not name may be anybody's.
      if (is_data && std::ranges::find(data, file.filename().string()) == data.end()) continue;
      auto gone = files::remove_old_file(file);
      if (!gone) return tl::unexpected(std::move(gone.error()));
      if (*gone) removed.push_back(file.string());
    }
    return removed;
  }

  // What only a report asks for: finding components and open edges takes longer than to extract the mesh.
  Result<void> record(const Surface& surface, OutputFile& file) {
    const Stopwatch watch;
    context_.progress().begin("measuring", 0);
    auto made = mesh_record(surface.iso, file.written.job.path, surface.mesh, context_);
    if (!made) return tl::unexpected(std::move(made.error()));
    made->error = surface.error;
    file.records.push_back(std::move(*made));
    file.recording += watch.elapsed();
    return {};
  }

  // Values that were found may be the same, which nobody could know who asked for them.
  void tell_repeated(const OutputFileJob& output, std::span<const ResolvedIso> asked) {
    for (std::size_t i = 1; i < asked.size(); ++i) {
      const auto before = asked.first(i);
      const auto same = std::ranges::find_if(before, [&](const auto& iso) { return is_repeated(iso, asked[i]); });
      if (same == before.end()) continue;
      events_.note(fmt::format("{}: iso {} and {} are the same value, {}: {} has one surface for both", source_.label,
                               text_of(same->asked), text_of(asked[i].asked), asked[i].value,
                               files::shown_output_name(output.path)));
    }
  }

  void tell_skipped(const OutputFileJob& output, std::span<const ResolvedIso> asked, const std::vector<double>& isos,
                    const std::string& besides) {
    std::vector<std::string> skipped;
    for (const ResolvedIso& iso : asked) {
      if (std::ranges::find(isos, iso.value) == isos.end()) skipped.push_back(text_of(iso));
    }
    if (skipped.empty()) return;
    const std::string path = files::shown_output_name(output.path);
    events_.note(
        fmt::format("{}: no surface at {}{}; {}{}", source_.label, labels_ ? "" : "iso ", fmt::join(skipped, ", "),
                    isos.empty() && sink_ == nullptr ? path + " was not written" : path + " is without it", besides));
  }

  const ConversionJob& job_;
  const Context& context_;
  Outcome& outcome_;
  Recorder events_;
  OutcomeExtras extras_;
  KeptBackends* kept_backends_;  // null where none are kept
  MeshSink* sink_;               // null where files are written
  Source source_;
  std::optional<extract::LabelVoxels> labels_;  // where those are what is asked for
  std::unique_ptr<extract::Extractor> extractor_;
  std::unique_ptr<extract::Extractor> other_extractor_;  // only to verify
};

}  // namespace

Outcome run(const ConversionJob& job, const Context& context, Events& events, const OutcomeExtras& extras,
            KeptBackends* kept, MeshSink* sink) {
  const Stopwatch watch;
  Outcome outcome;
  outcome.threads = thread_count();
  Result<void> done;
  try {
    done = Conversion(job, context, outcome, events, extras, kept, sink).run();
  } catch (const std::bad_alloc&) {
    done = fail(ErrorKind::input, fmt::format("{}: not enough memory", files::shown_input_name(job.source.input)),
                Remedy::extract_part);
  } catch (const std::exception& error) {
    done = fail(ErrorKind::input,
                fmt::format("{}: unexpected: {}", files::shown_input_name(job.source.input), error.what()));
  }
  if (!done) outcome.error = std::move(done.error());
  outcome.total = watch.elapsed();
  outcome.bytes_read = context.counters().bytes_read;
  outcome.peak_memory = peak_memory();
  outcome.reserved_memory = context.memory().peak();
  return outcome;
}

}  // namespace isoextract::convert
