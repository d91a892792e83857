#include "cli/batch_plan.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_arena.h>

#include "base/printable.hpp"
#include "batch/batch_run.hpp"
#include "batch/find_frames.hpp"
#include "batch/header_files.hpp"
#include "batch/iso_table.hpp"
#include "batch/output_names.hpp"
#include "cli/edit_plan.hpp"
#include "cli/height_plan.hpp"
#include "cli/mesh_plan.hpp"
#include "cli/output_plan.hpp"
#include "cli/particle_file_plan.hpp"
#include "cli/particle_plan.hpp"
#include "cli/picture_plan.hpp"
#include "cli/plan_parts.hpp"
#include "cli/rank_run.hpp"
#include "cli/vertex_plan.hpp"
#include "cli/voxel_plan.hpp"
#include "convert/mesh_pieces.hpp"
#include "convert/output_checks.hpp"
#include "convert/particle_source.hpp"
#include "field/demo_field.hpp"
#include "files/frame_pattern.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

namespace fs = std::filesystem;

Result<std::vector<batch::OutputSource>> sources_of(const ConvertFlags& flags, const batch::Frames& found) {
  std::optional<batch::IsoTable> table;
  if (flags.batch.iso_table) {
    TRY(refuse_both(flags.isos, flags.batch.iso_table));
    table = TRY(batch::IsoTable::read(*flags.batch.iso_table, Context()));
    std::vector<std::int64_t> numbers;
    for (const batch::Frame& frame : found.frames) numbers.push_back(frame.number);
    TRY(table->check_covers(numbers));
  }
  std::vector<batch::OutputSource> sources;
  for (const batch::Frame& frame : found.frames) {
    batch::OutputSource source{frame.number, frame.input, flags.input.grid().value_or(""), flags.isos, false};
    source.more_grids = flags.input.more_grids();
    source.step = frame.time.step;
    if (table) {
      const auto isos = table->isos_of(frame.number);
      source.isos.assign(isos.begin(), isos.end());
    }
    sources.push_back(std::move(source));
  }
  return sources;
}

// Returns a note about iso values that each frame determines from its own samples. Values of a table do not count,
// since the user chose them per frame.
std::string changing_isos(const ConvertFlags& flags, std::size_t frames) {
  std::vector<std::string> words;
  for (const convert::IsoChoice& iso : flags.isos) {
    if (iso.is_found() && iso.kind != convert::IsoChoice::Kind::zero) words.push_back(text_of(iso));
  }
  if (words.empty() || frames < 2) return {};
  return fmt::format(
      "--iso {}: each frame gets its own iso value, so the surface may jump between frames; give a number for one "
      "iso value in all frames",
      fmt::join(words, ", "));
}

bool wants_all_volumes(const ConvertFlags& flags) {
  return flags.input.volume && std::holds_alternative<AllVolumes>(*flags.input.volume);
}

// Returns the volumes of one file as frames, numbered as in the file.
Result<batch::Frames> volumes_of(const ConvertFlags& flags, const volume_io::ReadOptions& read,
                                 const Context& context) {
  const std::vector<std::string>& inputs = flags.input.inputs;
  const char* const one_file = "give one file, and convert each further file in a run of its own";
  if (inputs.size() > 1) {
    return refuse_usage("--volume all takes the volumes of one file, found several files", one_file);
  }
  if (is_frame_pattern(inputs.front())) {
    return refuse_usage(
        fmt::format("--volume all takes the volumes of one file, and the pattern {} stands for several files",
                    printable(inputs.front())),
        one_file);
  }
  auto particles = TRY(plan_particles(flags.particles, flags.surface.nan, has_attributes(flags)));
  convert::SourceOptions source;
  source.input = inputs.front();
  source.read = read;
  source.particles = std::move(particles);
  auto list = TRY(convert::list_frames(source, context.beside()));
  const std::uint64_t count = list.count;
  if (count > batch::kMaxFrames) {
    return refuse_usage(fmt::format("{}: found {} volumes, expected at most {}, the limit of frames in a batch",
                                    inputs.front(), count, batch::kMaxFrames));
  }
  list.times.resize(count);
  batch::Frames found;
  found.notes = std::move(list.notes);
  for (std::int64_t k = 0; k < static_cast<std::int64_t>(count); ++k) {
    if (flags.batch.frames && !flags.batch.frames->contains(k)) continue;
    found.frames.push_back({k, inputs.front(), k, list.times[static_cast<std::size_t>(k)]});
  }
  if (found.frames.empty()) {
    return refuse_usage(
        fmt::format("--frames selects no volume: {} has the volumes 0 to {}", inputs.front(), count - 1));
  }
  if (flags.batch.frames) found.gaps = batch::gaps_of(*flags.batch.frames, found.frames);
  return found;
}

