#include "cli/batch_command.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <optional>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "base/byte_size.hpp"
#include "base/printable.hpp"
#include "batch/animation.hpp"
#include "batch/frame_range.hpp"
#include "batch/frame_table.hpp"
#include "batch/manifest.hpp"
#include "batch/output_names.hpp"
#include "batch/scheduler.hpp"
#include "cli/batch_dry_run.hpp"
#include "cli/batch_files.hpp"
#include "cli/batch_plan.hpp"
#include "cli/batch_progress.hpp"
#include "cli/convert_command.hpp"
#include "cli/frame_plot.hpp"
#include "cli/gnuplot.hpp"
#include "cli/html_page.hpp"
#include "cli/messages.hpp"
#include "cli/output_folders.hpp"
#include "cli/output_plan.hpp"
#include "cli/pages_plan.hpp"
#include "cli/report_file.hpp"
#include "cli/threads.hpp"
#include "cli/up_axis_note.hpp"
#include "convert/output_checks.hpp"
#include "files/output_file.hpp"
#include "files/read_files.hpp"

namespace isoextract::cli {
namespace {

namespace fs = std::filesystem;

// The message without the names of the frame's files.
std::string reason_of(const convert::ConversionJob& job, const Error& error) {
  std::string text = error.message;
  const auto leave_out = [&](const std::string& name) {
    for (std::size_t at = text.find(name); !name.empty() && at != std::string::npos; at = text.find(name, at)) {
      text.replace(at, name.size(), "*");
      ++at;
    }
  };
  leave_out(job.source.input);
  for (const fs::path& file : files_of(job)) leave_out(file.string());
  return text;
}

bool keeps_rows(const BatchPlan& plan) { return plan.flags.table || plan.flags.plot || plan.common.pages.any(); }

std::string report_path_of(const BatchPlan& plan, const batch::FrameJob& frame) {
  const convert::SourceOptions& source = frame.job.source;
  return report_path(*plan.report,
                     {frame.number, source.input, source.read.grid.value_or(""), frame.job.isos(), false});
}

// What a batch keeps of its frames while they run, side by side.
class FrameKeeper final : public batch::FrameEvents {
 public:
  // `animation` takes the frames, where they have no files of their own. `read` is what all frames read, null where no
  // file that would be written was there before.
  FrameKeeper(const BatchPlan& plan, const std::vector<std::string>& arguments, batch::Manifest& manifest,
              const batch::Animation* animation, const files::ReadFiles* read, BatchProgress& progress, HtmlPage& page)
      : plan_(plan),
        arguments_(arguments),
        manifest_(manifest),
        animation_(animation),
        read_(read),
        progress_(progress),
        page_(page),
        rows_(plan.batch.frames.size()),
        inputs_(plan.batch.frames.size()),
        records_(plan.batch.frames.size()),
        missing_(plan.batch.frames.size()) {
    for (const std::size_t i : plan.frames) {
      rows_[i].frame = plan.batch.frames[i].number;
      rows_[i].input = plan.batch.frames[i].job.source.input;
    }
  }

  // A frame that is left alone because it is done. Before the run.
  void keep(std::size_t frame, const batch::FrameRecord* record) {
    batch::FrameRow& row = rows_[frame];
    row.status = batch::FrameStatus::kept;
    if (record != nullptr) {
      row.figures = record->figures;
      remark_lacking(row);
      for (const batch::FileRecord& file : record->outputs) row.outputs.push_back(file.path);
    }
    progress_.over(row);
  }

  void started(std::size_t frame) override {
    auto states = batch::input_states(plan_.batch.frames[frame]);
    // One that cannot be read fails when it is converted, with a better message.
    if (states) inputs_[frame] = std::move(*states);
    const std::string job = convert::hash_of(plan_.batch.frames[frame].job);
    const std::lock_guard lock(mutex_);
    if (auto begun = manifest_.begin(job); !begun) unkept_ = begun.error();
  }

