#include "cli/batch_command.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "base/counted.hpp"
#include "base/printable.hpp"
#include "batch/batch_run.hpp"
#include "batch/existing_files.hpp"
#include "batch/frame_range.hpp"
#include "batch/frame_table.hpp"
#include "cli/batch_dry_run.hpp"
#include "cli/batch_files.hpp"
#include "cli/batch_plan.hpp"
#include "cli/batch_progress.hpp"
#include "cli/frame_plot.hpp"
#include "cli/gnuplot.hpp"
#include "cli/html_page.hpp"
#include "cli/iso_of_labels_note.hpp"
#include "cli/messages.hpp"
#include "cli/pages_plan.hpp"
#include "cli/rank_run.hpp"
#include "cli/report_file.hpp"
#include "cli/sequence_values.hpp"
#include "cli/threads.hpp"
#include "cli/up_axis_note.hpp"
#include "convert/json_values.hpp"
#include "files/input_file_set.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

namespace fs = std::filesystem;

// Returns the error's message without the names of the frame's files.
std::string reason_of(const convert::ConversionJob& job, const Error& error) {
  std::string text = error.message;
  const auto leave_out = [&](const std::string& name) {
    for (std::size_t at = text.find(name); !name.empty() && at != std::string::npos; at = text.find(name, at)) {
      text.replace(at, name.size(), "*");
      ++at;
    }
  };
  leave_out(job.source.input);
  for (const fs::path& file : batch::files_of(job)) {
    leave_out(file.string());
    const std::size_t end = std::min(text.find(": "), text.size());
    if (batch::match_output_name(std::string_view(text).substr(0, end), file.string())) text.replace(0, end, "*");
  }
  return text.starts_with("*: ") ? text.substr(3) : text;
}

bool shows_rows(const BatchPlan& plan) { return plan.flags.table || plan.flags.plot || plan.common.pages.any(); }

// Prints what happens to the frames, and writes their reports.
class FramePrinter final : public batch::RunEvents {
 public:
  FramePrinter(const BatchPlan& plan, const std::vector<std::string>& arguments, BatchProgress& progress,
               HtmlPage& page)
      : plan_(plan), arguments_(arguments), progress_(progress), page_(page) {}

  Notes field_notes(const field::ScalarField& field) override {
    Notes notes;
    // The frames differ in input, output and iso values only.
    if (const auto note = iso_of_labels_note(field, plan_.batch.frames.front().job)) notes.push_back(*note);
    if (plan_.common.on_side_text) {
      const auto note = up_axis_note(field, plan_.common.job.source.placement.up, *plan_.common.on_side_text);
      if (note) notes.push_back(*note);
    }
    for (const Note& note : notes) progress_.print_note_once(note);
    return notes;
  }

  void notes_of_rank(const Notes& notes) override {
    for (const Note& note : notes) progress_.print_note_once(note);
  }

  bool has_report(std::size_t frame) override { return plan_.reports.empty() || files::is_there(plan_.reports[frame]); }

  Result<void> write_report(std::size_t frame, const convert::Outcome& outcome) override {
    if (plan_.reports.empty()) return {};
    const std::string& path = plan_.reports[frame];
    const convert::ConversionJob& job = plan_.batch.frames[frame].job;
    TRY(check_report_file(path, job, plan_.common.context));
    return cli::write_report(path, &job, outcome, plan_.frame_notes, arguments_, plan_.common.context.memory().limit());
  }

  void over(std::size_t frame, const batch::FrameRow& row, convert::Outcome* outcome, const Error* error) override {
    for (const std::string& name : row.figures.lacked_attributes) {
      progress_.add_remark(
          row.frame, {NoteId::attribute_missing, fmt::format("lack the optional attribute '{}'", printable(name))});
    }
    if (outcome != nullptr) tell(plan_.batch.frames[frame].job, row, *outcome, error);
    progress_.over(row);
  }