// Parses --report. Fails if the name has no placeholder for the frame number or step.
Result<std::optional<batch::OutputTemplate>> plan_report(const ConvertFlags& flags) {
  if (!flags.report) return std::nullopt;
  auto name = TRY(plan_report_name(*flags.report));
  if (!name.uses(batch::OutputWord::frame) && !name.uses(batch::OutputWord::step)) {
    return refuse_usage(
        fmt::format(
            "--report {}: each frame has its own report, and this file name has no placeholder for the frame number",
            *flags.report),
        "write --report r_{:04}.json, or write one file for all frames with --table");
  }
  return name;
}

Result<void> plan_tables(const BatchFlags& flags, BatchPlan& plan) {
  for (const auto& path : {flags.table, flags.plot}) {
    if (path && (path->empty() || *path == "-")) return refuse_usage("--table and --plot need the name of a file");
  }
  if (flags.table) {
    const std::string extension = fs::path(*flags.table).extension();
    if (extension != ".csv" && extension != ".json") {
      return refuse_usage(fmt::format("{}: expected a name that ends in .csv or .json", *flags.table));
    }
  }
  if (!flags.plot) return {};
  plan.plot_format = TRY(picture_format_of(*flags.plot));
  return {};
}

// Refuses {piece}, {label} and {name} in folder names: the batch makes folders before the extraction, which finds the
// bodies and labels.
Result<void> check_folder_words(const std::vector<batch::OutputFiles>& outputs) {
  for (const batch::OutputFiles& files : outputs) {
    for (const convert::OutputFileJob& output : files) {
      const std::string folder = fs::path(output.path).parent_path().string();
      for (const std::string_view word :
           {convert::kPiecePlaceholder, convert::kLabelPlaceholder, convert::kNamePlaceholder}) {
        if (folder.find(word) == std::string::npos) continue;
        return refuse_usage(fmt::format("-o {}: the name of a folder contains {}", output.path, word),
                            "put it into the file name");
      }
    }
  }
  return {};
}

// Plans one animated file for all frames.
Result<std::vector<batch::OutputFiles>> plan_animation(const ConvertFlags& flags,
                                                       const std::vector<batch::OutputSource>& sources,
                                                       mesh_io::MeshFormat format, const batch::OtherFiles& others,
                                                       batch::BatchJob& job) {
  if (!flags.output) {
    return refuse_usage("--animate writes all frames into one file and needs its name", "for example -o water.glb");
  }
  const std::string& output = *flags.output;
  std::error_code none;
  if (output.ends_with('/') || fs::is_directory(output, none)) {
    return refuse_usage(
        fmt::format("-o {}: --animate writes all frames into one file, and this path is a folder", output),
        "for example -o water.glb");
  }
  const auto name = TRY(batch::OutputTemplate::parse(output));
  for (const auto& word : words_of(batch::OutputWord{})) {
    if (!name.uses(word.value)) continue;
    return refuse_usage(
        fmt::format(
            "-o {}: --animate writes all frames into one file, and this file name contains a placeholder for '{}'",
            output, word.word),
        "for example -o water.glb; without --animate each frame gets its own file");
  }
  if (format != mesh_io::MeshFormat::glb) {
    return refuse_usage(
        fmt::format("--animate writes glb, found {}", mesh_io::mesh_format_info(format).name),
        "give a file name that ends in .glb; without --animate each frame gets its own file, in any format");
  }
  job.animation =
      batch::AnimationJob{name.expand({}), flags.batch.fps.value_or(batch::AnimationJob().frames_per_second)};
  std::vector<batch::OutputFiles> outputs(sources.size());
  outputs.front() = {{job.animation->path, sources.front().isos}};
  TRY(batch::check_outputs(sources, outputs, format, others));
  for (std::size_t i = 1; i < sources.size(); ++i) outputs[i] = {{job.animation->path, sources[i].isos}};
  return outputs;
}

// Sets when the frames start, if the file states unevenly spaced times.
void plan_animation_times(std::span<const batch::Frame> frames, batch::AnimationJob& animation, Notes& notes) {
  std::vector<std::int64_t> numbers;
  std::vector<particle_io::FrameTime> times;
  for (const batch::Frame& frame : frames) {
    numbers.push_back(frame.number);
    times.push_back(frame.time);
  }
  animation.starts = batch::animation_starts(numbers, times, animation.frames_per_second);
  if (animation.starts.empty()) return;
  const double range = *times.back().time - *times.front().time;
  notes.push_back(
      {NoteId::animation_times,
       fmt::format("{}: the frames start at their times in {}, {:.6g} to {:.6g}; a second of the animation covers "
                   "{:.6g} of this time; --fps {:.6g} is the mean number of frames per second",
                   animation.path, printable(frames.front().input), *times.front().time, *times.back().time,
                   range / animation.starts.back(), animation.frames_per_second)});
}

