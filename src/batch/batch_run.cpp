#include "batch/batch_run.hpp"

#include <algorithm>
#include <iterator>
#include <mutex>
#include <system_error>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>

#include "base/packed_values.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "batch/detail/animation.hpp"
#include "batch/detail/frame_sharing.hpp"
#include "batch/existing_files.hpp"
#include "batch/manifest.hpp"
#include "batch/merge_shards.hpp"
#include "convert/mesh_pieces.hpp"
#include "convert/output_checks.hpp"
#include "files/output_file.hpp"
#include "mesh_io/mesh_reader.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;

files::InputFileSet read_files_of(const BatchJob& batch, const OtherFiles& others, const Context& context) {
  files::InputFileSet read;
  for (const NamedFile& file : others.read) read.add(file.path, file.what);
  const convert::SourceOptions* before = nullptr;
  for (const FrameJob& frame : batch.frames) {
    const convert::SourceOptions& source = frame.job.source;
    // Frames that are volumes of one file read the same files.
    const bool is_known = before != nullptr && before->input == source.input && before->attributes == source.attributes;
    if (!is_known) convert::add_read_files(read, frame.job, context);
    before = &source;
  }
  return read;
}

}  // namespace

// Listens to the converting threads, and holds the results so far.
struct BatchRun::State final : FrameEvents {
  State(const BatchJob& the_batch, RunOptions the_options, const Context& the_context,
        std::optional<Manifest> the_manifest)
      : batch(the_batch),
        options(std::move(the_options)),
        context(the_context),
        frames(frames_of(batch, options.shard)),
        manifest(std::move(the_manifest)),
        rows(batch.frames.size()),
        inputs(batch.frames.size()),
        records(batch.animation ? batch.frames.size() : 0),
        is_missing(batch.frames.size()) {
    for (const std::size_t i : frames) {
      rows[i].frame = batch.frames[i].number;
      rows[i].input = batch.frames[i].job.source.input;
    }
  }

  RunResult run(RunEvents& events);

  convert::Events* started(std::size_t frame, const Context& own) override;
  bool finished(std::size_t frame, convert::Outcome& outcome) override;

  // Converts the frames, on all ranks.
  void convert_frames(std::span<const std::size_t> others);
  // Converts frames that rank 0 hands out.
  [[nodiscard]] RunResult run_for_first_rank();
  [[nodiscard]] bool begin_on_manifest(std::size_t frame);
  // Writes the report, and makes the row and the record.
  [[nodiscard]] FinishedFrame complete(std::size_t frame, const convert::Outcome& outcome);
  // Takes a frame of this rank or of another into the manifest and the result. Returns false if the batch ends.
  bool accept(FinishedFrame finished, convert::Outcome& outcome);
  void accept_of_rank(FinishedFrame finished);
  [[nodiscard]] Notes notes_about(const field::ScalarField& field);
  // Keeps the frames that are already done, and returns the others.
  std::vector<std::size_t> keep_finished_frames();
  void keep(std::size_t frame, const FrameRecord* record);
  void begin_record(std::size_t frame, const Context& own);
  // Renames old meshes of a frame that failed, so that they do not pass for its result. Extends the frame's error.
  void set_aside_meshes(const convert::Outcome& outcome, FinishedFrame& finished);
  // Finishes the animation, unless the batch has failed as a whole.
  Result<mesh_io::MeshWriteResult> finish_animation();

  const BatchJob& batch;
  RunOptions options;
  const Context& context;
  const std::vector<std::size_t> frames;
  std::optional<Manifest> manifest;  // set if records are kept
  std::optional<Animation> animation;
  RunEvents* events = nullptr;
  std::vector<FrameRow> rows;  // by frame index; only the thread that converts the frame writes to its row
  std::vector<std::vector<FileRecord>> inputs;
  std::vector<FrameRecord> records;  // of an animation's frames, until the animation is written
  // By frame index: label files of an earlier run; read-only during the run. Empty if this run renames none.
  std::vector<std::vector<convert::OutputFileJob>> old_label_outputs;
  // 1: not converted. A frame that was converted but whose report failed is not missing.
  std::vector<char> is_missing;
  FrameDesk* desk = nullptr;           // hands out frames to other ranks
  FramesOfDesk* own_frames = nullptr;  // on another rank than 0: the frames that rank 0 hands out
  std::mutex mutex;                    // guards the manifest and the members below
  std::vector<RankWork> rank_work;
  Notes untold;  // on another rank than 0: notes about fields that rank 0 does not know
  std::vector<std::string> set_aside;
  std::optional<Error> fatal_error;  // set if the manifest or the animation could not be written
};

