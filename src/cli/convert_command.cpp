// `isoextract convert`: converts volumes, particles and meshes to meshes, fields, particle files or pictures.
#include <algorithm>
#include <exception>
#include <filesystem>
#include <optional>
#include <type_traits>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include "base/byte_size.hpp"
#include "base/counted.hpp"
#include "base/machine.hpp"
#include "base/packed_values.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "batch/batch_run.hpp"
#include "batch/manifest.hpp"
#include "cli/batch_command.hpp"
#include "cli/batch_plan.hpp"
#include "cli/closed_text.hpp"
#include "cli/command_line.hpp"
#include "cli/config_file.hpp"
#include "cli/field_plan.hpp"
#include "cli/foreign_options.hpp"
#include "cli/iso_of_labels_note.hpp"
#include "cli/label_table.hpp"
#include "cli/messages.hpp"
#include "cli/output_folders.hpp"
#include "cli/output_plan.hpp"
#include "cli/pages_plan.hpp"
#include "cli/picture_plan.hpp"
#include "cli/plan.hpp"
#include "cli/planned_command.hpp"
#include "cli/progress_bar.hpp"
#include "cli/rank_run.hpp"
#include "cli/remedies.hpp"
#include "cli/report_file.hpp"
#include "cli/stage_lines.hpp"
#include "cli/threads.hpp"
#include "cli/up_axis_note.hpp"
#include "convert/output_checks.hpp"
#include "files/input_file_set.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

// Returns the option that would have enabled the work.
std::string_view option_for(const convert::WorkFact& fact) {
  if (fact.what == convert::WorkTopic::error) return "; --error measures it";
  if (fact.what == convert::WorkTopic::caps) return "; --cap makes them";
  return "";
}

// Returns the kind of the surfaces' values: "label" or "iso".
std::string_view surface_word(const convert::ConversionJob& job) {
  const std::vector<convert::IsoChoice> isos = job.isos();
  return !isos.empty() && isos.front().is_label() ? "label" : "iso";
}

// Returns the values without repetitions, in the order of first occurrence.
template <class T>
std::vector<T> without_repeats(const std::vector<T>& values) {
  std::vector<T> once;
  std::unordered_set<T> seen;
  for (const T& value : values) {
    if (seen.insert(value).second) once.push_back(value);
  }
  return once;
}

// Prints the progress of a conversion to stderr: notes and summaries, and stages with --explain or --verbose.
class ConversionPrinter final : public convert::Events {
 public:
  ConversionPrinter(const ConvertPlan& plan, const Messages& messages, ProgressBar& bar)
      : plan_(plan), messages_(messages), bar_(bar), word_(surface_word(plan.job)) {}

  void note(const Note& note) override {
    bar_.above([&] { messages_.note(note); });
  }

  void end(const convert::StageReport& report) override {
    if (!report.did.empty() && report.time) {
      // Explanations of a label follow its own lines.
      if (report.id && report.id->is_label() && !plan_.explain) {
        label_stages_.add(report);
      } else {
        for (const std::string& line : stage_lines(report)) tell_stage(line);
      }
    }
    if (report.lines.empty()) {
      for (const convert::WorkFact& fact : report.work) explain(fact);
    }
    for (const convert::StageReport::Line& line : report.lines) {
      lines_.push_back(
          {of_grid(report.label, line.text), report.id, line.explains, stage_info(report.stage).line_rank});
    }
    if (report.output) tell_written(report, *report.output);
  }

  void end_labels(const convert::LabelTimes& times) override {
    for (const std::string& line : label_stages_.take_lines(times)) tell_stage(line);
  }

 private:
  void tell_stage(const std::string& line) {
    bar_.above([&] { plan_.explain ? messages_.explanation(line) : messages_.detail(line); });
  }

  void explain(const convert::WorkFact& fact) {
    if (!plan_.explain) return;
    bar_.above(
        [&] { messages_.explanation(fmt::format("  {}: {}{}", word_of(fact.done), fact.text, option_for(fact))); });
  }

