#include "cli/convert_command.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "base/stopwatch.hpp"
#include "cli/field_label.hpp"
#include "cli/mesh_error.hpp"
#include "cli/progress_bar.hpp"
#include "extract/extractor.hpp"
#include "field/statistics.hpp"
#include "io/output_file.hpp"

namespace isoextract {
namespace {

namespace fs = std::filesystem;

// The files that a job writes: glTF is two.
std::vector<fs::path> files_of(const OutputJob& job, MeshFormat format) {
  std::vector<fs::path> files{job.path};
  if (format == MeshFormat::gltf) files.push_back(fs::path(job.path).replace_extension(".bin"));
  return files;
}

// Finds out before the work whether the result could be written at its end. Devices and pipes are left alone: opening
// a pipe twice would end it for its reader.
Result<void> check_output(const fs::path& path, const std::string& input) {
  std::error_code none;
  if (fs::equivalent(path, input, none)) {
    return fail(ErrorKind::usage, fmt::format("{}: this is the input; it is not overwritten", path.string()),
                "choose another name with -o");
  }
  const fs::file_status status = fs::status(path, none);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status)) return {};
  auto probe = OutputFile::create(path);
  if (!probe) return tl::unexpected(probe.error());
  return {};
}

Result<void> check_stdout(const MeshWriteOptions& options) {
  const bool is_text = options.ascii || options.format == MeshFormat::obj;
  if (is_text || ::isatty(STDOUT_FILENO) == 0) return {};
  return fail(ErrorKind::usage,
              fmt::format("stdout is a terminal, and {} is binary data", mesh_format_info(options.format).name),
              "redirect it to a file or a pipe");
}

std::string times_text(const StageTime& time) {
  return fmt::format("{:.2f} s ({:.2f} s of processor time)", time.wall_seconds, time.cpu_seconds);
}

class Conversion {
 public:
  Conversion(const ConvertPlan& plan, const Messages& messages) : plan_(plan), messages_(messages) {}

  Result<void> run() {
    for (const std::string& note : plan_.notes) messages_.note(note);
    for (const OutputJob& job : plan_.jobs) {
      if (auto checked = check_outputs(job); !checked) return checked;
    }
    if (auto done = read(); !done) return done;
    for (const OutputJob& job : plan_.jobs) {
      if (auto done = run_job(job); !done) return done;
    }
    messages_.detail(fmt::format("peak memory {}", format_byte_size(peak_memory())));
    return {};
  }

 private:
  Result<void> check_outputs(const OutputJob& job) const {
    if (job.path == "-") return check_stdout(plan_.write);
    for (const fs::path& file : files_of(job, plan_.write.format)) {
      if (auto checked = check_output(file, plan_.input); !checked) return checked;
    }
    return {};
  }

  Result<void> read() {
    const Stopwatch watch;
    {
      ProgressBar bar(bar_wanted());
      ReadOptions options = plan_.read;
      options.progress = bar.progress();
      auto field = read_volume(plan_.input, options);
      if (!field) return tl::unexpected(std::move(field.error()));
      field_ = std::move(*field);
    }
    for (const std::string& note : field_.notes) messages_.note(note);
    label_ = field_label(field_);
    tell_stage(fmt::format("{}: read in {}", label_, times_text(watch.elapsed())));
    if (plan_.explain) explain_reading();
    return place();
  }

  // What of the field is wanted, and where it goes.
  Result<void> place() {
    output_from_index_ = output_from_index(field_, plan_.placement);
    if (field_.index_to_world.is_regular() && !output_from_index_.is_regular()) {
      return fail(
          ErrorKind::usage,
          fmt::format("{}: scaled by {}, coordinates leave the range of numbers", label_, plan_.placement.scale),
          "choose another --scale or --unit");
    }
    if (!plan_.roi) return {};
    auto region = samples_in_box(field_, *plan_.roi, plan_.placement.space);
    if (!region) return tl::unexpected(region.error());
    region_ = *region;
    if (plan_.placement.space == Space::world && !is_axis_aligned(field_.index_to_world)) {
      const glm::i64vec3 dims = region_->dims();
      messages_.note(fmt::format("{}: its axes are oblique, so --roi takes the {} x {} x {} samples that cover the box",
                                 label_, dims.x, dims.y, dims.z));
    }
    return {};
  }

