#include "cli/convert_command.hpp"

#include <algorithm>
#include <memory>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/machine.hpp"
#include "base/stopwatch.hpp"
#include "cli/backends.hpp"
#include "cli/convert_report.hpp"
#include "cli/field_label.hpp"
#include "cli/mesh_error.hpp"
#include "cli/mesh_simplify.hpp"
#include "cli/output_checks.hpp"
#include "cli/progress_bar.hpp"
#include "cli/remedies.hpp"
#include "cli/verification.hpp"
#include "convert/work_facts.hpp"
#include "extract/extractor.hpp"
#include "field/resample.hpp"
#include "field/statistics.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::cli {
namespace {

std::string times_text(const StageTime& time) {
  return fmt::format("{:.2f} s ({:.2f} s of processor time)", time.wall_seconds, time.cpu_seconds);
}

// One conversion. It keeps its report as it goes, so that the report of a failure says how far it came.
class Conversion {
 public:
  Conversion(const ConvertPlan& plan, const Messages& messages)
      : plan_(plan), messages_(messages), report_(begin_report(plan)) {}

  Result<void> run() {
    for (const std::string& text : plan_.notes) note(text);
    if (auto opened = open_backends(); !opened) return opened;
    if (auto checked = check_mesh_files(plan_); !checked) return checked;
    if (auto done = read(); !done) return done;
    for (const OutputJob& job : plan_.jobs) {
      if (auto done = run_job(job); !done) return done;
    }
    messages_.detail(fmt::format("peak memory {}", format_byte_size(peak_memory())));
    return {};
  }

  // Call once, after run().
  convert::ConversionReport take_report(const Result<void>& done) {
    report_.total = total_.elapsed();
    report_.bytes_read = files::bytes_read();
    report_.peak_memory = peak_memory();
    if (!done) {
      report_.error = done.error();
      report_.error->hint = words_of(done.error().hint);
    }
    return std::move(report_);
  }

 private:
  // Before the input is read: a missing GPU is told at once.
  Result<void> open_backends() {
    const Stopwatch watch;
    auto opened = open_backend(plan_.backend);
    if (!opened) return tl::unexpected(std::move(opened.error()));
    if (!opened->note.empty()) note(opened->note);
    extractor_ = std::move(opened->extractor);
    report_.backend = extractor_->name();
    report_.device = extractor_->device();
    if (report_.backend == backend_name(Backend::gpu)) {
      report_.stages.push_back({"open", std::nullopt, watch.elapsed()});
    }
    if (!plan_.verify) return {};
    BackendChoice other = plan_.backend;
    other.backend = extractor_->name() == backend_name(Backend::gpu) ? Backend::cpu : Backend::gpu;
    opened = open_backend(other);
    if (!opened) return tl::unexpected(std::move(opened.error()));
    other_extractor_ = std::move(opened->extractor);
    return {};
  }

  Result<void> read() {
    const Stopwatch watch;
    {
      ProgressBar bar(bar_wanted());
      volumes::ReadOptions options = plan_.read;
      options.progress = bar.progress();
      auto field = volumes::read_volume(plan_.input, options);
      if (!field) return tl::unexpected(std::move(field.error()));
      field_ = std::move(*field);
    }
    const StageTime time = watch.elapsed();
    for (const std::string& text : field_.notes) note(text);
    label_ = field_label(field_);
    tell_stage(fmt::format("{}: read in {}", label_, times_text(time)));
    report_.stages.push_back({"read", std::nullopt, time});
    report_.input = convert::input_facts(plan_.input, field_);
    look_at_reading();
    if (auto done = change_resolution(); !done) return done;
    return place();
  }

  // How much of the file was not even read, or not copied. Only sparse formats have more than one grid.
  void look_at_reading() {
    if (!(plan_.explain || plan_.report)) return;
    std::uint64_t grids = 1;
    if (std::holds_alternative<field::SparseSamples>(field_.samples)) {
      const auto found = volumes::list_grids(plan_.input, plan_.read);
      if (found) grids = found->size();
    }
    report_.work = convert::reading_facts(field_, grids);
    if (!plan_.explain) return;
    for (const convert::WorkFact& fact : report_.work) messages_.explanation(fact_text(fact));
  }