  // Prints a line about the file, and the lines of the stages that made it.
  void tell_written(const convert::StageReport& report, const convert::WrittenOutput& output) {
    const std::string& path = report.subject;
    const double seconds = watch_.elapsed().wall_seconds;
    const std::string bytes = format_byte_size(output.bytes);
    std::string line;
    if (!output.samples.empty()) {
      line = fmt::format("{} -> {}: {}; {}; {:.2f} s", report.label, path, output.samples, bytes, seconds);
    } else if (!output.surfaces.empty()) {
      std::vector<std::string> labels;
      for (const convert::WrittenOutput::Part& part : output.surfaces) labels.push_back(part.label);
      line = fmt::format("{}{} -> {}{}: {}, {}, {}; {}; {}; {:.2f} s", fmt::join(without_repeats(labels), ", "),
                         surfaces_text(output), path,
                         output.files > (output.surfaces.front().id.is_label() ? 1U : 2U)
                             ? fmt::format(" ({} files)", output.files)
                             : "",
                         counted(output.triangles, "triangle"), counted(output.vertices, "vertex", "vertices"), bytes,
                         closed_or_open_text(output, plan_.job), output.placement, seconds);
    }
    std::ranges::stable_sort(lines_, {}, &SurfaceLine::rank);
    if (!line.empty()) {
      bar_.above([&] {
        messages_.summary(line);
        for (const SurfaceLine& other : join_equal_lines(lines_)) tell(other);
        if (!output.surfaces.empty() && output.surfaces.front().id.is_label()) {
          for (const std::string& row : label_table(output)) messages_.detail(row);
        }
      });
    }
    lines_.clear();
    watch_.restart();
  }

  // Returns "3", or "3 (Spleen)" for a label with a name.
  static std::string id_and_name(const convert::WrittenOutput::Part& part) {
    constexpr std::size_t kMostOfName = 40;
    const bool has_name = part.id.is_label() && !part.name.ends_with(part.id.name());
    return has_name ? fmt::format("{} ({})", part.id.text(), printable(part.name, kMostOfName)) : part.id.text();
  }

  // Returns " iso 0.3, 0.5", or " 3000 labels from 1 to 3000" for more than kMostListed labels; for a mesh file "", or
  // " (3 meshes)"; for terrain "".
  [[nodiscard]] std::string surfaces_text(const convert::WrittenOutput& output) const {
    if (plan_.job.source.mesh) {
      const std::size_t meshes = output.surfaces.size();
      return meshes > 1 ? fmt::format(" ({} meshes)", meshes) : std::string();
    }
    if (plan_.job.surface.heights) return {};
    constexpr std::size_t kMostListed = 20;
    std::vector<std::string> ids;
    for (const convert::WrittenOutput::Part& part : output.surfaces) ids.push_back(id_and_name(part));
    ids = without_repeats(ids);
    if (ids.size() <= kMostListed || !output.surfaces.front().id.is_label()) {
      return fmt::format(" {} {}", word_, fmt::join(ids, ", "));
    }
    const auto [least, greatest] = std::ranges::minmax(output.surfaces, {}, &convert::WrittenOutput::Part::id);
    return fmt::format(" {} labels from {} to {}", ids.size(), least.id.text(), greatest.id.text());
  }

  void tell(const SurfaceLine& line) const {
    if (!line.explains) messages_.summary("  " + line.text);
    if (line.explains && plan_.explain) messages_.explanation("  " + line.text);
  }

  // Prepends the grid to a line about a surface if the job converts several grids.
  [[nodiscard]] std::string of_grid(const std::string& label, const std::string& line) const {
    return plan_.job.source.more_grids.empty() || label.empty() ? line : fmt::format("{}: {}", label, line);
  }

  const ConvertPlan& plan_;
  const Messages& messages_;
  ProgressBar& bar_;
  std::string_view word_;
  Stopwatch watch_;                 // runs since the start or the last file
  std::vector<SurfaceLine> lines_;  // for the current file
  LabelStages label_stages_;
};

