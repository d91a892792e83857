// `isoextract info`: prints the contents of volumes to stdout, as text or JSON.
#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/byte_size.hpp"
#include "base/machine.hpp"
#include "base/stopwatch.hpp"
#include "batch/find_frames.hpp"
#include "batch/output_names.hpp"
#include "batch/output_template.hpp"
#include "cli/batch_plan.hpp"
#include "cli/info_report.hpp"
#include "cli/info_sequence.hpp"
#include "cli/mask_plan.hpp"
#include "cli/options/convert.hpp"
#include "cli/planned_command.hpp"
#include "cli/progress_bar.hpp"
#include "cli/wrong_file_kind.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"
#include "convert/mask_layers.hpp"
#include "convert/particle_source.hpp"
#include "convert/source.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/sparse_blocks.hpp"
#include "files/file_bytes.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::cli {
namespace {

// The volume and component that the report describes, if the file has several.
struct Described {
  std::optional<std::int64_t> volume;
  std::optional<volume_io::ComponentChoice> component;
};

// `surfaces` are the options that choose the surfaces: "--iso 0.5".
std::string example_command(const InfoPlan& plan, const std::string& input, const Described& described,
                            const std::string& surfaces, bool has_nan, std::string_view creator) {
  std::string arguments;
  for (const std::string& argument : plan.input_arguments) arguments += " " + argument;
  if (!plan.read.volume && described.volume) arguments += fmt::format(" --volume {}", *described.volume);
  if (!plan.read.component && described.component) {
    arguments += fmt::format(" --component {}", described.component->number.value_or(0));
  }
  // With --nodata, NaN samples are outside by default.
  if (has_nan && !plan.read.no_data) arguments += " --nan outside";
  if (const auto up = convert::up_axis_of(creator)) arguments += fmt::format(" --up {}", word_of(*up));
  std::vector<std::string> inputs{shell_quoted(input)};
  std::string stem = batch::stem_of(input);
  if (!plan.masks.empty()) {
    inputs.clear();
    for (const std::string& mask : plan.inputs) inputs.push_back(shell_quoted(mask));
    stem = name_of_masks(plan.masks);
  }
  return fmt::format("isoextract {}{} {} -o {}", fmt::join(inputs, " "), arguments, surfaces,
                     shell_quoted(batch::template_of(stem) + ".glb"));
}

// Returns whether float32 can tell all vertices apart at the field's placement.
bool fits_one_mesh(const field::ScalarField& field) {
  const auto* sparse = std::get_if<field::SparseSamples>(&field.samples);
  const field::IndexBox stored = sparse != nullptr ? extract::stored_box(*sparse) : field.extents();
  extract::ExtractOptions options;
  options.output_from_index = field.index_to_world;
  return stored.empty() || extract::output_placement(field, options, stored, stored).fits_float32();
}

// Sets the memory of the surfaces of all labels, as the suggested command makes them.
Result<void> measure_labels(FieldReport& report, const Context& context) {
  extract::ExtractOptions options;
  options.method = extract::Method::surface_nets;
  options.nan = extract::NanPolicy::outside;
  options.output_from_index = report.field.index_to_world;
  const auto size = TRY(extract::estimate_label_map(report.field, options, {true, {}}, context));
  const std::uint64_t most_held = mesh_io::most_held_bytes("labels.glb", {}, context);
  report.bytes = convert::estimated_label_bytes(report.field, size, convert::label_making_bytes(size, most_held, 0));
  report.whole_mesh_bytes = report.bytes;
  return {};
}

// Returns whether the field is a single slice of dense samples, such as one picture.
bool is_slice(const field::ScalarField& field) {
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  return dense != nullptr && dense->dims.z == 1 && dense->dims.x > 1 && dense->dims.y > 1;
}

// Names the command that makes terrain of a flat array, since info itself has no option for heights.
Error with_terrain_command(Error error, const InfoPlan& plan, const std::string& input) {
  for (Step& step : error.hint.steps) {
    if (step.setting != Setting::height_field) continue;
    step = fmt::format("make terrain of it with '{}', if the numbers are heights",
                       example_command(plan, input, {}, ConvertFlags().heightfield.name(), false, {}));
  }
  return error;
}

// Completes the report of a field whose iso value or labels are suggested.
FieldReport report_of(const InfoPlan& plan, const std::string& input, const Described& described, FieldReport report) {
  report.is_slice = !report.labels && is_slice(report.field);
  if (report.is_slice) {
    report.suggestion.separates = false;
    report.ct.reset();
    report.command =
        example_command(plan, input, described, ConvertFlags().heightfield.name(), false, report.field.creator);
  }
  const bool separates = report.suggestion.separates && !report.labels;
  extract::ExtractOptions surface;
  surface.iso = report.suggestion.iso;
  report.size = separates ? convert::size_of(report.field, surface) : convert::size_of_samples(report.field);
  if (report.labels) {
    // Surface nets have about a vertex and two triangles for each face of a voxel.
    report.size.vertices = report.labels->map.faces;
  } else {
    report.whole_mesh_bytes = convert::estimated_bytes(report.size);
    // NaN samples with smooth normals need the whole mesh.
    report.bytes = report.statistics.nan > 0 ? report.whole_mesh_bytes
                                             : convert::estimated_bytes_by_parts(
                                                   report.size, convert::MeshFileOptions(), convert::Normals::smooth);
  }
  report.fits_one_mesh = fits_one_mesh(report.field);
  if ((separates || report.labels) && report.fits_one_mesh) {
    const std::string surfaces =
        report.labels ? std::string(kAllLabels) : fmt::format("--iso {}", report.suggestion.iso);
    report.command = example_command(plan, input, described, surfaces, report.statistics.nan > 0, report.field.creator);
  }
  return report;
}

Result<FieldReport> measure(const InfoPlan& plan, const std::string& input, const Described& described,
                            const Messages& messages) {
  const Context context{plan.memory};
  volume_io::ReadOptions read = plan.read;
  read.volume = described.volume;
  read.component = described.component;
  const ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
  convert::Events unheard;  // ignores events: the report has the notes
  auto field = convert::read_field(input, read, context, unheard);
  std::optional<Error> no_values;
  if (!field && field.error().code == ErrorCode::input) {
    // Reads again with label ids: 64-bit integers that a double cannot hold may be labels.
    no_values = std::move(field.error());
    read.label_ids = true;
    field = convert::read_field(input, read, context, unheard);
    if (!field || !field->label_ids) return tl::unexpected(std::move(*no_values));
  }
  if (!field) return tl::unexpected(std::move(field.error()));
  FieldReport report;
  report.field = std::move(*field);
  report.statistics = field::measure_statistics(report.field, &context.progress());
  report.suggestion = field::suggest_iso(report.field, report.statistics);
  report.ct = field::suggest_ct_isos(report.field, report.statistics);
  report.labels = report_labels(input, described.volume, context, report.field);
  if (no_values && !report.labels) return tl::unexpected(std::move(*no_values));
  if (report.labels) TRY(measure_labels(report, context));
  return report_of(plan, input, described, std::move(report));
}

// Returns the named grid, or without a name the first scalar grid; null if there is none.
const volume_io::GridInfo* described_grid(const InfoPlan& plan, const std::vector<volume_io::GridInfo>& grids) {
  const auto is_it = [&](const volume_io::GridInfo& grid) {
    return plan.read.grid ? grid.matches_name(*plan.read.grid) : grid.scalar;
  };
  const auto found = std::ranges::find_if(grids, is_it);
  return found == grids.end() ? nullptr : &*found;
}

convert::SourceOptions source_of(const InfoPlan& plan, const std::string& input) {
  convert::SourceOptions source;
  source.input = input;
  source.read = plan.read;
  source.particles = plan.particles;
  return source;
}

InputReport look_at_particles(const InfoPlan& plan, const std::string& input, const Messages& messages) {
  InputReport report;
  report.input = input;
  const Context context{plan.memory.part()};
  const ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
  auto measured = measure_particles(source_of(plan, input), context);
  if (!measured) {
    report.error = add_volume_file_hint(std::move(measured.error()), input);
    return report;
  }
  report.volume = measured->report.frame;
  report.particles = std::move(measured->report);
  if (!measured->field) return report;
  FieldReport field;
  field.field = std::move(*measured->field);
  field.statistics = field::measure_statistics(field.field, &context.progress());
  const points::MethodInfo& method = points::method_info(plan.particles.method);
  field.suggestion = {method.iso, fmt::format("the default of {}", method.title),
                      method.iso >= field.statistics.min && method.iso < field.statistics.max};
  const std::uint64_t made = convert::kProgramBytes + context.memory().peak();
  report.field = report_of(plan, input, {report.volume, {}}, std::move(field));
  report.field->bytes = std::max(report.field->bytes, made);
  report.field->whole_mesh_bytes = std::max(report.field->whole_mesh_bytes, made);
  std::string& command = report.field->command;
  if (report.particles->statistics.bounds.not_finite > 0 && !command.empty()) command += " --nan outside";
  return report;
}

InputReport look_at(const InfoPlan& plan, const std::string& input, const Messages& messages) {
  InputReport report;
  report.input = input;
  const auto of_particles = convert::is_particles(source_of(plan, input), Context(plan.memory));
  if (!of_particles) {
    report.error = add_volume_file_hint(of_particles.error(), input);
    return report;
  }
  if (*of_particles) return look_at_particles(plan, input, messages);
  auto grids = volume_io::list_grids(input, plan.read, Context(plan.memory));
  if (!grids) {
    report.error = with_terrain_command(add_volume_file_hint(std::move(grids.error()), input), plan, input);
    return report;
  }
  report.grids = std::move(*grids);
  if (!plan.read.grid && !report.grids.empty()) {
    const volume_io::GridInfo* only = grid_without_choice(report.grids);
    // The list of grids states why no reader reads this grid.
    if (only == nullptr || (!only->is_readable() && !plan.read.spacing)) return report;
  }
  report.volume = plan.read.volume;
  report.component = plan.read.component;
  if (const volume_io::GridInfo* grid = described_grid(plan, report.grids)) {
    if (!report.volume && has_several_volumes(*grid)) report.volume = 0;
    if (!report.component && has_several_components(*grid)) report.component = volume_io::ComponentChoice{0};
  }
  auto field = measure(plan, input, {report.volume, report.component}, messages);
  if (field) {
    report.field = std::move(*field);
  } else {
    report.error = std::move(field.error());
  }
  return report;
}

// Keeps the notes of reading masks.
class MaskNotes final : public convert::Events {
 public:
  void note(const Note& note) override { notes.push_back(note); }