  Result<void> run_job(const OutputJob& job) {
    std::vector<Mesh> meshes;
    std::vector<double> isos;
    std::vector<MeshError> errors;
    std::vector<std::string> story;  // told when the bar is gone
    MeshWriteResult written;
    {
      ProgressBar bar(bar_wanted());
      for (const double iso : job.isos) {
        auto extraction = extract(iso, bar.progress(), story);
        if (!extraction) return tl::unexpected(std::move(extraction.error()));
        Mesh& mesh = extraction->mesh;
        if (mesh.triangles.empty() && plan_.empty != EmptyPolicy::write) {
          if (plan_.empty == EmptyPolicy::error) return tl::unexpected(no_surface(iso));
          continue;
        }
        if (job.isos.size() > 1) mesh.name = fmt::format("{} iso {}", mesh.name, iso);
        if (plan_.error) errors.push_back(measure_error(mesh, iso, bar.progress(), story));
        isos.push_back(iso);
        meshes.push_back(std::move(mesh));
      }
      if (!meshes.empty()) {
        const Stopwatch watch;
        bar.progress()->begin("writing", 0);
        auto result = write_meshes(meshes, job.path, plan_.write);
        if (!result) return tl::unexpected(std::move(result.error()));
        written = std::move(*result);
        story.push_back(fmt::format("{}: written in {}", shown_path(job), times_text(watch.elapsed())));
      }
    }
    for (const std::string& line : story) tell_stage(line);
    for (const std::string& note : written.notes) messages_.note(note);
    tell_skipped(job, isos);
    if (!meshes.empty()) summarize(job, isos, meshes, written);
    for (const MeshError& error : errors) tell_error(error);
    return {};
  }

  [[nodiscard]] ExtractOptions extract_options(double iso, Progress* progress) const {
    ExtractOptions options = plan_.extract;
    options.iso = iso;
    options.region = region_;
    options.output_from_index = output_from_index_;
    options.progress = progress;
    return options;
  }

  MeshError measure_error(const Mesh& mesh, double iso, Progress* progress, std::vector<std::string>& story) const {
    const Stopwatch watch;
    MeshError error = measure_mesh_error(mesh, field_, extract_options(iso, progress), *plan_.error);
    story.push_back(fmt::format("{} iso {}: error measured in {}", label_, iso, times_text(watch.elapsed())));
    return error;
  }

  void tell_error(const MeshError& error) const {
    for (const std::string& line : error_summary(error)) messages_.summary("  " + line);
    if (!plan_.explain) return;
    for (const std::string& line : error_details(error)) messages_.explanation("  " + line);
  }

  Result<Extraction> extract(double iso, Progress* progress, std::vector<std::string>& story) {
    const Stopwatch watch;
    auto extraction = extractor_->extract(field_, extract_options(iso, progress));
    if (!extraction) return extraction;
    const ExtractStats& stats = extraction->stats;
    story.push_back(fmt::format(
        "{} iso {}: extracted in {}: {:.3f} s to compare samples, {:.3f} s to count, {:.3f} s "
        "to make the mesh",
        label_, iso, times_text(watch.elapsed()), stats.classify_seconds, stats.count_seconds, stats.emit_seconds));
    if (plan_.explain) explain_extraction(stats, story);
    return extraction;
  }

  void tell_stage(const std::string& line) const {
    if (plan_.explain) {
      messages_.explanation(line);
    } else {
      messages_.detail(line);
    }
  }

  // How much of the file was not even read. Only sparse formats have more than one grid.
  void explain_reading() const {
    if (!std::holds_alternative<SparseSamples>(field_.samples)) return;
    if (const auto grids = list_grids(plan_.input, plan_.read); grids && grids->size() > 1) {
      messages_.explanation(
          fmt::format("  left out: the other {} grids of the file, which were not read", grids->size() - 1));
    }
  }