Result<void> check_stdout(const convert::ConversionJob& job) {
  const bool to_stdout = std::ranges::find(job.outputs, "-", &convert::OutputFileJob::path) != job.outputs.end();
  if (to_stdout && ranks_of_run() != nullptr) {
    return fail(ErrorCode::usage, "stdout of several ranks passes through mpirun or srun, which may change bytes",
                "give the output a file, with -o FILE");
  }
  const auto* meshes = job.writes<convert::MeshFileOptions>();
  const auto* particles = job.writes<convert::ParticleFileOptions>();
  const bool is_text = (meshes != nullptr && (meshes->ascii || meshes->format == mesh_io::MeshFormat::obj)) ||
                       (particles != nullptr && particles->format == particle_io::ParticleFileFormat::xyz);
  if (!to_stdout || is_text || ::isatty(STDOUT_FILENO) == 0) return {};
  return fail(ErrorCode::usage,
              fmt::format("stdout is a terminal, and {} is binary data",
                          meshes != nullptr ? mesh_io::mesh_format_info(meshes->format).name
                          : job.writes<convert::PictureFileOptions>() != nullptr ? kPictureFormat
                          : particles != nullptr                                 ? word_of(particles->format)
                                                 : word_of(job.writes<convert::FieldFileOptions>()->format)),
              "redirect stdout to a file or a pipe");
}

// Returns the result of `step`, with exceptions turned into errors.
template <class Step>
std::invoke_result_t<Step> attempt(const Step& step) {
  try {
    return step();
  } catch (const std::exception&) {
    return tl::unexpected(error_of_exception());
  }
}

convert::Outcome failed(const Error& error) {
  convert::Outcome outcome;
  outcome.error = error;
  outcome.peak_memory = peak_memory();
  return outcome;
}

// Writes a report about invalid options. Fails if it would overwrite a file that the options name, unless `error`
// already is about this file.
Result<void> report_no_plan(const ConvertFlags& flags, const std::vector<std::string>& arguments, const Error& error) {
  if (!flags.report || flags.report->empty() || *flags.report == "-") return {};
  const auto name = plan_report_name(*flags.report);
  // The frames and their steps are unknown.
  if (!name || name->uses(batch::OutputWord::frame) || name->uses(batch::OutputWord::step)) return {};
  const std::vector<std::string>& inputs = flags.input.inputs;
  const std::string path = report_path(*name, {1, inputs.empty() ? "" : inputs.front(), flags.input.grid().value_or(""),
                                               flags.isos, true, flags.input.more_grids()});
  if (batch::is_manifest_name(std::filesystem::path(path).filename().string())) return {};
  files::InputFileSet read;
  for (const batch::NamedFile& file : other_files(flags, {}, {}).read) read.add(file.path, file.what);
  Result<void> checked = read.check(path);
  for (const convert::ConversionJob& job : plan_named_files(flags)) {
    if (checked) checked = check_report_file(path, job, Context());
  }
  if (!checked) return error.message.starts_with(path + ": ") ? Result<void>() : checked;
  return write_report(path, nullptr, failed(error), {}, arguments, 0);
}

// Prints what happens to the single frame of a batch of one.
class Conversion final : public batch::RunEvents {
 public:
  Conversion(const ConvertPlan& plan, const Messages& messages) : plan_(plan), messages_(messages) {}

  convert::Events* started(std::size_t /*frame*/, const Context& context) override {
    bar_.emplace(context.progress(), messages_.verbosity() != Verbosity::quiet);
    return &narrator_.emplace(plan_, messages_, *bar_);
  }
  Notes field_notes(const field::ScalarField& field) override {
    Notes notes;
    if (const auto note = iso_of_labels_note(field, plan_.job)) notes.push_back(*note);
    if (!plan_.on_side_text || printed_axis_note_) return notes;
    if (const auto note = up_axis_note(field, plan_.job.source.placement.up, *plan_.on_side_text)) {
      printed_axis_note_ = true;  // once, even if there are several grids
      notes.push_back(*note);
    }
    return notes;
  }
  void over(std::size_t /*frame*/, const batch::FrameRow& /*row*/, convert::Outcome* outcome,
            const Error* /*error*/) override {
    ended = std::move(*outcome);
    narrator_.reset();
    bar_.reset();
  }

