// `isoextract verify`: compares two backends, or a mesh file with a new extraction of its volume, triangle by triangle.
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "accuracy/mesh_match.hpp"
#include "base/byte_size.hpp"
#include "base/counted.hpp"
#include "base/machine.hpp"
#include "base/number_text.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "cli/layout.hpp"
#include "cli/note_printer.hpp"
#include "cli/planned_command.hpp"
#include "cli/progress_bar.hpp"
#include "cli/verification_text.hpp"
#include "cli/wrong_file_kind.hpp"
#include "convert/conversion.hpp"
#include "convert/field_label.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"
#include "convert/placement_record.hpp"
#include "convert/source.hpp"
#include "mesh/join_meshes.hpp"
#include "mesh_io/mesh_reader.hpp"

namespace isoextract::cli {
namespace {

// The new extraction that a mesh is compared with.
struct NewExtraction {
  std::string surface;              // its name in messages
  std::string backend;              // the backend that extracted it
  std::vector<std::string> stages;  // the stages of the job, in order
};

NewExtraction made_anew(const convert::ConversionJob& job, const convert::Outcome& outcome) {
  constexpr std::size_t kMostTold = 10;
  const bool are_labels = job.isos().front().is_label();
  std::string label;
  std::vector<std::string> surfaces;
  for (const convert::StageReport& report : outcome.reports) {
    if (report.stage != convert::StageName::extract) continue;
    label = report.label;
    const auto asked = value_at<std::string>(report.entries.front(), {convert::Key::asked});
    surfaces.push_back(asked && !are_labels ? fmt::format("{} ({})", *asked, report.id->text()) : report.id->text());
  }
  const std::size_t told = surfaces.size() > kMostTold ? kMostTold : surfaces.size();
  NewExtraction anew;
  anew.surface =
      fmt::format("{} {} {}", label, are_labels ? "label" : "iso", fmt::join(std::span(surfaces).first(told), ", "));
  if (told < surfaces.size()) anew.surface += fmt::format(" and {}", counted(surfaces.size() - told, "other"));
  anew.backend = outcome.backend;
  for (const convert::StageInfo& stage : convert::kStages) {
    const bool is_of_mesh = stage.name >= convert::StageName::extract;
    if (is_of_mesh && !stage.done.empty() && (stage.asked == nullptr || stage.asked(job))) {
      anew.stages.emplace_back(stage.done);
    }
  }
  return anew;
}

// Opens the source with the requested iso values.
Result<convert::Source> open_source(const VerifyPlan& plan, const Context& context, convert::Events& events) {
  auto source = convert::open_source(plan.job.source, convert::use_of(plan.job), context, events);
  if (source) source->isos = convert::without_repeats(source->isos);
  return source;
}

// Compares one surface.
Result<convert::VerificationRecord> compare_surface(const VerifyPlan& plan, double iso, convert::Source& source,
                                                    extract::Extractor& first, extract::Extractor& second,
                                                    const Context& context) {
  source.set_inside_side(iso);
  extract::ExtractOptions options = source.extract_options(plan.job.surface, iso);
  const extract::MethodInfo& method = extract::method_info(options.method);
  options.smooth_normals = method.traits.gradient_normals;
  options.edge_keys = method.traits.vertices_on_edges;
  const auto extraction = TRY(first.extract(source.field, options, context));
  return convert::compare_backends(source.field, options, method, extraction.mesh, first, second, context);
}

// Returns an object for one surface, an array for several.
std::string records_json(const std::vector<convert::VerificationRecord>& records) {
  const auto json_of = [](const convert::VerificationRecord& record) {
    const convert::StageReport report = convert::report_of(record, "");
    convert::Json json{{"schema", word_of(convert::JsonDocument::verify)}};
    json.update(entry_of(report, report.entries.front()));
    return json;
  };
  if (records.size() == 1) return convert::json_text(json_of(records.front()));
  convert::Json array = convert::Json::array();
  for (const convert::VerificationRecord& record : records) array.push_back(json_of(record));
  return convert::json_text(array);
}

Result<void> verify_backends(const VerifyPlan& plan, const Messages& messages, const Context& context) {
  const std::unique_ptr<extract::Extractor> first = extract::make_cpu_extractor();
  const auto second = TRY(convert::open_backend(convert::Backend::gpu, {plan.job.backend.gpu}));
  std::vector<convert::VerificationRecord> records;
  std::string label;
  {
    ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
    NotePrinter notes(messages, bar);
    auto source = open_source(plan, context, notes);
    if (!source) return tl::unexpected(add_volume_file_hint(source.error(), plan.job.source.input));
    label = source->label;
    for (const convert::ResolvedIso& iso : source->isos) {
      auto record = TRY(compare_surface(plan, iso.id.iso(), *source, *first, *second.extractor, context));
      records.push_back(std::move(record));
    }
  }
  std::string text;
  for (const convert::VerificationRecord& record : records) {
    text += (text.empty() ? "" : "\n") + verification_table(label, record);
  }
  TRY(print_to_stdout(plan.json ? records_json(records) : text));
  for (const convert::VerificationRecord& record : records) {
    TRY(convert::check_verification(label, record));
  }
  return {};
}

std::string distance_text(const accuracy::MeshMatch& match) {
  if (match.matched == 0) return "no vertex has the same position in both";
  if (match.distance == glm::dvec3(0)) return "identical";
  return fmt::format("largest difference {}, at {}", point_text(match.distance, 9), point_text(match.farthest, 9));
}

std::string match_table(const std::string& path, const NewExtraction& anew, const accuracy::MeshMatch& match) {
  NamedLines lines;
  lines.plain(fmt::format("{} and {}", printable(path), anew.surface));
  lines.add("new surface", fmt::format("by {}: {}", anew.backend, fmt::join(anew.stages, ", ")));
  const auto counts = [&](std::string_view name, const std::array<std::uint64_t, 2>& total,
                          const std::array<std::uint64_t, 2>& only, std::string_view what) {
    lines.add(name, fmt::format("{} and {}; without a match {} and {}{}", total[0], total[1], only[0], only[1], what));
  };
  counts("triangles", match.triangles.total, match.triangles.only, "");
  counts("vertices", match.vertices, match.vertices_only, " positions");
  lines.add("positions", distance_text(match));
  lines.add("allowed", point_text(match.allowed, 9));
  const bool same =
      match.vertices_only == std::array<std::uint64_t, 2>{} && match.triangles.only == std::array<std::uint64_t, 2>{};
  lines.add("same", same ? "yes" : "no");
  return lines.take();
}

// Returns a likely cause of the difference. Pairs are (mesh file, new extraction).
std::string hint_for(const convert::ConversionJob& job, const accuracy::MeshMatch& match) {
  const auto& [theirs, ours] = match.triangles.total;
  if (theirs == 0 || ours == 0) return "";
  if (match.triangles.only[0] == 0 && theirs < ours) {
    return "the mesh is a part of that surface: give the --largest, --drop-components, --fill-cavities, --clip or "
           "--roi "
           "of its conversion";
  }
  if (!job.edits.simplify && theirs < ours && match.vertices_only[0] == 0) {
    return "the mesh looks simplified: give the --simplify or --triangles of its conversion; 'isoextract compare' "
           "measures the distance from a mesh without simplification";
  }
  if (job.edits.simplify && match.matched > 0) {
    return fmt::format(
        "give all options of its conversion. Simplification depends on the last bits of positions. "
        "A mesh of another backend (--backend {}) or version may be as good: 'isoextract compare' "
        "measures its distance from a new mesh",
        word_of(job.backend.backend == convert::Backend::gpu ? convert::Backend::cpu : convert::Backend::gpu));
  }
  if (match.matched > 0 && match.vertices_only[0] > 0 && match.vertices_only[1] == 0) {
    return "the mesh holds more than that surface: give every --iso of its conversion, and --cap if it has caps; leave "
           "out "
           "all other options";
  }
  if (match.vertices_only[0] > match.vertices[0] / 2 || theirs != ours) {
    return "give the --iso or --labels, --method, --roi, --clip, --smooth, --simplify and placement options "
           "of its conversion";
  }
  return "";
}

// Extracts all requested surfaces as one mesh.
Result<mesh::Mesh> extract_again(const VerifyPlan& plan, const Context& context, NotePrinter& events,
                                 convert::Outcome& outcome) {
  convert::MeshCollector made{.checks_files = false};
  outcome = convert::run(plan.job, context, events, {}, nullptr, &made);
  if (outcome.error) return tl::unexpected(add_volume_file_hint(std::move(*outcome.error), plan.job.source.input));
  if (made.meshes.size() == 1) return std::move(made.meshes.front());
  return mesh::join_meshes(made.meshes, context);
}

Result<void> verify_mesh(const VerifyPlan& plan, const Messages& messages, const Context& context) {
  accuracy::MeshMatch match;
  NewExtraction anew;
  {
    ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
    NotePrinter notes(messages, bar);
    context.progress().begin("reading the mesh", 0);
    auto file = mesh_io::read_mesh(*plan.mesh, context);
    if (!file) return tl::unexpected(add_mesh_file_hint(std::move(file.error()), *plan.mesh));
    for (const Note& text : file->notes) notes.note(text);
    if (!file->mesh.attributes.empty()) {
      std::vector<std::string> names;
      for (const mesh::Attribute& attribute : file->mesh.attributes) names.push_back(printable(attribute.name));
      notes.note({NoteId::not_verified, fmt::format("{}: verify does not check attributes and colors of vertices: {}",
                                                    *plan.mesh, fmt::join(names, ", "))});
    }
    VerifyPlan placed = plan;
    const auto record = plan.is_placed ? std::nullopt : convert::parse_placement_record(file->placement);
    if (!record && !plan.is_placed && !file->placement.empty()) {
      notes.note({NoteId::placement_unknown,
                  fmt::format("{}: the file has no readable placement record, so verify assumes the default placement",
                              *plan.mesh)});
    }
    if (record) {
      const bool in_voxels = record->placement.space == convert::Space::index;
      if (in_voxels || record->output_from_world() != convert::default_placement(file->y_up).output_from_world()) {
        const std::string text = convert::placement_text(*record);
        notes.note({NoteId::placement_differs,
                    fmt::format("{}: the file states its own placement, and verify places the surface accordingly: {}",
                                *plan.mesh, text.empty() ? "world coordinates" : text)});
      }
      placed.job.source.placement = record->placement;
    }
    convert::Outcome outcome;
    auto made = extract_again(placed, context, notes, outcome);
    if (!made && record && made.error().code == ErrorCode::placement) {
      return fail(ErrorCode::input, fmt::format("{}: verify cannot apply the placement that this mesh file records: {}",
                                                *plan.mesh, made.error().message));
    }
    if (!made) return tl::unexpected(made.error());
    anew = made_anew(plan.job, outcome);
    match = TRY(accuracy::match_written_mesh(file->mesh, *made, plan.float32_world, context, file->is_quantized));
  }
  const std::vector<std::string> found = accuracy::differences(match, {"the file", "the volume's surface"});
  if (plan.json) {
    convert::Json json{{"schema", word_of(convert::JsonDocument::verify)}};
    json.update(convert::json_of(match, found));
    json["backend"] = anew.backend;
    json["stages"] = anew.stages;
    TRY(print_to_stdout(convert::json_text(json)));
  } else if (auto printed = print_to_stdout(match_table(*plan.mesh, anew, match)); !printed) {
    return printed;
  }
  if (found.empty()) return {};
  return fail(
      ErrorCode::verification,
      fmt::format("{}: the mesh is not the surface of {}: {}", *plan.mesh, anew.surface, fmt::join(found, "; ")),
      hint_for(plan.job, match));
}

// Fails with ErrorCode::verification, after the report on stdout, if something differs.
Result<void> run_verify(const VerifyPlan& plan, const Messages& messages) {
  const Stopwatch watch;
  for (const Note& note : plan.notes) messages.note(note);
  const auto done =
      plan.mesh ? verify_mesh(plan, messages, plan.context) : verify_backends(plan, messages, plan.context);
  messages.detail(fmt::format("verified in {:.2f} s, peak memory {}", watch.elapsed().wall_seconds,
                              format_byte_size(peak_memory())));
  return done;
}

class VerifyCommand final : public PlannedCommand<VerifyFlags, plan_verify, run_verify> {
 public:
  VerifyCommand()
      : PlannedCommand(
            {"verify", "INPUT --iso V [MESH] [options]", "Check a mesh against its volume, or GPU against CPU."}) {}

  [[nodiscard]] std::string hint_for_default_command_option(std::string_view option) const override {
    return fmt::format(
        "leave {} out: of the options of {}, {} takes only those that change triangles of an extracted surface", option,
        default_command(program()).name(), name());
  }
};

}  // namespace

std::unique_ptr<Command> make_verify_command() { return std::make_unique<VerifyCommand>(); }

}  // namespace isoextract::cli