// Fills `note` if the environment has a job scheduler's variable and --shard is absent.
Result<batch::Shard> plan_shard(const BatchFlags& flags, const char* (*environment)(const char*), std::string& note) {
  if (!flags.shard) {
    if (const std::string variable = batch::scheduler_variable(environment); !variable.empty()) {
      note = fmt::format(
          "the environment has {}, but this run converts all frames: give --shard auto to convert only this task's "
          "frames",
          variable);
    }
    return batch::Shard();
  }
  batch::Shard shard = flags.shard->shard.value_or(batch::Shard());
  if (!flags.shard->shard) {
    const auto found = TRY(batch::shard_of_environment(environment));
    if (!found) {
      return refuse_usage("--shard auto: the environment has no SLURM_ARRAY_TASK_ID and no JOB_COMPLETION_INDEX",
                          "give the shard as --shard K/N");
    }
    shard = *found;
  }
  if (!flags.animate || shard.is_all()) return shard;
  return refuse_usage(fmt::format("--animate needs all frames in one process, and this process converts shard {}/{}",
                                  shard.number, shard.count),
                      "write one file per frame without --animate, or run on one machine without --shard");
}

// Adds the shard to the names of tables, plots and pages: t.csv becomes t.2-of-3.csv. Returns a note that says so, or
// an empty text.
std::string name_after_shard(const batch::Shard& shard, ConvertFlags& flags) {
  if (shard.is_all()) return {};
  std::vector<std::string> names;
  for (auto* path : {&flags.batch.table, &flags.batch.plot, &flags.html, &flags.contact_sheet}) {
    if (!*path || (*path)->empty() || **path == "-") continue;  // refused elsewhere
    const fs::path whole = **path;
    *path = whole.parent_path() /
            fmt::format("{}.{}-of-{}{}", whole.stem().string(), shard.number, shard.count, whole.extension().string());
    names.push_back(printable(**path));
  }
  if (names.empty()) return {};
  return fmt::format(
      "{}: covers the frames of this shard only; to cover all frames, run isoextract merge, then the same command "
      "without --shard and with --resume",
      fmt::join(names, ", "));
}

}  // namespace

bool is_batch(const ConvertFlags& flags) {
  const std::vector<std::string>& inputs = flags.input.inputs;
  if (inputs.empty() || flags.masks) return false;
  if (inputs.size() > 1 || wants_all_volumes(flags) || flags.batch.any_set()) return true;
  if (flags.heightfield && volume_io::is_slice_stack(inputs.front(), Context())) return true;
  return is_frame_pattern(inputs.front());
}

void name_volume_of_files(std::vector<std::string>& inputs) {
  inputs = batch::without_sample_files(inputs);
  if (auto volume = batch::find_one_volume(inputs)) inputs = {std::move(*volume)};
}

bool is_frame_pattern(const std::string& input) {
  if (volume_io::is_slice_stack(input, Context())) return false;
  if (!input.starts_with(field::kDemoPrefix) && files::is_there(input)) {
    std::error_code none;
    return fs::is_directory(input, none) && !volume_io::is_volume_folder(input, Context());
  }
  if (volume_io::find_inner_path(input)) return false;
  const auto pattern = files::FramePattern::parse(input);
  return !pattern || pattern->has_value();  // the search for frames reports an invalid pattern
}