void BatchRun::State::keep(std::size_t frame, const FrameRecord* record) {
  FrameRow& row = rows[frame];
  row.status = FrameStatus::kept;
  if (record != nullptr) {
    row.figures = record->figures;
    for (const FileRecord& file : record->outputs) row.outputs.push_back(file.path);
  }
  events->over(frame, row, nullptr, nullptr);
}

std::vector<std::size_t> BatchRun::State::keep_finished_frames() {
  const bool resumes = manifest && options.resume_policy == ResumePolicy::keep_unchanged;
  std::optional<std::vector<FrameRecord>> all;
  if (animation && resumes) all = find_animation_record(*manifest, batch);
  // The contents of reports are not recorded, so a frame without a report is converted again.
  const auto lacks_report = [&](std::size_t i) { return !events->has_report(i); };
  if (all && std::ranges::any_of(frames, lacks_report)) all.reset();
  ExistingFiles existing;
  std::vector<std::size_t> others;
  for (const std::size_t i : frames) {
    const FrameJob& frame = batch.frames[i];
    const FrameRecord* record = all ? &(*all)[i] : nullptr;
    if (!animation && resumes) record = manifest->find(convert::hash_of(frame.job));
    const bool is_done = options.resume_policy == ResumePolicy::keep_existing
                             ? !existing.find(frame.job).empty()
                             : record != nullptr && events->has_report(i) &&
                                   (animation.has_value() || reason_to_reconvert(*record, frame).empty());
    if (is_done) {
      keep(i, record);
    } else {
      others.push_back(i);
    }
  }
  return others;
}

convert::Events* BatchRun::State::started(std::size_t frame, const Context& own) {
  if (options.keeps_records) begin_record(frame, own);
  return events->started(frame, own);
}

void BatchRun::State::begin_record(std::size_t frame, const Context& own) {
  auto states = input_states(batch.frames[frame], own);
  // An unreadable input fails in the conversion, with a better message.
  if (states) inputs[frame] = std::move(*states);
  [[maybe_unused]] const bool begun = begin_on_manifest(frame);
}

bool BatchRun::State::begin_on_manifest(std::size_t frame) {
  if (!manifest) return true;
  const std::string job = convert::hash_of(batch.frames[frame].job);
  const std::lock_guard lock(mutex);
  auto revoked = manifest->revoke(job);
  if (!revoked) fatal_error = revoked.error();
  return revoked.has_value();
}

bool BatchRun::State::finished(std::size_t frame, convert::Outcome& outcome) {
  FinishedFrame finished = complete(frame, outcome);
  if (own_frames == nullptr) return accept(std::move(finished), outcome);
  finished.notes = outcome.notes;
  finished.empty_picture = outcome.empty_picture;
  {
    const std::lock_guard lock(mutex);
    finished.field_notes = std::exchange(untold, {});
  }
  return own_frames->tell(finished);
}

FinishedFrame BatchRun::State::complete(std::size_t frame, const convert::Outcome& outcome) {
  FinishedFrame finished{.frame = frame, .row = rows[frame], .is_converted = outcome.done(), .error = outcome.error};
  std::optional<Error>& error = finished.error;
  if (auto reported = events->write_report(frame, outcome); !reported && !error) error = reported.error();
  if (!error && options.keeps_records) {
    auto made = record_of(batch.frames[frame], std::move(inputs[frame]), outcome, context);
    if (made) {
      finished.record = std::move(*made);
    } else {
      error = made.error();
    }
  }
  FrameRow& row = finished.row;
  if (options.ranks != nullptr) row.rank = options.ranks->rank();
  row.figures = figures_of(outcome);
  for (const mesh_io::WrittenFile& file : outcome.files) row.outputs.push_back(file.path);
  if (error && error->code == ErrorCode::cancelled) {
    row.status = FrameStatus::cancelled;
  } else if (error) {
    row.status = FrameStatus::failed;
    row.error = printable(error->message);
    if (!outcome.done()) set_aside_meshes(outcome, finished);
  } else {
    const bool wrote_nothing = !animation && row.figures.surfaces.empty() && outcome.files.empty();
    row.status = wrote_nothing || is_empty(row.figures) ? FrameStatus::empty : FrameStatus::done;
  }
  return finished;
}

