#include "cli/convert_command.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "base/byte_size.hpp"
#include "base/machine.hpp"
#include "base/stopwatch.hpp"
#include "cli/mesh_error_text.hpp"
#include "cli/progress_bar.hpp"
#include "cli/remedies.hpp"
#include "cli/simplify_text.hpp"
#include "cli/verification_text.hpp"
#include "convert/conversion.hpp"
#include "convert/field_label.hpp"
#include "convert/output_checks.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

std::string times_text(const StageTime& time) {
  return fmt::format("{:.2f} s ({:.2f} s of processor time)", time.wall_seconds, time.cpu_seconds);
}

// "world coordinates, turned from z up to y up, scaled by 0.001 (mm to m)"
std::string describe(const convert::Placement& placement) {
  if (placement.space == convert::Space::index) return "voxel coordinates";
  std::string text = "world coordinates";
  if (placement.turn_z_up_to_y_up) text += ", turned from z up to y up";
  if (placement.scale != 1 || !placement.unit.empty()) text += fmt::format(", scaled by {}", placement.scale);
  if (!placement.unit.empty()) text += fmt::format(" ({} to m)", placement.unit);
  return text;
}

// What would have been done besides, had it been asked for.
std::string_view option_for(const convert::WorkFact& fact) {
  if (fact.what == "error") return "; --error measures it";
  if (fact.what == "caps") return "; --cap makes them";
  return "";
}

std::string shown_path(const std::string& path) { return path == "-" ? "stdout" : path; }

// Says on stderr what a conversion does: notes and summaries as they come, stages where --explain or --verbose asks.
class Narrator final : public convert::Events {
 public:
  Narrator(const ConvertPlan& plan, const Messages& messages, ProgressBar& bar)
      : plan_(plan), messages_(messages), bar_(bar) {}

  void note(const std::string& text) override {
    bar_.above([&] { messages_.note(text); });
  }

  void read(const std::string& /*input*/, const field::ScalarField& field, const StageTime& time) override {
    label_ = convert::field_label(field);
    tell_stage(fmt::format("{}: read in {}", label_, times_text(time)));
  }

  void worked(const convert::WorkFact& fact) override { explain(fact); }

  void resampled(const field::ScalarField& /*grid*/, const convert::WorkFact& fact, const StageTime& time) override {
    tell_stage(fmt::format("{}: resampled in {}", label_, times_text(time)));
    explain(fact);
  }

  void extracted(const convert::ExtractedSurface& surface) override {
    const extract::ExtractStats& stats = surface.stats;
    tell_stage(
        fmt::format("{} iso {}: extracted in {}: {:.3f} s to compare samples, {:.3f} s to count, {:.3f} s "
                    "to make the mesh",
                    label_, surface.iso, times_text(surface.time), stats.classify.wall_seconds,
                    stats.count.wall_seconds, stats.emit.wall_seconds));
    if (stats.device) {
      tell_stage(fmt::format(
          "{} iso {}: of that {:.3f} s to upload {}, {:.3f} s to capture {}, {:.3f} s to read "
          "it back, {:.3f} s to weld",
          label_, surface.iso, stats.device->upload.wall_seconds, format_byte_size(stats.device->bytes_uploaded),
          stats.device->capture.wall_seconds, format_byte_size(stats.device->bytes_captured),
          stats.device->read_back.wall_seconds, stats.device->weld.wall_seconds));
    }
    for (const convert::WorkFact& fact : surface.work) explain(fact);
  }

  void verified(const convert::VerificationRecord& record) override {
    if (record.not_applicable.empty()) {
      tell_stage(fmt::format("{} iso {}: verified in {}", label_, record.iso, times_text(record.time)));
    }
    verified_.push_back(verification_summary(record));
  }

  void simplified(const convert::MeshSimplification& simplification) override {
    tell_stage(fmt::format("{} iso {}: simplified in {}: {}", label_, simplification.iso,
                           times_text(simplification.facts.time), simplification_details(simplification)));
    simplified_.push_back(simplification_summary(simplification));
  }

  void measured(const convert::MeshError& error, const StageTime& time) override {
    tell_stage(fmt::format("{} iso {}: error measured in {}", label_, error.iso, times_text(time)));
    errors_.push_back(error);
  }