  Notes notes;
};

// Returns the report on all masks as one input.
InputReport look_at_masks(const InfoPlan& plan, const Messages& messages) {
  InputReport report;
  report.input = plan.inputs.front();
  const Context context{plan.memory};
  const ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
  MaskNotes events;
  const auto masks = convert::MaskLayers::read(plan.masks, plan.read, {}, context, events);
  auto first = masks ? masks->layer(0, context) : tl::unexpected(masks.error());
  if (!first) {
    report.error = add_volume_file_hint(std::move(first.error()), report.input);
    return report;
  }
  FieldReport field;
  field.field = std::move(*first);
  field.field.notes = std::move(events.notes);
  field.statistics = field::measure_statistics(field.field, &context.progress());
  field.suggestion = field::suggest_iso(field.field, field.statistics);
  field.labels = report_masks(*masks);
  if (auto measured = measure_labels(field, context); !measured) {
    report.error = std::move(measured.error());
    return report;
  }
  report.field = report_of(plan, report.input, {}, std::move(field));
  return report;
}

// Tells each note once: those of particles include those of their field.
void tell_notes(const InputReport& report, const Messages& messages) {
  if (report.particles) {
    for (const Note& note : report.particles->notes) messages.note(note);
  } else if (report.field) {
    for (const Note& note : report.field->field.notes) messages.note(note);
  }
}

// Collects the output and the first failure.
class InfoPage {
 public:
  InfoPage(const InfoPlan& plan, const Messages& messages) : plan_(plan), messages_(messages) {}

