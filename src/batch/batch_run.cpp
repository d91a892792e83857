#include "batch/batch_run.hpp"

#include <algorithm>
#include <mutex>
#include <system_error>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "batch/detail/animation.hpp"
#include "batch/manifest.hpp"
#include "batch/merge_shards.hpp"
#include "convert/output_checks.hpp"
#include "files/output_file.hpp"

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
  bool finished(std::size_t frame, const convert::Outcome& outcome) override;

  // Keeps the frames that are already done, and returns the others.
  std::vector<std::size_t> keep_finished_frames();
  void keep(std::size_t frame, const FrameRecord* record);
  void begin_record(std::size_t frame, const Context& own);
  std::optional<Error> record(std::size_t frame, const convert::Outcome& outcome);
  // Renames old meshes of a frame that failed, so that they do not pass for its result. Returns text for the error.
  std::string set_aside_meshes(const convert::ConversionJob& job, const convert::Outcome& outcome);
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
  // 1: not converted. A frame that was converted but whose report failed is not missing.
  std::vector<char> is_missing;
  std::mutex mutex;  // guards the manifest and the members below
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
  std::vector<std::size_t> others;
  for (const std::size_t i : frames) {
    const FrameJob& frame = batch.frames[i];
    const FrameRecord* record = all ? &(*all)[i] : nullptr;
    if (!animation && resumes) record = manifest->find(convert::hash_of(frame.job));
    const bool is_done = options.resume_policy == ResumePolicy::keep_existing
                             ? std::ranges::any_of(files_of(frame.job), files::is_there)
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
  if (manifest) begin_record(frame, own);
  return events->started(frame, own);
}

void BatchRun::State::begin_record(std::size_t frame, const Context& own) {
  auto states = input_states(batch.frames[frame], own);
  // An unreadable input fails in the conversion, with a better message.
  if (states) inputs[frame] = std::move(*states);
  const std::string job = convert::hash_of(batch.frames[frame].job);
  const std::lock_guard lock(mutex);
  if (auto begun = manifest->begin(job); !begun) fatal_error = begun.error();
}

bool BatchRun::State::finished(std::size_t frame, const convert::Outcome& outcome) {
  const convert::ConversionJob& job = batch.frames[frame].job;
  FrameRow& row = rows[frame];
  std::optional<Error> error = outcome.error;
  if (auto reported = events->write_report(frame, outcome); !reported && !error) error = reported.error();
  is_missing[frame] = outcome.done() ? 0 : 1;
  if (!error && manifest) error = record(frame, outcome);
  bool goes_on = true;
  {
    auto lost = animation ? animation->lost() : std::nullopt;
    const std::lock_guard lock(mutex);
    if (lost) fatal_error = std::move(lost);
    goes_on = !fatal_error;
  }
  row.figures = figures_of(outcome);
  for (const mesh_io::WrittenFile& file : outcome.files) row.outputs.push_back(file.path);
  if (error && error->code == ErrorCode::cancelled) {
    row.status = FrameStatus::cancelled;
  } else if (error) {
    row.status = FrameStatus::failed;
    row.error = printable(error->message);
    if (!outcome.done()) row.error += set_aside_meshes(job, outcome);
  } else {
    const bool wrote_nothing = !animation && row.figures.surfaces.empty() && outcome.files.empty();
    row.status = wrote_nothing || is_empty(row.figures) ? FrameStatus::empty : FrameStatus::done;
  }
  events->over(frame, row, &outcome, error ? &*error : nullptr);
  if (!options.keeps_figures) row = {row.frame, row.input, row.status, {}, {}, {}};
  return goes_on;
}

std::string BatchRun::State::set_aside_meshes(const convert::ConversionJob& job, const convert::Outcome& outcome) {
  const files::InputFileSet* read = options.scheduler.extras.read;
  if (animation || read == nullptr) return {};
  std::string text;
  for (const convert::OutputFileJob& output : job.outputs) {
    const auto names = convert::rename_old_meshes(output, job.meshes().format, *read, outcome.files, context);
    if (!names) {
      text += fmt::format("; {}", names.error().message);
      continue;
    }
    for (const std::string& name : *names) text += fmt::format("; the old mesh is now {}", printable(name));
    const std::lock_guard lock(mutex);
    set_aside.insert(set_aside.end(), names->begin(), names->end());
  }
  return text;
}

std::optional<Error> BatchRun::State::record(std::size_t frame, const convert::Outcome& outcome) {
  auto made = record_of(batch.frames[frame], std::move(inputs[frame]), outcome, context);
  if (!made) return made.error();
  if (animation) {
    records[frame] = std::move(*made);
    return std::nullopt;
  }
  const std::lock_guard lock(mutex);
  auto added = manifest->add(*made);
  if (added) return std::nullopt;
  fatal_error = added.error();
  return added.error();
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
        {}, {{NoteId::missing_frames, fmt::format("the run did not write {}", batch.animation->path)}}};
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

RunResult BatchRun::State::run(RunEvents& the_events) {
  events = &the_events;
  options.scheduler.extras.field_notes = [this](const field::ScalarField& field) { return events->field_notes(field); };
  const std::vector<std::size_t> others = keep_finished_frames();
  batch::run(batch, others, options.scheduler, context, *this, animation ? &*animation : nullptr);
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
  RunResult result;
  for (const std::size_t i : frames) result.rows.push_back(std::move(rows[i]));
  result.set_aside = std::move(set_aside);
  result.animation = std::move(animated);
  result.error = std::move(fatal_error);
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
  std::vector<fs::path> there;  // files to write that exist already
  std::unordered_set<std::string> meshes;
  for (const FrameJob& frame : batch.frames) {
    for (fs::path& file : files_of(frame.job)) {
      meshes.insert(file.lexically_normal().string());
      if (files::is_there(file)) there.push_back(std::move(file));
    }
  }
  TRY(check_replaced_shard(manifest_folder(batch), batch, shard, meshes));
  for (const NamedFile& file : others.written) {
    if (files::is_there(file.path)) there.emplace_back(file.path);
  }
  const bool splits =
      std::ranges::any_of(batch.frames, [](const FrameJob& frame) { return frame.job.edits.pieces.split; });
  std::optional<files::InputFileSet> read;
  if (splits || !there.empty()) read = read_files_of(batch, others, context);
  for (const fs::path& file : there) TRY(read->check(file));
  return read;
}

Result<BatchRun> BatchRun::open(const BatchJob& batch, RunOptions options, const Context& context) {
  if (batch.animation) TRY(Animation(batch, context).check());
  std::optional<Manifest> manifest;
  if (options.keeps_records) {
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