Result<BatchPlan> plan_batch(const ConvertFlags& given, const char* (*environment)(const char*)) {
  ConvertFlags flags = given;
  TRY(take_heights(flags));
  if (flags.output == "-") return refuse_usage("a batch writes frames to files, not to stdout", "give a name with -o");
  if (flags.explain)
    return refuse_usage("--explain describes one conversion, not a batch",
                        "use --table FILE, or -v to show each frame");
  if (flags.batch.fps && !flags.batch.animate) {
    return refuse_usage("--fps sets the speed of an animation and needs --animate",
                        "give --animate, or leave --fps out");
  }
  BatchPlan plan;
  std::string of_environment;
  const auto shard = TRY(plan_shard(flags.batch, environment, of_environment));
  const std::string of_shard = name_after_shard(shard, flags);
  ConvertFlags one = flags;  // for one frame
  if (wants_all_volumes(flags)) one.input.volume.reset();
  const Context context(plan_memory(flags.input.memory_limit));
  const auto read = TRY(plan_read(one.input));
  auto found =
      TRY(wants_all_volumes(flags) ? volumes_of(flags, read, context)
                                   : batch::find_frames(flags.input.inputs, flags.batch.frames, flags.heightfield));
  TRY(take_mesh(one, found.frames.front().input, context));
  TRY(check_mesh_frames(one, found, context));
  const std::string usual_labels = TRY(set_default_labels(one, found.frames.front().input, context));
  TRY(take_labels(one));
  if (one.labels.chosen) flags.labels.chosen = *one.labels.chosen;
  std::string usual_iso;
  if (!flags.batch.iso_table && makes_surfaces(flags)) {
    usual_iso = TRY(set_default_iso(one, found.frames.front().input, context));
    flags.isos = one.isos;
  }
  auto sources = TRY(sources_of(flags, found));
  auto common = TRY(plan_conversion(one, sources.front().isos, context));
  plan.common = std::move(common);
  if (!usual_iso.empty()) plan.common.notes.push_back({NoteId::iso_chosen, std::move(usual_iso)});
  if (!usual_labels.empty()) plan.common.notes.push_back({NoteId::iso_chosen, usual_labels});
  TRY(plan_found_table(one.labels, found.frames.front().input, context, plan.common.notes, plan.common.job));
  plan.frame_notes = plan.common.notes;  // the notes below are about the batch
  if (std::string note = changing_isos(flags, sources.size()); !note.empty())
    found.notes.push_back({NoteId::iso_chosen, std::move(note)});
  for (Note& note : found.notes) plan.common.notes.push_back(std::move(note));
  if (flags.placement.center && !flags.surface.roi) {
    plan.common.notes.push_back({NoteId::frames_move,
                                 "--center moves each frame by the center of its own samples; the bounds of sparse "
                                 "volumes and particles change, "
                                 "so their frames shift against each other; --roi prevents that"});
  }
  const auto* picture = plan.common.job.writes<convert::PictureFileOptions>();
  if (picture != nullptr && sources.size() > 1) {
    std::string note = cameras_note(*picture);
    if (!note.empty()) plan.common.notes.push_back({NoteId::one_camera, std::move(note)});
  }
  TRY(find_steps(flags, plan.common.job.source, context, sources));
  const auto report = TRY(plan_report(flags));
  TRY(plan_tables(flags.batch, plan));
  plan.others = other_files(flags, sources, report);
  const mesh_io::MeshFormat format = plan.common.job.meshes().format;
  auto outputs = TRY(flags.batch.animate ? plan_animation(flags, sources, format, plan.others, plan.batch)
                                         : plan_outputs(flags, sources, format, plan.others));
  TRY(check_folder_words(outputs));
  if (plan.batch.animation) plan_animation_times(found.frames, *plan.batch.animation, plan.common.notes);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    batch::FrameJob& frame = plan.batch.frames.emplace_back();
    if (report) plan.reports.push_back(report_path(*report, sources[i]));
    frame.number = found.frames[i].number;
    frame.job = plan.common.job;
    frame.job.source.input = found.frames[i].input;
    if (found.frames[i].volume) frame.job.source.read.volume = found.frames[i].volume;
    frame.job.outputs = std::move(outputs[i]);
    TRY(number_attributes(frame.job.source.attributes, frame.number));
  }
  plan.gaps = std::move(found.gaps);
  plan.missing_is_error = flags.batch.missing.value_or(
                              flags.batch.frames ? MissingPolicy::error : MissingPolicy::note) == MissingPolicy::error;

  if (!of_environment.empty()) plan.common.notes.push_back({NoteId::shard, std::move(of_environment)});
  if (!of_shard.empty()) plan.common.notes.push_back({NoteId::shard, of_shard});
  plan.shard = shard;
  plan.frames = batch::frames_of(plan.batch, plan.shard);

  plan.threads = plan.common.threads.value_or(tbb::this_task_arena::max_concurrency());
  plan.jobs = flags.batch.jobs.value_or(plan.threads);
  plan.flags = flags.batch;
  TRY(refuse_both(plan.flags.resume, plan.flags.no_clobber, "", "--resume converts only the unfinished frames"));
  if (plan.flags.resume) plan.resume_policy = batch::ResumePolicy::keep_unchanged;
  if (plan.flags.no_clobber) plan.resume_policy = batch::ResumePolicy::keep_existing;
  plan.make_folders = flags.batch.make_folders || (flags.output && flags.output->ends_with('/'));
  plan.progress = is_later_rank() ? ProgressStyle::none : flags.batch.progress.value_or(ProgressStyle::bar);
  return plan;
}

}  // namespace isoextract::cli