  void add_input(const std::string& input) {
    const Stopwatch watch;
    const InputReport report = plan_.masks.empty() ? look_at(plan_, input, messages_) : look_at_masks(plan_, messages_);
    take_error(report);
    tell_notes(report, messages_);
    tell_time(input, watch);
    add(report, report.error.has_value());
  }

  void add_masks() {
    for (const Note& note : plan_.notes) messages_.note(note);
    add_input(plan_.inputs.front());
  }

  // Adds all frames of a sequence, with a full report of the first readable one.
  void add_sequence(const std::string& input) {
    const Stopwatch watch;
    auto found = batch::find_frames({&input, 1}, plan_.frames);
    if (!found) {
      InputReport report;
      report.input = input;
      report.error = std::move(found.error());
      take_error(report);
      add(report, true);
      return;
    }
    for (const Note& note : found->notes) messages_.note(note);
    SequenceReport sequence{
        input, {}, found->have_numbers, std::move(found->gaps), plan_.input_arguments, radius_of(*found), {}, {}};
    InfoPlan plan = plan_;
    if (sequence.radius) plan.particles.sequence_radius = sequence.radius->radius;
    plan.particles.sequence_spacing = spacing_of(*found);
    bool has_nan = false;
    for (const batch::Frame& frame : found->frames) {
      const InputReport report = look_at(plan, frame.input, messages_);
      has_nan = has_nan || (report.field && report.field->statistics.nan > 0);
      take_error(report);
      sequence.frames.push_back(summary_of(frame.number, report));
      if (!sequence.first_text.empty() || report.error) continue;
      tell_notes(report, messages_);
      sequence.first_text = text_of(report);
      sequence.first_json = json_of(report);
      if (!report.field) continue;
      if (const auto up = convert::up_axis_of(report.field->field.creator)) {
        sequence.arguments.push_back(fmt::format("--up {}", word_of(*up)));
      }
    }
    if (has_nan && !plan_.read.no_data) sequence.arguments.emplace_back("--nan outside");
    tell_time(input, watch);
    add(sequence, sequence.first_text.empty());
  }