bool BatchRun::State::accept(FinishedFrame finished, convert::Outcome& outcome) {
  const std::size_t frame = finished.frame;
  FrameRow& row = rows[frame];
  row = std::move(finished.row);
  is_missing[frame] = finished.is_converted ? 0 : 1;
  std::optional<Error> error = std::move(finished.error);
  bool goes_on = true;
  {
    auto lost = animation ? animation->lost() : std::nullopt;
    const std::lock_guard lock(mutex);
    if (finished.record && animation) {
      records[frame] = std::move(*finished.record);
    } else if (finished.record) {
      if (auto added = manifest->add(*finished.record); !added) fatal_error = error = added.error();
    }
    if (lost) fatal_error = std::move(lost);
    set_aside.insert(set_aside.end(), finished.set_aside.begin(), finished.set_aside.end());
    if (row.rank) ++rank_work[static_cast<std::size_t>(*row.rank)].frames;
    goes_on = !fatal_error;
  }
  if (error && row.error.empty() && error->code != ErrorCode::cancelled) {
    row.status = FrameStatus::failed;
    row.error = printable(error->message);
  }
  events->over(frame, row, &outcome, error ? &*error : nullptr);
  const bool ends = !goes_on || (options.scheduler.fail_fast && row.status == FrameStatus::failed);
  if (desk != nullptr && ends) desk->stop();
  if (!options.keeps_figures) row = {row.frame, row.input, row.status, {}, {}, {}, row.rank};
  return goes_on;
}

void BatchRun::State::accept_of_rank(FinishedFrame finished) {
  FrameRow& row = finished.row;
  row.frame = rows[finished.frame].frame;
  row.input = rows[finished.frame].input;
  convert::Outcome outcome;
  outcome.notes = std::move(finished.notes);
  outcome.empty_picture = finished.empty_picture;
  outcome.error = finished.error;
  events->notes_of_rank(finished.field_notes);
  accept(std::move(finished), outcome);
}

Notes BatchRun::State::notes_about(const field::ScalarField& field) {
  Notes notes = events->field_notes(field);
  if (own_frames == nullptr) return notes;
  const std::lock_guard lock(mutex);
  untold.insert(untold.end(), notes.begin(), notes.end());
  return notes;
}

void BatchRun::State::set_aside_meshes(const convert::Outcome& outcome, FinishedFrame& finished) {
  const convert::ConversionJob& job = batch.frames[finished.frame].job;
  const files::InputFileSet* read = options.scheduler.extras.read;
  if (animation || read == nullptr) return;
  std::vector<convert::OutputFileJob> outputs = job.outputs;
  if (!old_label_outputs.empty()) {
    // {name} stands for any text, so the file may be of another program.
    for (const convert::OutputFileJob& output : old_label_outputs[finished.frame]) {
      if (mesh_io::is_written_by_isoextract(convert::piece_path(output.path, 1), context)) outputs.push_back(output);
    }
  }
  std::vector<std::string> shown;
  for (const convert::OutputFileJob& output : outputs) {
    const auto names = convert::rename_old_meshes(output, job.meshes().format, *read, outcome.files, context);
    if (!names) {
      finished.row.error += fmt::format("; {}", names.error().message);
      continue;
    }
    for (const std::string& name : *names) shown.push_back(printable(name));
    finished.set_aside.insert(finished.set_aside.end(), names->begin(), names->end());
  }
  if (shown.empty()) return;
  finished.row.error +=
      shown.size() == 1 ? fmt::format("; the old mesh is now {}", shown.front())
                        : fmt::format("; the {} old files are now {}", shown.size(), convert::first_and_last(shown));
}