  bool finished(std::size_t frame, const convert::Outcome& outcome) override {
    const batch::FrameJob& job = plan_.batch.frames[frame];
    batch::FrameRow& row = rows_[frame];
    std::optional<Error> error = outcome.error;
    if (plan_.report) {
      if (auto reported = report(job, outcome); !reported && !error) error = reported.error();
    }
    missing_[frame] = outcome.done() ? 0 : 1;
    bool kept = true;
    if (!error) error = record(frame, outcome, kept);
    {
      auto lost = animation_ != nullptr ? animation_->lost() : std::nullopt;
      const std::lock_guard lock(mutex_);
      if (lost) unkept_ = std::move(lost);
      kept = kept && !unkept_;
    }
    row.figures = batch::figures_of(outcome);
    remark_lacking(row);
    if (outcome.empty_picture) progress_.remark(job.number, "in whose picture the camera sees nothing of the surfaces");
    for (const mesh_io::WrittenFile& file : outcome.files) row.outputs.push_back(file.path);
    const bool was_cancelled = error && error->code == ErrorCode::cancelled;
    row.status = was_cancelled ? batch::FrameStatus::cancelled
                 : error       ? batch::FrameStatus::failed
                               : done_or_empty(outcome, row.figures);
    if (plan_.common.pages.html) {
      const std::lock_guard lock(mutex_);
      page_.add(job.number, outcome);
    }
    if (error && !was_cancelled) {
      row.error = printable(error->message);
      progress_.failed(job.number, *error, reason_of(job.job, *error));
      if (!outcome.done()) row.error += set_aside(job.job, outcome);
    } else if (!error) {
      for (const std::string& note : outcome.notes) progress_.detail(fmt::format("frame {}: {}", job.number, note));
      progress_.detail(fmt::format("frame {}: {}: {:.2f} s, {}", job.number, printable(job.job.source.input),
                                   row.figures.wall_seconds, format_byte_size(row.figures.bytes)));
    }
    progress_.over(row);
    // Nobody asks for the rest of it: a run of many frames takes no memory for each.
    if (!keeps_rows(plan_)) row = {row.frame, row.input, row.status, {}, {}, {}};
    return kept;
  }

  // Of this run's frames, in their order.
  [[nodiscard]] std::vector<batch::FrameRow> rows() const {
    std::vector<batch::FrameRow> rows;
    for (const std::size_t i : plan_.frames) rows.push_back(rows_[i]);
    return rows;
  }

  [[nodiscard]] std::size_t count(batch::FrameStatus status) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(plan_.frames, [&](std::size_t i) { return rows_[i].status == status; }));
  }

  // Of an animation that is written: the records of its frames, all of which are done, and where they are.
  [[nodiscard]] std::vector<batch::FrameRecord> take_records() { return std::move(records_); }
  void written_to(const std::vector<mesh_io::WrittenFile>& files) {
    for (batch::FrameRow& row : rows_) {
      if (row.status != batch::FrameStatus::done) continue;
      for (const mesh_io::WrittenFile& file : files) row.outputs.push_back(file.path);
    }
  }

  // The numbers of frames that were not converted. A frame whose report could not be written has failed as well.
  [[nodiscard]] std::vector<std::int64_t> missing() const {
    std::vector<std::int64_t> numbers;
    for (const std::size_t i : plan_.frames) {
      if (missing_[i] != 0) numbers.push_back(plan_.batch.frames[i].number);
    }
    return numbers;
  }

  // The names that meshes of earlier runs have now, of frames that failed.
  [[nodiscard]] const std::vector<std::string>& set_aside() const { return set_aside_; }

  // Why the manifest or the animation could not be written, which ends the batch.
  [[nodiscard]] const std::optional<Error>& unkept() const { return unkept_; }

 private:
  [[nodiscard]] batch::FrameStatus done_or_empty(const convert::Outcome& outcome,
                                                 const batch::FrameFigures& figures) const {
    const bool nothing = animation_ == nullptr && figures.surfaces.empty() && outcome.files.empty();
    return nothing || batch::is_empty(figures) ? batch::FrameStatus::empty : batch::FrameStatus::done;
  }

  void remark_lacking(const batch::FrameRow& row) {
    for (const std::string& name : row.figures.lacked_attributes) {
      progress_.remark(row.frame, fmt::format("without the optional attribute '{}'", printable(name)));
    }
  }