  convert::Outcome ended;

 private:
  const ConvertPlan& plan_;
  const Messages& messages_;
  std::optional<ProgressBar> bar_;
  std::optional<ConversionPrinter> narrator_;
  bool printed_axis_note_ = false;
};

struct Converted {
  convert::Outcome outcome;
  std::vector<batch::FrameRow> rows;  // one row, or none if nothing was started
};

// Runs a batch of one frame, without records for a later run.
Converted convert_as_planned(const ConvertPlan& plan, const Messages& messages) {
  Converted converted;
  const Result<void> begun = attempt([&]() -> Result<void> {
    TRY(check_stdout(plan.job));
    TRY(limit_threads(plan.threads));
    const batch::BatchJob one{{{0, plan.job}}, {}};
    batch::RunOptions options{.keeps_records = false};
    options.scheduler.threads = tbb::this_task_arena::max_concurrency();
    options.scheduler.extras = {.mesh_facts = plan.report || plan.pages.html,
                                .volume_hint = std::string(kHowToKeepVolumes)};
    options.scheduler.extras.ranks = ranks_of_run();
    auto run = TRY(batch::BatchRun::open(one, std::move(options), plan.context));
    Conversion conversion(plan, messages);
    converted.rows = run.run(conversion).rows;
    converted.outcome = std::move(conversion.ended);
    return {};
  });
  if (!begun) converted.outcome = failed(begun.error());
  return converted;
}

// Returns a note that says how the ranks of this run divided the conversion; nullopt without ranks.
std::optional<Note> note_of_ranks(const std::optional<int>& threads) {
  const Ranks* const ranks = ranks_of_run();
  if (ranks == nullptr) return std::nullopt;
  std::string text = fmt::format("{} share the samples", ranks_text());
  if (!ranks->is_shared())
    text = fmt::format("{}: rank 0 converts alone, because {}", ranks_text(), ranks->why_alone());
  return Note{NoteId::shard, text + threads_text(threads)};
}

// Returns how long this rank has waited for others.
double seconds_waited() { return ranks_of_run() != nullptr ? ranks_of_run()->waited() : 0; }

// Prints how long each rank worked, if the ranks shared the conversion. All ranks must call this function.
Result<void> tell_rank_times(double busy_seconds, const Messages& messages) {
  Ranks* const ranks = ranks_of_run();
  if (ranks == nullptr || !ranks->is_shared()) return {};
  const auto told = TRY(ranks->gather(Packer().put(busy_seconds).take()));
  std::vector<double> seconds;
  for (const std::string& one : told) seconds.push_back(Unpacker(one).get<double>());
  for (std::size_t r = 0; r < seconds.size(); ++r) messages.detail(fmt::format("rank {}: {:.2f} s", r, seconds[r]));
  messages.detail(imbalance_text(seconds));
  return {};
}

// Returns whether another option or operand may name the file of the report.
bool names_report_twice(const ConvertFlags& flags) {
  for (const Option* option : flags.options()) {
    if (option == &flags.report || !option->takes_value()) continue;
    for (const std::string& text : option->texts()) {
      if (files::is_same_output(*flags.report, text)) return true;
    }
  }
  return false;
}