Result<mesh_io::MeshWriteResult> BatchRun::State::finish_animation() {
  std::vector<std::int64_t> missing;  // frame numbers
  std::size_t failed = 0;
  bool is_whole = true;
  for (const std::size_t i : frames) {
    const FrameStatus status = rows[i].status;
    if (is_missing[i] != 0) missing.push_back(batch.frames[i].number);
    if (status == FrameStatus::failed) ++failed;
    if (status == FrameStatus::not_started || status == FrameStatus::cancelled) is_whole = false;
  }
  if (!is_whole || missing.size() == frames.size() || (options.scheduler.fail_fast && failed > 0)) {
    return mesh_io::MeshWriteResult{
        {},
        {{NoteId::missing_frames,
          fmt::format("the run did not write {}, because frames failed, did not start or did not finish",
                      batch.animation->path)}}};
  }
  auto written = TRY(animation->finish());
  for (FrameRow& row : rows) {
    if (row.status != FrameStatus::done) continue;
    for (const mesh_io::WrittenFile& file : written.files) row.outputs.push_back(file.path);
  }
  if (!missing.empty()) written.notes.push_back({NoteId::missing_frames, missing_frames_note(batch, missing)});
  if (failed > 0 || !manifest) return written;
  TRY(record_animation(*manifest, batch, std::move(records), written));
  return written;
}

void BatchRun::State::convert_frames(std::span<const std::size_t> others) {
  if (options.ranks == nullptr) {
    batch::run(batch, others, options.scheduler, context, *this, animation ? &*animation : nullptr);
    return;
  }
  Packer list;
  for (const std::size_t i : others) list.put(i);
  if (const auto told = options.ranks->gather(list.take()); !told) {
    fatal_error = told.error();
    return;
  }
  rank_work.resize(static_cast<std::size_t>(options.ranks->size()));
  for (std::size_t r = 0; r < rank_work.size(); ++r) rank_work[r].rank = static_cast<int>(r);
  const Stopwatch watch;
  FrameDesk shared(
      *options.ranks, others.size(), [&](std::size_t place) { return begin_on_manifest(others[place]); },
      [this](FinishedFrame finished) { accept_of_rank(std::move(finished)); });
  desk = &shared;
  batch::run(batch, others, options.scheduler, context, *this, nullptr, desk);
  if (options.scheduler.fail_fast) shared.stop();
  const double seconds = watch.elapsed().wall_seconds;
  auto done = shared.finish();
  desk = nullptr;
  if (!done) {
    fatal_error = done.error();
    return;
  }
  rank_work.front().seconds = seconds;
  for (const auto& [rank, time] : *done) rank_work[static_cast<std::size_t>(rank)].seconds = time;
}

RunResult BatchRun::State::run_for_first_rank() {
  RunResult result;
  const auto told = options.ranks->gather({});
  if (!told) {
    result.error = told.error();
    return result;
  }
  Unpacker list(told->front());
  std::vector<std::size_t> others(told->front().size() / sizeof(std::size_t));
  for (std::size_t& i : others) i = list.get<std::size_t>();
  const Stopwatch watch;
  FramesOfDesk given(*options.ranks);
  own_frames = &given;
  batch::run(batch, others, options.scheduler, context, *this, nullptr, own_frames);
  own_frames = nullptr;
  if (auto ended = given.finish(watch.elapsed().wall_seconds); !ended) result.error = ended.error();
  return result;
}