  // The grid of --resolution takes the place of the data, which only --error still needs.
  Result<void> change_resolution() {
    if (!plan_.resolution) return {};
    const Stopwatch watch;
    Result<field::ScalarField> grid;
    {
      ProgressBar bar(bar_wanted());
      grid = field::resample(field_, *plan_.resolution, plan_.read.limits, bar.progress());
    }
    if (!grid) return tl::unexpected(std::move(grid.error()));
    const StageTime time = watch.elapsed();
    for (const std::string& text : grid->notes) note(text);
    tell_stage(fmt::format("{}: resampled in {}", label_, times_text(time)));
    report_.stages.push_back({"resample", std::nullopt, time});
    report_.work.push_back(convert::resolution_fact(field_, *grid));
    if (plan_.explain) messages_.explanation(fact_text(report_.work.back()));
    if (plan_.error) data_ = std::move(field_);
    field_ = std::move(*grid);
    return {};
  }

  // What of the field is wanted, and where it goes.
  Result<void> place() {
    auto placed = place_field(field_, plan_.placement, plan_.roi);
    if (!placed) return tl::unexpected(std::move(placed.error()));
    output_from_index_ = placed->output_from_index;
    report_.output_from_index = output_from_index_;
    report_.region = placed->region;
    for (const std::string& text : placed->notes) note(text);
    return {};
  }

  Result<void> run_job(const OutputJob& job) {
    std::vector<mesh::Mesh> meshes;
    std::vector<double> isos;
    std::vector<MeshSimplification> simplifications;
    std::vector<MeshError> errors;
    std::vector<std::string> story;  // told when the bar is gone
    meshes::MeshWriteResult written;
    {
      ProgressBar bar(bar_wanted(), &context_.progress());
      for (const double iso : job.isos) {
        auto extraction = extract(iso, story);
        if (!extraction) return tl::unexpected(std::move(extraction.error()));
        mesh::Mesh& mesh = extraction->mesh;
        if (mesh.triangles.empty() && plan_.empty != EmptyPolicy::write) {
          if (plan_.empty == EmptyPolicy::error) return tl::unexpected(no_surface(iso));
          continue;
        }
        if (job.isos.size() > 1) mesh.name = fmt::format("{} iso {}", mesh.name, iso);
        if (plan_.simplify) simplify(mesh, iso, bar.progress(), simplifications, story);
        if (plan_.error) errors.push_back(measure_error(mesh, iso, story));
        isos.push_back(iso);
        meshes.push_back(std::move(mesh));
      }
      if (!meshes.empty()) {
        const Stopwatch watch;
        bar.progress()->begin("writing", 0);
        auto result = meshes::write_meshes(meshes, job.path, plan_.write);
        if (!result) return tl::unexpected(std::move(result.error()));
        written = std::move(*result);
        const StageTime time = watch.elapsed();
        story.push_back(fmt::format("{}: written in {}", shown_path(job), times_text(time)));
        report_.stages.push_back({"write", std::nullopt, time});
        if (plan_.report) record_meshes(job, meshes, isos, errors, bar.progress());
      }
    }
    for (const meshes::WrittenFile& file : written.files) report_.files.push_back({file.path, file.bytes});
    for (const std::string& text : std::exchange(late_notes_, {})) note(text);
    for (const std::string& line : story) tell_stage(line);
    for (const std::string& text : written.notes) note(text);
    tell_skipped(job, isos);
    if (!meshes.empty()) summarize(job, isos, meshes, written);
    for (const MeshSimplification& simplification : simplifications) {
      messages_.summary("  " + simplification_summary(simplification));
    }
    for (const MeshError& error : errors) tell_error(error);
    for (const convert::VerificationRecord& record : report_.verifications) {
      if (std::ranges::find(job.isos, record.iso) != job.isos.end()) {
        messages_.summary("  " + verification_summary(record));
      }
    }
    return {};
  }

  [[nodiscard]] extract::ExtractOptions extract_options(double iso) const {
    extract::ExtractOptions options = plan_.extract;
    options.iso = iso;
    options.region = report_.region;
    options.output_from_index = output_from_index_;
    return options;
  }

  void simplify(mesh::Mesh& mesh, double iso, Progress* progress, std::vector<MeshSimplification>& simplifications,
                std::vector<std::string>& story) {
    simplifications.push_back(simplify_mesh(mesh, iso, *plan_.simplify, output_from_index_, progress));
    const MeshSimplification& done = simplifications.back();
    story.push_back(fmt::format("{} iso {}: simplified in {}: {}", label_, iso, times_text(done.record.time),
                                simplification_details(done)));
    report_.stages.push_back({"simplify", iso, done.record.time});
    report_.simplifications.push_back(done.record);
  }

  MeshError measure_error(const mesh::Mesh& mesh, double iso, std::vector<std::string>& story) {
    const Stopwatch watch;
    MeshError error = measure_mesh_error(mesh, data_ ? *data_ : field_, extract_options(iso), *plan_.error,
                                         data_ ? &field_ : nullptr, context_);
    const StageTime time = watch.elapsed();
    story.push_back(fmt::format("{} iso {}: error measured in {}", label_, iso, times_text(time)));
    report_.stages.push_back({"error", iso, time});
    return error;
  }