  // A mesh of an earlier run must not pass for that of a frame that has failed. What there is to say of it.
  std::string set_aside(const convert::ConversionJob& job, const convert::Outcome& outcome) {
    if (animation_ != nullptr || read_ == nullptr) return {};
    std::string text;
    for (const convert::OutputFileJob& output : job.outputs) {
      const auto names =
          convert::set_aside_old_meshes(output, job.format, *read_, outcome.files, Context(plan_.common.memory));
      if (!names) {
        text += fmt::format("; {}", names.error().message);
        continue;
      }
      for (const std::string& name : *names) text += fmt::format("; the old mesh is now {}", printable(name));
      const std::lock_guard lock(mutex_);
      set_aside_.insert(set_aside_.end(), names->begin(), names->end());
    }
    return text;
  }

  // Where the manifest cannot be written, `kept` becomes false.
  std::optional<Error> record(std::size_t frame, const convert::Outcome& outcome, bool& kept) {
    auto made = batch::record_of(plan_.batch.frames[frame], std::move(inputs_[frame]), outcome);
    if (!made) return made.error();
    if (animation_ != nullptr) {
      records_[frame] = std::move(*made);
      return std::nullopt;
    }
    const std::lock_guard lock(mutex_);
    if (auto added = manifest_.add(*made); !added) {
      unkept_ = added.error();
      kept = false;
      return added.error();
    }
    return std::nullopt;
  }

  Result<void> report(const batch::FrameJob& frame, const convert::Outcome& outcome) const {
    const std::string path = report_path_of(plan_, frame);
    TRY(check_report_file(path, frame.job));
    return write_report(path, &frame.job, outcome, arguments_, plan_.common.memory.limit());
  }

  const BatchPlan& plan_;
  const std::vector<std::string>& arguments_;
  batch::Manifest& manifest_;
  const batch::Animation* animation_;
  const files::ReadFiles* read_;
  BatchProgress& progress_;
  HtmlPage& page_;
  std::vector<batch::FrameRow> rows_;  // by frame; each is touched by the thread that converts it
  std::vector<std::vector<batch::FileRecord>> inputs_;
  std::vector<batch::FrameRecord> records_;  // of an animation, until it is written
  std::vector<char> missing_;                // 1: not converted
  std::mutex mutex_;                         // of the manifest, the page, and all that follows
  std::vector<std::string> set_aside_;
  std::optional<Error> unkept_;
};

Result<void> write_tables(const BatchPlan& plan, const std::vector<batch::FrameRow>& rows) {
  if (plan.flags.table) {
    const bool is_json = fs::path(*plan.flags.table).extension() == ".json";
    const std::string text = is_json ? convert::json_text(batch::table_json(rows)) : batch::table_csv(rows);
    TRY(files::write_file(*plan.flags.table, text));
  }
  if (!plan.flags.plot) return {};
  const auto picture = TRY(run_gnuplot(frame_plot_script(rows, plan.picture)));
  return files::write_file(*plan.flags.plot, picture);
}

std::uint64_t count_of(std::span<const batch::FrameRun> runs) {
  std::uint64_t count = 0;
  for (const batch::FrameRun& run : runs) count += run.count();
  return count;
}

std::string missing_text(std::span<const batch::FrameRun> gaps) {
  const std::uint64_t count = count_of(gaps);
  return fmt::format("{} frame{} not there: {}", count, count == 1 ? " is" : "s are",
                     batch::text_of(gaps, batch::kShownFrameRuns));
}

tl::unexpected<Error> fail_missing(std::span<const batch::FrameRun> gaps) {
  return fail(ErrorCode::frames, missing_text(gaps), "--missing note makes this no error");
}