  void explain_extraction(const ExtractStats& stats, std::vector<std::string>& story) const {
    const std::uint64_t left_out = stats.bricks - stats.bricks_visited;
    story.push_back(fmt::format(
        "  left out: {} of {} bricks ({}), which the iso value does not cross ({:.1f} %)", left_out, stats.bricks,
        stats.brick,
        stats.bricks == 0 ? 0.0 : 100.0 * static_cast<double>(left_out) / static_cast<double>(stats.bricks)));
    if (stats.places_visited > 0) {
      story.push_back(fmt::format("  visited besides: {} places beside stored bricks", stats.places_visited));
    }
    story.push_back(fmt::format("  compared with the iso value: {} samples, each once", stats.samples_classified));
    if (stats.nan_samples > 0) {
      story.push_back(fmt::format("  taken as outside: {} samples that are not numbers", stats.nan_samples));
    }
    if (region_) {
      const glm::i64vec3 dims = region_->dims();
      story.push_back(
          fmt::format("  left out: what --roi does not hold; it holds {} x {} x {} samples", dims.x, dims.y, dims.z));
    }
    if (!plan_.extract.smooth_normals && !plan_.write.flat_normals) {
      story.push_back("  left out: normals, which nobody asked for");
    }
    if (!plan_.error) story.push_back("  left out: the error of the mesh; --error measures it");
    if (!plan_.extract.cap) story.push_back("  left out: caps where the surface leaves the data; --cap makes them");
  }

  Error no_surface(double iso) const {
    const FieldStatistics statistics = measure_statistics(field_);
    if (statistics.samples == 0) {
      return {ErrorKind::input, fmt::format("{}: there is no surface: no sample is a finite number", label_), ""};
    }
    const bool roi_hides_it = region_ && statistics.min <= iso && iso <= statistics.max;
    const IsoSuggestion suggestion = suggest_iso(field_, statistics);
    return {ErrorKind::input,
            fmt::format("{}: no surface at iso {}{}; the values {}run from {:.6g} to {:.6g}", label_, iso,
                        region_ ? " in the --roi" : "", region_ ? "of the whole field " : "", statistics.min,
                        statistics.max),
            roi_hides_it ? "widen the --roi; --empty skip makes this no error"
                         : fmt::format("try --iso {} ({}); --empty skip makes this no error", suggestion.iso,
                                       suggestion.method)};
  }

  void tell_skipped(const OutputJob& job, const std::vector<double>& isos) const {
    std::vector<double> skipped;
    for (const double iso : job.isos) {
      if (std::find(isos.begin(), isos.end(), iso) == isos.end()) skipped.push_back(iso);
    }
    if (skipped.empty()) return;
    messages_.note(fmt::format("{}: no surface at iso {}; {}", label_, fmt::join(skipped, ", "),
                               isos.empty() ? fmt::format("{} was not written", shown_path(job))
                                            : fmt::format("{} is without it", shown_path(job))));
  }

  void summarize(const OutputJob& job, const std::vector<double>& isos, const std::vector<Mesh>& meshes,
                 const MeshWriteResult& written) {
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    for (const Mesh& mesh : meshes) {
      triangles += mesh.triangles.size();
      vertices += mesh.positions.size();
    }
    std::uint64_t bytes = 0;
    for (const WrittenFile& file : written.files) bytes += file.bytes;
    messages_.summary(fmt::format("{} iso {} -> {}: {} triangles, {} vertices, {}; {}; {:.2f} s", label_,
                                  fmt::join(isos, ", "), shown_path(job), triangles, vertices, format_byte_size(bytes),
                                  describe(plan_.placement), watch_.elapsed().wall_seconds));
    watch_.restart();
  }

  static std::string shown_path(const OutputJob& job) { return job.path == "-" ? "stdout" : job.path; }
  [[nodiscard]] bool bar_wanted() const { return messages_.verbosity() != Verbosity::quiet; }

  const ConvertPlan& plan_;
  const Messages& messages_;
  Stopwatch watch_;  // since the start, or since the last file
  ScalarField field_;
  std::string label_;
  Affine output_from_index_;
  std::optional<IndexBox> region_;
  std::unique_ptr<Extractor> extractor_ = make_cpu_extractor();
};

}  // namespace

Result<void> run_convert(const ConvertPlan& plan, const Messages& messages) { return Conversion(plan, messages).run(); }

}  // namespace isoextract