  void tell_error(const MeshError& error) const {
    for (const std::string& line : error_summary(error)) messages_.summary("  " + line);
    if (!plan_.explain) return;
    for (const std::string& line : error_details(error)) messages_.explanation("  " + line);
  }

  Result<extract::Extraction> extract(double iso, std::vector<std::string>& story) {
    const Stopwatch watch;
    const extract::ExtractOptions options = extract_options(iso);
    auto extraction = extractor_->extract(field_, options, context_);
    if (!extraction && gave_way(extraction.error())) extraction = extractor_->extract(field_, options, context_);
    if (!extraction) return extraction;
    const extract::ExtractStats& stats = extraction->stats;
    story.push_back(
        fmt::format("{} iso {}: extracted in {}: {:.3f} s to compare samples, {:.3f} s to count, {:.3f} s "
                    "to make the mesh",
                    label_, iso, times_text(watch.elapsed()), stats.classify.wall_seconds, stats.count.wall_seconds,
                    stats.emit.wall_seconds));
    report_.stages.push_back({"classify", iso, stats.classify});
    if (stats.device) {
      report_.stages.push_back({"compile", iso, stats.device->compile});
      report_.stages.push_back({"upload", iso, stats.device->upload});
      report_.bytes_uploaded += stats.device->bytes_uploaded;
      story.push_back(
          fmt::format("{} iso {}: of that {:.3f} s to upload {}, {:.3f} s to capture {}, {:.3f} s to read "
                      "it back, {:.3f} s to weld",
                      label_, iso, stats.device->upload.wall_seconds, format_byte_size(stats.device->bytes_uploaded),
                      stats.device->capture.wall_seconds, format_byte_size(stats.device->bytes_captured),
                      stats.device->read_back.wall_seconds, stats.device->weld.wall_seconds));
    }
    report_.stages.push_back({"count", iso, stats.count});
    report_.stages.push_back({"emit", iso, stats.emit});
    const convert::AskedFor asked{.flat_normals = plan_.write.flat_normals, .error = plan_.error.has_value()};
    const std::vector<convert::WorkFact> facts = convert::extraction_facts(stats, options, asked);
    if (plan_.explain) {
      for (const convert::WorkFact& fact : facts) story.push_back(fact_text(fact));
    }
    report_.extractions.push_back({iso, extraction->mesh.triangles.size(), facts});
    if (other_extractor_ != nullptr) {
      if (auto verified = verify(extraction->mesh, options, story); !verified) return tl::unexpected(verified.error());
    }
    return extraction;
  }

  // Under --backend auto a GPU that cannot do the work is no reason to end: the processor takes over, and that is told.
  // With --verify it is: nothing would be left to verify.
  bool gave_way(const Error& error) {
    const bool may = plan_.backend.backend == Backend::automatic && extractor_->name() == backend_name(Backend::gpu) &&
                     other_extractor_ == nullptr;
    if (!may || error.kind != ErrorKind::unavailable) return false;
    extractor_ = extract::make_cpu_extractor();
    report_.backend = extractor_->name();
    report_.device = extractor_->device();
    late_notes_.push_back(fmt::format("--backend auto: cpu, because {}", error.message));
    return true;
  }

  // Against the other backend. The keys have done their work then.
  Result<void> verify(mesh::Mesh& mesh, const extract::ExtractOptions& options, std::vector<std::string>& story) {
    auto record = compare_backends(field_, options, mesh, *extractor_, *other_extractor_, context_);
    if (!record) return tl::unexpected(std::move(record.error()));
    mesh.edges = {};
    story.push_back(fmt::format("{} iso {}: verified in {}", label_, options.iso, times_text(record->time)));
    report_.stages.push_back({"verify", options.iso, record->time});
    report_.verifications.push_back(std::move(*record));
    return check_verification(label_, report_.verifications.back());
  }

  // What only the report asks for: finding components and open edges takes about as long as writing.
  void record_meshes(const OutputJob& job, const std::vector<mesh::Mesh>& meshes, const std::vector<double>& isos,
                     const std::vector<MeshError>& errors, Progress* progress) {
    const Stopwatch watch;
    progress->begin("measuring", meshes.size());
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      report_.meshes.push_back(convert::mesh_record(isos[m], job.path, meshes[m]));
      if (!errors.empty()) report_.meshes.back().error = json_of(errors[m]);
      progress->advance(1);
    }
    report_.stages.push_back({"mesh facts", std::nullopt, watch.elapsed()});
  }