 private:
  void tell(const convert::ConversionJob& job, const batch::FrameRow& row, const convert::Outcome& outcome,
            const Error* error) {
    if (outcome.empty_picture)
      progress_.add_remark(
          row.frame, {NoteId::empty_picture, "have an empty picture, because the camera sees nothing of the surfaces"});
    if (plan_.common.pages.html) {
      const std::lock_guard lock(mutex_);
      page_.add(row.frame, outcome);
    }
    if (error != nullptr) {
      if (error->code != ErrorCode::cancelled) progress_.failed(row, *error, reason_of(job, *error));
      return;
    }
    for (const Note& note : outcome.notes) progress_.detail(fmt::format("frame {}: {}", row.frame, note.text));
    progress_.detail(fmt::format("frame {}: {}: {:.2f} s, {}", row.frame, printable(row.input),
                                 row.figures.wall_seconds, format_byte_size(row.figures.bytes)));
  }

  const BatchPlan& plan_;
  const std::vector<std::string>& arguments_;
  BatchProgress& progress_;
  std::mutex mutex_;  // guards page_
  HtmlPage& page_;
};

Result<void> write_tables(const BatchPlan& plan, const std::vector<batch::FrameRow>& rows) {
  if (plan.flags.table) {
    const bool is_json = fs::path(*plan.flags.table).extension() == ".json";
    const std::string text = is_json ? convert::json_text(batch::table_json(rows)) : batch::table_csv(rows);
    TRY(files::write_file(*plan.flags.table, text));
  }
  if (!plan.flags.plot) return {};
  const auto picture = TRY(run_gnuplot(frame_plot_script(rows, plan.plot_format)));
  return files::write_file(*plan.flags.plot, picture);
}

std::uint64_t count_of(std::span<const batch::FrameRun> runs) {
  std::uint64_t count = 0;
  for (const batch::FrameRun& run : runs) count += run.count();
  return count;
}

std::string missing_text(std::span<const batch::FrameRun> gaps) {
  const std::uint64_t count = count_of(gaps);
  return fmt::format("{} requested frame{} no input: {}", count, count == 1 ? " has" : "s have",
                     batch::text_of(gaps, batch::kShownFrameRuns));
}

tl::unexpected<Error> fail_missing(std::span<const batch::FrameRun> gaps) {
  return fail(ErrorCode::frames, missing_text(gaps), "--missing note turns this error into a note");
}

void tell_animation(const batch::AnimationJob& animation, const mesh_io::MeshWriteResult& written,
                    const Messages& messages) {
  for (const mesh_io::WrittenFile& file : written.files) {
    messages.summary(fmt::format("{}: {} per second, {}", printable(file.path),
                                 counted(animation.frames_per_second, "frame"), format_byte_size(file.bytes)));
  }
  for (const Note& note : written.notes) messages.note(note);
}

// Returns why rank 0 must convert all frames; empty if the ranks can share them.
std::string reason_to_convert_alone(const BatchPlan& plan) {
  if (plan.batch.animation) return "--animate writes one file";
  if (plan.common.pages.html) return "the page of --html describes how one process converted the frames";
  return {};
}

Note note_of_ranks(const std::string& alone, const std::optional<int>& threads) {
  std::string text = fmt::format("{} share the frames", ranks_text());
  if (!alone.empty()) text = fmt::format("{}: rank 0 converts all frames, because {}", ranks_text(), alone);
  return {NoteId::shard, text + threads_text(threads)};
}