// Tells the keeper of the frames that are done already, and returns the others.
std::vector<std::size_t> keep_what_is_done(const BatchPlan& plan, const batch::Manifest& manifest,
                                           FrameKeeper& keeper) {
  const bool as_one = plan.batch.animation.has_value();
  std::optional<std::vector<batch::FrameRecord>> all;
  if (as_one && plan.flags.resume) all = batch::kept_animation(manifest, plan.batch);
  const auto lacks_report = [&](std::size_t i) { return !is_there(report_path_of(plan, plan.batch.frames[i])); };
  if (plan.report && std::ranges::any_of(plan.frames, lacks_report)) all.reset();
  std::vector<std::size_t> which;
  for (const std::size_t i : plan.frames) {
    const batch::FrameJob& frame = plan.batch.frames[i];
    const batch::FrameRecord* record = all ? &(*all)[i] : nullptr;
    if (!as_one && plan.flags.resume) record = manifest.find(convert::hash_of(frame.job));
    // What a report says is not kept: a frame without one is done again.
    const bool has_report = !plan.report || is_there(report_path_of(plan, frame));
    const bool is_done = plan.flags.no_clobber
                             ? std::ranges::any_of(files_of(frame.job), is_there)
                             : record != nullptr && has_report && (as_one || batch::why_again(*record, frame).empty());
    if (is_done) {
      keeper.keep(i, record);
    } else {
      which.push_back(i);
    }
  }
  return which;
}

// Gives the animation its name, unless the batch has failed as a whole.
Result<mesh_io::MeshWriteResult> finish_animation(const BatchPlan& plan, batch::Animation& animation,
                                                  batch::Manifest& manifest, FrameKeeper& keeper) {
  const std::string& path = plan.batch.animation->path;
  const std::size_t failed = keeper.count(batch::FrameStatus::failed);
  const std::vector<std::int64_t> missing = keeper.missing();
  if (missing.size() == plan.frames.size() || keeper.count(batch::FrameStatus::not_started) > 0 ||
      keeper.count(batch::FrameStatus::cancelled) > 0 || (plan.flags.fail_fast && failed > 0)) {
    return mesh_io::MeshWriteResult{{}, {fmt::format("{} was not written", path)}};
  }
  auto written = animation.finish();
  if (!written) return written;
  keeper.written_to(written->files);
  if (!missing.empty()) written->notes.push_back(batch::left_out_text(plan.batch, missing));
  if (failed > 0) return written;
  auto kept = batch::keep_animation(manifest, plan.batch, keeper.take_records(), *written);
  return kept ? std::move(written) : tl::unexpected(kept.error());
}

void tell_animation(const batch::AnimationJob& animation, const mesh_io::MeshWriteResult& written,
                    const Messages& messages) {
  for (const mesh_io::WrittenFile& file : written.files) {
    messages.summary(fmt::format("{}: {} frames per second, {}", printable(file.path), animation.frames_per_second,
                                 format_byte_size(file.bytes)));
  }
  for (const std::string& note : written.notes) messages.note(note);
}