Result<void> run_convert(const ConvertFlags& flags, const std::vector<std::string>& arguments) {
  const auto plan = attempt([&] { return plan_convert(flags); });
  const Messages messages(plan ? plan->shown : MessageChoice());
  if (!plan && is_later_rank()) return tl::unexpected(plan.error());
  if (!plan) {
    const auto reported = attempt([&] { return report_no_plan(flags, arguments, plan.error()); });
    if (!reported) messages.error(reported.error());
    return tl::unexpected(plan.error());
  }
  TRY(agree(ranks_of_run() != nullptr ? convert::hash_of(plan->job) : std::string()));
  if (plan->make_folders) {
    std::vector<std::filesystem::path> files;
    for (const convert::OutputFileJob& output : plan->job.outputs) files.emplace_back(output.path);
    TRY(check_or_make_folders(files, true));
  }
  for (const auto& page : {plan->report, plan->pages.html, plan->pages.contact_sheet}) {
    if (!page) continue;
    TRY(check_report_file(*page, plan->job, plan->context));
  }
  for (const Note& text : plan->notes) messages.note(text);
  const double waited = seconds_waited();
  Converted converted = convert_as_planned(*plan, messages);
  convert::Outcome& outcome = converted.outcome;
  outcome.notes.insert(outcome.notes.begin(), plan->notes.begin(), plan->notes.end());
  if (const auto note = note_of_ranks(plan->threads); note && outcome.done()) {
    messages.note(*note);
    outcome.notes.push_back(*note);
  }
  if (outcome.done()) {
    TRY(tell_rank_times(outcome.total.wall_seconds - (seconds_waited() - waited), messages));
  }
  if (is_later_rank()) return outcome.error ? tl::unexpected(*outcome.error) : Result<void>();
  if (outcome.done()) messages.detail(fmt::format("peak memory {}", format_byte_size(outcome.peak_memory)));
  Result<void> done = outcome.error ? tl::unexpected(*outcome.error) : Result<void>();
  if (done && plan->pages.any()) {
    done = attempt([&] {
      HtmlPage page;
      page.add(converted.rows.front().frame, outcome);
      return write_pages(plan->pages, converted.rows, page, plan->job.source.placement.up, arguments, plan->context);
    });
  }
  if (!plan->report) return done;
  auto reported = attempt(
      [&] { return write_report(*plan->report, &plan->job, outcome, {}, arguments, plan->context.memory().limit()); });
  if (done) return reported;
  if (!reported) messages.error(reported.error());
  return done;
}

class ConvertCommand final : public CommandOf<ConvertFlags> {
 public:
  ConvertCommand()
      : CommandOf({"convert", "INPUT... --iso V [-o FILE] [options]",
                   "Extract surfaces and write them as meshes (default)."}) {}

  [[nodiscard]] Result<void> check_words() const override { return refuse_output_among_inputs(flags()); }

  [[nodiscard]] bool shares_work() const override { return true; }

  Result<int> run(const std::vector<std::string>& arguments) override {
    if (!flags().config) return run_configured(arguments);
    const auto configured = with_config(*this, arguments);
    if (configured) return run_configured(*configured);
    report_failure(arguments, configured.error());
    return tl::unexpected(configured.error());
  }

  // Writes the requested report, unless another word may name the same file. Prints an error if writing fails.
  void report_failure(const std::vector<std::string>& arguments, const Error& error) override {
    forget();
    read_words_leniently(*this, arguments_after_command(*this, arguments));
    const auto reported = attempt([&]() -> Result<void> {
      if (flags().report && names_report_twice(flags())) return {};
      return report_no_plan(flags(), arguments, error);
    });
    if (!reported) Messages({}).error(reported.error());
  }

 private:
  Result<int> run_configured(const std::vector<std::string>& arguments) {
    apply_in_process(flags().input);
    if (!flags().batch.any_set() && !flags().heightfield && !flags().masks) name_volume_of_files(flags().input.inputs);
    auto done = is_batch(flags()) ? run_batch(flags(), arguments) : run_convert(flags(), arguments);
    if (!done && exit_code_of(done.error().code) == exit_code_of(ErrorCode::usage) && flags().config) {
      done.error().message += fmt::format(" (some options come from {})", printable(*flags().config));
    }
    TRY(std::move(done));
    return kDone;
  }
};

}  // namespace

std::unique_ptr<Command> make_convert_command() { return std::make_unique<ConvertCommand>(); }

}  // namespace isoextract::cli