Result<void> run_planned(const ConvertFlags& flags, BatchPlan& plan, const std::vector<std::string>& arguments,
                         const Messages& messages) {
  const std::string alone = reason_to_convert_alone(plan);
  if (is_later_rank() && (plan.flags.dry_run || !alone.empty())) return {};
  if (plan.flags.dry_run) {
    TRY(limit_threads(plan.common.threads));
    TRY(find_sequence_values(flags, plan, messages));
    return print_batch_plan(plan, messages);
  }
  if (plan.flags.fail_fast && plan.missing_is_error && !plan.gaps.empty()) return fail_missing(plan.gaps);
  if (plan.flags.plot || (plan.common.pages.html && plan.frames.size() > 1)) {
    TRY(check_gnuplot(plan.flags.plot ? plan.flags.plot.name() : ConvertFlags().html.name()));
  }
  TRY(limit_threads(plan.common.threads));
  TRY(make_folders(plan));
  const auto read = TRY(check_batch_files(plan));
  TRY(find_sequence_values(flags, plan, messages));
  const Context& context = plan.common.context;
  batch::RunOptions options{.shard = plan.shard, .resume_policy = plan.resume_policy, .arguments = arguments};
  if (plan.missing_is_error) options.absent = batch::text_of(plan.gaps);
  if (alone.empty()) options.ranks = ranks_of_run();
  options.keeps_figures = shows_rows(plan);
  options.scheduler = {.jobs = plan.jobs,
                       .threads = plan.threads,
                       .fail_fast = plan.flags.fail_fast,
                       .extras = {.mesh_facts = plan.measures_meshes(),
                                  .volume_hint = std::string(kHowToKeepVolumes),
                                  .read = read ? &*read : nullptr}};
  auto run = TRY(batch::BatchRun::open(plan.batch, std::move(options), context));
  const auto tell = [&](const Note& note) {
    if (plan.progress != ProgressStyle::json) messages.note(note);
  };
  if (ranks_of_run() != nullptr) tell(note_of_ranks(alone, plan.common.threads));
  for (const Note& note : plan.common.notes) tell(note);
  if (!plan.gaps.empty())
    tell({NoteId::missing_frames,
          fmt::format("the inputs lack the frames {}", batch::text_of(plan.gaps, batch::kShownFrameRuns))});

  BatchProgress progress(plan.progress, messages, plan.frames.size());
  HtmlPage page;
  FramePrinter teller(plan, arguments, progress, page);
  const batch::RunResult result = run.run(teller);
  if (is_later_rank()) return result.error ? tl::unexpected(*result.error) : Result<void>();
  using Status = batch::FrameStatus;
  const std::size_t failed = result.count(Status::failed);
  const std::size_t cancelled = result.count(Status::cancelled);
  const std::size_t not_started = result.count(Status::not_started);
  const std::uint64_t missing = plan.missing_is_error ? count_of(plan.gaps) : 0;
  progress.end({.done = result.count(Status::done) + result.count(Status::empty),
                .failed = failed,
                .cancelled = cancelled,
                .kept = result.count(Status::kept),
                .not_started = not_started,
                .missing = missing},
               result.ranks);
  if (const auto& old = result.set_aside; !old.empty()) {
    tell({NoteId::old_pieces, fmt::format("this run renamed {} to {}{}",
                                          old.size() == 1 ? "the old mesh of a failed frame"
                                                          : fmt::format("{} old meshes of failed frames", old.size()),
                                          old.front(), old.size() == 1 ? "" : fmt::format(" through {}", old.back()))});
  }
  if (plan.batch.animation && plan.progress != ProgressStyle::json) {
    tell_animation(*plan.batch.animation, result.animation, messages);
  }
  if (plan.flags.table || plan.flags.plot || plan.common.pages.html) {
    if (const std::string note = units_note(result.rows); !note.empty()) tell({NoteId::length_unit, note});
  }
  if (plan.flags.table || plan.flags.plot) {
    TRY(write_tables(plan, result.rows));
  }
  if (plan.common.pages.any()) {
    auto written =
        write_pages(plan.common.pages, result.rows, page, plan.common.job.source.placement.up, arguments, context);
    if (!written) return written;
  }
  if (result.error) return tl::unexpected(*result.error);
  if (failed + cancelled + not_started == 0) return missing == 0 ? Result<void>() : fail_missing(plan.gaps);
  std::string text = fmt::format("{} of {} failed", failed, counted(plan.frames.size(), "frame"));
  if (cancelled > 0) text += fmt::format(", {} cancelled", cancelled);
  if (not_started > 0) text += fmt::format(", {} not started", not_started);
  if (missing > 0) text += fmt::format("; {}", missing_text(plan.gaps));
  return fail(ErrorCode::frames, text,
              "fix the cause, then run again with --resume to convert only the unfinished frames");
}

}  // namespace

Result<void> run_batch(const ConvertFlags& flags, const std::vector<std::string>& arguments) {
  auto plan = plan_batch(flags, [](const char* name) -> const char* { return std::getenv(name); });
  if (!plan) return tl::unexpected(plan.error());
  TRY(agree(ranks_of_run() != nullptr ? batch::hash_of(plan->batch) : std::string()));
  return run_planned(flags, *plan, arguments, Messages(plan->common.shown));
}

}  // namespace isoextract::cli