Result<void> run_planned(const BatchPlan& plan, const std::vector<std::string>& arguments, const Messages& messages) {
  if (plan.flags.dry_run) return print_batch_plan(plan, messages);
  if (plan.flags.fail_fast && plan.needs_all && !plan.gaps.empty()) return fail_missing(plan.gaps);
  if (plan.flags.plot || (plan.common.pages.html && plan.frames.size() > 1)) {
    TRY(check_gnuplot(plan.flags.plot ? plan.flags.plot.name() : ConvertFlags().html.name()));
  }
  TRY(limit_threads(plan.common.threads));
  TRY(make_folders(plan));
  const auto read = TRY(check_batch_files(plan));
  const Context context{plan.common.memory};
  std::optional<batch::Animation> animation;
  if (plan.batch.animation) {
    animation.emplace(plan.batch, context);
    TRY(animation->check());
  }
  std::unordered_set<std::string> jobs;
  for (const std::size_t i : plan.frames) jobs.insert(convert::hash_of(plan.batch.frames[i].job));
  batch::ManifestHeader header = batch::header_of(plan.batch, plan.shard, arguments);
  if (plan.needs_all) header.absent = batch::text_of(plan.gaps);
  auto manifest = TRY(batch::Manifest::open(plan.folder, header, plan.flags.resume, jobs));
  const auto tell = [&](const std::string& note) {
    if (plan.progress != ProgressStyle::json) messages.note(note);
  };
  for (const std::string& note : plan.common.notes) tell(note);
  if (!plan.gaps.empty())
    tell(fmt::format("frames that are not there: {}", batch::text_of(plan.gaps, batch::kShownFrameRuns)));

  BatchProgress progress(plan.progress, messages, plan.frames.size());
  HtmlPage page;
  FrameKeeper keeper(plan, arguments, manifest, animation ? &*animation : nullptr, read ? &*read : nullptr, progress,
                     page);
  const std::vector<std::size_t> which = keep_what_is_done(plan, manifest, keeper);
  const std::size_t kept = plan.frames.size() - which.size();
  const auto note_of_field = [&](const field::ScalarField& field) -> std::optional<std::string> {
    if (!plan.common.if_on_side) return std::nullopt;
    auto note = up_axis_note(field, plan.common.job.source.placement.up, *plan.common.if_on_side);
    if (note) progress.note_once(*note);
    return note;
  };
  const batch::SchedulerOptions options{
      .jobs = plan.jobs,
      .threads = plan.common.threads.value_or(tbb::this_task_arena::max_concurrency()),
      .fail_fast = plan.flags.fail_fast,
      .extras = {.mesh_facts = plan.flags.table || plan.flags.plot || plan.report || plan.common.pages.html,
                 .note_of_field = note_of_field,
                 .how_to_keep_volumes = std::string(kHowToKeepVolumes),
                 .read = read ? &*read : nullptr}};
  const batch::BatchCounts counts =
      batch::run(plan.batch, which, options, context, keeper, animation ? &*animation : nullptr);
  std::optional<Error> unkept = keeper.unkept();
  mesh_io::MeshWriteResult animated;
  if (animation && which.empty()) {
    animated.notes.push_back(fmt::format("{} is left as it is", plan.batch.animation->path));
  } else if (animation && !unkept) {
    auto finished = finish_animation(plan, *animation, manifest, keeper);
    if (!finished) unkept = finished.error();
    if (finished) animated = std::move(*finished);
  }
  const std::size_t failed = keeper.count(batch::FrameStatus::failed);
  const std::uint64_t missing = plan.needs_all ? count_of(plan.gaps) : 0;
  const std::size_t cancelled = keeper.count(batch::FrameStatus::cancelled);
  progress.end({.done = keeper.count(batch::FrameStatus::done) + keeper.count(batch::FrameStatus::empty),
                .failed = failed,
                .cancelled = cancelled,
                .kept = kept,
                .not_started = counts.not_started,
                .missing = missing});
  if (const auto& old = keeper.set_aside(); !old.empty()) {
    tell(fmt::format("{} of an earlier run, of frames that failed, {} renamed: {}{}",
                     old.size() == 1 ? "a mesh" : fmt::format("{} meshes", old.size()),
                     old.size() == 1 ? "was" : "were", old.front(),
                     old.size() == 1 ? "" : fmt::format(" to {}", old.back())));
  }
  if (animation && plan.progress != ProgressStyle::json) tell_animation(*plan.batch.animation, animated, messages);
  if (plan.flags.table || plan.flags.plot || plan.common.pages.html) {
    if (const std::string note = note_of_units(keeper.rows()); !note.empty()) tell(note);
  }
  if (plan.flags.table || plan.flags.plot) {
    TRY(write_tables(plan, keeper.rows()));
  }
  if (plan.common.pages.any()) {
    auto written =
        write_pages(plan.common.pages, keeper.rows(), page, plan.common.job.source.placement.up, arguments, context);
    if (!written) return written;
  }
  if (unkept) return tl::unexpected(*unkept);
  if (failed + cancelled + counts.not_started == 0) return missing == 0 ? Result<void>() : fail_missing(plan.gaps);
  std::string text = fmt::format("{} of {} frames failed", failed, plan.frames.size());
  if (cancelled > 0) text += fmt::format(", {} {} cancelled", cancelled, cancelled == 1 ? "was" : "were");
  if (counts.not_started > 0) text += fmt::format(", and {} were not started", counts.not_started);
  if (missing > 0) text += fmt::format("; {}", missing_text(plan.gaps));
  return fail(ErrorCode::frames, text, "--resume does what is not done yet, once that is mended");
}

}  // namespace

Result<void> run_batch(const ConvertFlags& flags, const std::vector<std::string>& arguments) {
  const auto plan = TRY(plan_batch(flags, [](const char* name) -> const char* { return std::getenv(name); }));
  return run_planned(plan, arguments, Messages(plan.common.verbosity));
}

}  // namespace isoextract::cli