RunResult BatchRun::State::run(RunEvents& the_events) {
  events = &the_events;
  options.scheduler.extras.field_notes = [this](const field::ScalarField& field) { return notes_about(field); };
  // Looks before the ranks begin to convert, so that no rank finds files of this run.
  if (options.scheduler.extras.read != nullptr && !animation) old_label_outputs = find_label_outputs(batch);
  if (options.ranks != nullptr && !options.ranks->is_first()) return run_for_first_rank();
  const std::vector<std::size_t> others = keep_finished_frames();
  convert_frames(others);
  mesh_io::MeshWriteResult animated;
  if (animation && others.empty()) {
    animated.notes.push_back({NoteId::animation_kept,
                              fmt::format("{} stays unchanged: no frame needs a conversion", batch.animation->path)});
  } else if (animation && !fatal_error) {
    auto finished = finish_animation();
    if (finished) {
      animated = std::move(*finished);
    } else {
      fatal_error = finished.error();
    }
  }
  if (manifest) manifest->remove_if_unused();
  RunResult result;
  for (const std::size_t i : frames) result.rows.push_back(std::move(rows[i]));
  result.set_aside = std::move(set_aside);
  result.animation = std::move(animated);
  result.error = std::move(fatal_error);
  result.ranks = std::move(rank_work);
  return result;
}

std::size_t RunResult::count(FrameStatus status) const {
  return static_cast<std::size_t>(std::ranges::count(rows, status, &FrameRow::status));
}

fs::path manifest_folder(const BatchJob& batch) {
  std::optional<fs::path> common;
  for (const FrameJob& frame : batch.frames) {
    for (const convert::OutputFileJob& output : frame.job.outputs) {
      const fs::path folder = fs::path(output.path).lexically_normal().parent_path();
      if (!common) common = folder;
      while (!common->empty() &&
             std::mismatch(common->begin(), common->end(), folder.begin(), folder.end()).first != common->end()) {
        common = common->parent_path() == *common ? fs::path() : common->parent_path();
      }
    }
  }
  return common.value_or(fs::path());
}

Result<std::optional<files::InputFileSet>> check_written_files(const BatchJob& batch, const Shard& shard,
                                                               const OtherFiles& others, const Context& context) {
  std::vector<fs::path> there;             // files to write that exist already
  std::unordered_set<std::string> meshes;  // `there`, and existing files that labels may replace
  ExistingFiles existing;
  for (const FrameJob& frame : batch.frames) {
    std::ranges::copy_if(files_of(frame.job), std::back_inserter(there), files::is_there);
    for (const fs::path& file : existing.find_label_files(frame.job)) meshes.insert(file.lexically_normal().string());
  }
  for (const fs::path& file : there) meshes.insert(file.lexically_normal().string());
  TRY(check_replaced_shard(manifest_folder(batch), batch, shard, meshes));
  for (const NamedFile& file : others.written) {
    if (files::is_there(file.path)) there.emplace_back(file.path);
  }
  const bool splits =
      std::ranges::any_of(batch.frames, [](const FrameJob& frame) { return frame.job.edits.pieces.split; });
  std::optional<files::InputFileSet> read;
  if (splits || !meshes.empty() || !there.empty()) read = read_files_of(batch, others, context);
  for (const fs::path& file : there) TRY(read->check(file));
  return read;
}

Result<BatchRun> BatchRun::open(const BatchJob& batch, RunOptions options, const Context& context) {
  if (batch.animation) TRY(Animation(batch, context).check());
  std::optional<Manifest> manifest;
  if (options.keeps_records && (options.ranks == nullptr || options.ranks->is_first())) {
    std::unordered_set<std::string> jobs;
    for (const std::size_t i : frames_of(batch, options.shard)) jobs.insert(convert::hash_of(batch.frames[i].job));
    ManifestHeader header = header_of(batch, options.shard, options.arguments);
    header.absent = options.absent;
    const bool resumes = options.resume_policy == ResumePolicy::keep_unchanged;
    manifest = TRY(Manifest::open(manifest_folder(batch), header, resumes, jobs));
  }
  options.scheduler.extras.hash_files = options.keeps_records;
  auto state = std::make_unique<State>(batch, std::move(options), context, std::move(manifest));
  if (batch.animation) state->animation.emplace(batch, context);
  return BatchRun(std::move(state));
}

BatchRun::BatchRun(std::unique_ptr<State> state) : state_(std::move(state)) {}
BatchRun::BatchRun(BatchRun&&) noexcept = default;
BatchRun& BatchRun::operator=(BatchRun&&) noexcept = default;
BatchRun::~BatchRun() = default;

RunResult BatchRun::run(RunEvents& events) { return state_->run(events); }

}  // namespace isoextract::batch