  void tell_stage(const std::string& line) const {
    if (plan_.explain) {
      messages_.explanation(line);
    } else {
      messages_.detail(line);
    }
  }

  static std::string fact_text(const convert::WorkFact& fact) { return fmt::format("  {}: {}", fact.done, fact.text); }

  void note(const std::string& text) {
    messages_.note(text);
    report_.notes.push_back(text);
  }

  Error no_surface(double iso) {
    const Stopwatch watch;
    const field::FieldStatistics statistics = field::measure_statistics(field_);
    report_.stages.push_back({"statistics", std::nullopt, watch.elapsed()});
    if (statistics.samples == 0) {
      return {ErrorKind::input, fmt::format("{}: there is no surface: no sample is a finite number", label_), ""};
    }
    const bool roi_hides_it = report_.region && statistics.min <= iso && iso <= statistics.max;
    const field::IsoSuggestion suggestion = field::suggest_iso(field_, statistics);
    const bool helps = statistics.min < suggestion.iso && suggestion.iso < statistics.max;
    const std::string other = helps ? fmt::format("try --iso {} ({})", suggestion.iso, suggestion.method)
                                    : std::string("try another input: this one has no surface worth suggesting");
    return {ErrorKind::input,
            fmt::format("{}: no surface at iso {}{}{}; the values {}run from {:.6g} to {:.6g}", label_, iso,
                        report_.region ? " in the --roi" : "", plan_.resolution ? " on the grid of --resolution" : "",
                        report_.region ? "of the whole field " : "", statistics.min, statistics.max),
            roi_hides_it ? "widen the --roi; --empty skip makes this no error"
                         : other + "; --empty skip makes this no error"};
  }

  void tell_skipped(const OutputJob& job, const std::vector<double>& isos) {
    std::vector<double> skipped;
    for (const double iso : job.isos) {
      if (std::find(isos.begin(), isos.end(), iso) == isos.end()) skipped.push_back(iso);
    }
    if (skipped.empty()) return;
    note(fmt::format("{}: no surface at iso {}; {}", label_, fmt::join(skipped, ", "),
                     isos.empty() ? fmt::format("{} was not written", shown_path(job))
                                  : fmt::format("{} is without it", shown_path(job))));
  }

  void summarize(const OutputJob& job, const std::vector<double>& isos, const std::vector<mesh::Mesh>& meshes,
                 const meshes::MeshWriteResult& written) {
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    for (const mesh::Mesh& mesh : meshes) {
      triangles += mesh.triangles.size();
      vertices += mesh.positions.size();
    }
    std::uint64_t bytes = 0;
    for (const meshes::WrittenFile& file : written.files) bytes += file.bytes;
    messages_.summary(fmt::format("{} iso {} -> {}: {} triangles, {} vertices, {}; {}; {:.2f} s", label_,
                                  fmt::join(isos, ", "), shown_path(job), triangles, vertices, format_byte_size(bytes),
                                  describe(plan_.placement), watch_.elapsed().wall_seconds));
    watch_.restart();
  }

  static std::string shown_path(const OutputJob& job) { return job.path == "-" ? "stdout" : job.path; }
  [[nodiscard]] bool bar_wanted() const { return messages_.verbosity() != Verbosity::quiet; }

  const ConvertPlan& plan_;
  const Context context_{MemoryBudget(plan_.read.limits.memory_bytes)};
  const Messages& messages_;
  Stopwatch total_;
  Stopwatch watch_;  // since the start, or since the last file
  convert::ConversionReport report_;
  field::ScalarField field_;                // that is extracted from
  std::optional<field::ScalarField> data_;  // with --resolution and --error: what was read
  std::string label_;
  field::Affine output_from_index_;
  std::unique_ptr<extract::Extractor> extractor_;
  std::unique_ptr<extract::Extractor> other_extractor_;  // only to verify
  std::vector<std::string> late_notes_;                  // told when the bar is gone
};

}  // namespace

Result<void> run_convert(const ConvertPlan& plan, const Messages& messages) {
  if (plan.report) {
    if (auto checked = check_report_file(plan); !checked) return checked;
  }
  Conversion conversion(plan, messages);
  Result<void> done;
  try {
    done = conversion.run();
  } catch (const std::bad_alloc&) {
    done = fail(ErrorKind::input, fmt::format("{}: not enough memory", plan.input), "convert a part with --roi");
  }
  if (!plan.report) return done;
  auto reported = write_report(*plan.report, conversion.take_report(done));
  if (done) return reported;
  if (!reported) messages.error(reported.error());
  return done;
}

}  // namespace isoextract::cli