  std::optional<Error> print() {
    if (plan_.json) text_ = convert::json_text(json_);
    if (text_.empty()) return failure_;
    if (auto printed = print_to_stdout(text_); !printed) {
      messages_.error(printed.error());
      if (!failure_) failure_ = printed.error();
    }
    return failure_;
  }

 private:
  // Returns the radius that convert uses for these frames.
  [[nodiscard]] std::optional<SequenceRadius> radius_of(const batch::Frames& found) const {
    if (plan_.has_radius_of_each_frame || found.frames.size() < 2) return std::nullopt;
    return find_sequence_radius(first_frames(found), Context(plan_.memory.part())).value_or(std::nullopt);
  }

  // Returns the spacing that convert uses for these frames.
  [[nodiscard]] std::optional<double> spacing_of(const batch::Frames& found) const {
    if (found.frames.size() < 2) return std::nullopt;
    const auto spacing =
        find_sequence_spacing(first_frames(found), Context(plan_.memory.part())).value_or(std::nullopt);
    if (spacing) messages_.note({NoteId::cell_size, spacing_note(*spacing)});
    return spacing;
  }

  [[nodiscard]] std::vector<FrameSource> first_frames(const batch::Frames& found) const {
    std::vector<FrameSource> sources;
    for (const batch::Frame& frame : found.frames) {
      if (sources.size() == kFramesForRadius) break;
      sources.push_back({frame.number, source_of(plan_, frame.input)});
    }
    return sources;
  }

  void take_error(const InputReport& report) {
    if (!report.error) return;
    messages_.error(*report.error);
    if (!failure_) failure_ = report.error;
  }

  void tell_time(const std::string& input, const Stopwatch& watch) const {
    messages_.detail(fmt::format("{}: {:.2f} s, peak memory {}", files::input_label(input),
                                 watch.elapsed().wall_seconds, format_byte_size(peak_memory())));
  }

  template <class Report>
  void add(const Report& report, bool failed) {
    if (plan_.json) {
      convert::Json& entry = json_.emplace_back(convert::Json{{"schema", word_of(convert::JsonDocument::info)}});
      entry.update(json_of(report));
    } else if (!failed) {
      text_ += (text_.empty() ? "" : "\n") + text_of(report);
    }
  }

  const InfoPlan& plan_;
  const Messages& messages_;
  std::optional<Error> failure_;
  std::string text_;
  convert::Json json_ = convert::Json::array();
};

// Reports on every input that it can read. Prints errors; returns the exit code of the first error.
Result<int> run_info(const InfoPlan& plan, const Messages& messages) {
  InfoPage page(plan, messages);
  if (!plan.masks.empty()) page.add_masks();
  for (const std::string& input : plan.masks.empty() ? plan.inputs : std::vector<std::string>()) {
    plan.frames || is_frame_pattern(input) ? page.add_sequence(input) : page.add_input(input);
  }
  const std::optional<Error> failure = page.print();
  return failure ? exit_code_of(failure->code) : kDone;
}

}  // namespace

std::unique_ptr<Command> make_info_command() {
  return std::make_unique<PlannedCommand<InfoFlags, plan_info, run_info>>(
      CommandWords{"info", "INPUT... [options]", "Show what a file holds, and suggest iso values."});
}

}  // namespace isoextract::cli