  void written(const convert::WrittenOutput& output) override {
    if (output.isos.empty()) {
      forget();
      return;
    }
    const std::string path = shown_path(output.job.path);
    tell_stage(fmt::format("{}: written in {}", path, times_text(output.time)));
    std::uint64_t bytes = 0;
    for (const meshes::WrittenFile& file : output.files) bytes += file.bytes;
    bar_.above([&] {
      messages_.summary(fmt::format("{} iso {} -> {}: {} triangles, {} vertices, {}; {}; {:.2f} s", label_,
                                    fmt::join(output.isos, ", "), path, output.triangles, output.vertices,
                                    format_byte_size(bytes), describe(plan_.job.source.placement),
                                    watch_.elapsed().wall_seconds));
      for (const std::string& line : simplified_) messages_.summary("  " + line);
      for (const convert::MeshError& error : errors_) tell_error(error);
      for (const std::string& line : verified_) messages_.summary("  " + line);
    });
    forget();
  }

 private:
  void tell_stage(const std::string& line) {
    bar_.above([&] { plan_.explain ? messages_.explanation(line) : messages_.detail(line); });
  }

  void explain(const convert::WorkFact& fact) {
    if (!plan_.explain) return;
    bar_.above([&] { messages_.explanation(fmt::format("  {}: {}{}", fact.done, fact.text, option_for(fact))); });
  }

  void tell_error(const convert::MeshError& error) const {
    for (const std::string& line : error_summary(error)) messages_.summary("  " + line);
    if (!plan_.explain) return;
    for (const std::string& line : error_details(error)) messages_.explanation("  " + line);
  }

  // What was about the file that is done.
  void forget() {
    verified_.clear();
    simplified_.clear();
    errors_.clear();
    watch_.restart();
  }

  const ConvertPlan& plan_;
  const Messages& messages_;
  ProgressBar& bar_;
  Stopwatch watch_;  // since the start, or since the last file
  std::string label_;
  std::vector<std::string> verified_;
  std::vector<std::string> simplified_;
  std::vector<convert::MeshError> errors_;
};

Result<void> check_stdout(const convert::ConversionJob& job) {
  const bool to_stdout = std::ranges::find(job.outputs, "-", &convert::OutputFileJob::path) != job.outputs.end();
  const bool is_text = job.ascii || job.format == meshes::MeshFormat::obj;
  if (!to_stdout || is_text || ::isatty(STDOUT_FILENO) == 0) return {};
  return fail(ErrorKind::usage,
              fmt::format("stdout is a terminal, and {} is binary data", meshes::mesh_format_info(job.format).name),
              "redirect it to a file or a pipe");
}

Result<void> check_report_file(const ConvertPlan& plan) {
  if (!plan.report) return {};
  auto checked = convert::check_other_file(*plan.report, plan.job);
  if (!checked && checked.error().kind == ErrorKind::usage) checked.error().hint = "choose another name with --report";
  return checked;
}

Result<void> write_report(const ConvertPlan& plan, const convert::Outcome& outcome) {
  const std::string hint = outcome.error ? words_of(outcome.error->hint) : "";
  auto file = files::OutputFile::create(*plan.report);
  if (!file) return tl::unexpected(file.error());
  const std::string text =
      convert::json_text(convert::report_of(plan.job, outcome, plan.arguments, plan.memory.limit(), hint));
  if (auto written = file->write(text); !written) return written;
  return file->commit();
}

}  // namespace

Result<void> run_convert(const ConvertPlan& plan, const Messages& messages) {
  if (auto checked = check_report_file(plan); !checked) return checked;
  convert::Outcome outcome;
  for (const std::string& text : plan.notes) messages.note(text);
  if (auto checked = check_stdout(plan.job); checked) {
    const Context context{plan.memory};
    ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
    Narrator narrator(plan, messages, bar);
    outcome = convert::run(plan.job, context, narrator, {plan.report.has_value()});
  } else {
    outcome.error = std::move(checked.error());
  }
  outcome.notes.insert(outcome.notes.begin(), plan.notes.begin(), plan.notes.end());
  if (outcome.done()) messages.detail(fmt::format("peak memory {}", format_byte_size(outcome.peak_memory)));
  const Result<void> done = outcome.error ? tl::unexpected(*outcome.error) : Result<void>();
  if (!plan.report) return done;
  auto reported = write_report(plan, outcome);
  if (done) return reported;
  if (!reported) messages.error(reported.error());
  return done;
}

}  // namespace isoextract::cli
