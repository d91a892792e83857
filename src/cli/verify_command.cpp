#include "cli/verify_command.hpp"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/byte_size.hpp"
#include "base/machine.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "cli/layout.hpp"
#include "cli/progress_bar.hpp"
#include "cli/verification_text.hpp"
#include "convert/mesh_clip.hpp"
#include "convert/placement_record.hpp"
#include "convert/source.hpp"
#include "measure/mesh_match.hpp"
#include "mesh/joined.hpp"
#include "meshes/mesh_reader.hpp"

namespace isoextract::cli {
namespace {

// Notes alone: the rest is told by what is found.
class Notes final : public convert::Events {
 public:
  Notes(const Messages& messages, ProgressBar& bar) : messages_(messages), bar_(bar) {}
  void note(const std::string& text) override {
    bar_.above([&] { messages_.note(text); });
  }

 private:
  const Messages& messages_;
  ProgressBar& bar_;
};

// The samples of the source with the iso values that were asked for.
Result<convert::Source> open_source(const VerifyPlan& plan, const Context& context, convert::Events& events) {
  convert::SourceUse use;
  use.isos = plan.isos;
  use.closed = convert::closes_regions(plan.surface);
  auto source = convert::open_source(plan.source, use, context, events);
  if (source) source->isos = convert::each_once(source->isos);  // a mesh has one surface of each value
  return source;
}

// Of one surface.
Result<convert::VerificationRecord> compare_surface(const VerifyPlan& plan, double iso, convert::Source& source,
                                                    extract::Extractor& first, extract::Extractor& second,
                                                    const Context& context) {
  source.face_outward(iso);
  extract::ExtractOptions options = source.extract_options(plan.surface, iso);
  const extract::MethodInfo& method = extract::method_info(options.method);
  options.smooth_normals = method.traits.gradient_normals;
  options.edge_keys = method.traits.vertices_on_edges;
  const auto extraction = first.extract(source.field, options, context);
  if (!extraction) return tl::unexpected(extraction.error());
  return convert::compare_backends(source.field, options, method, extraction->mesh, first, second, context);
}

// One surface as an object, several as an array of them.
std::string records_json(const std::vector<convert::VerificationRecord>& records) {
  if (records.size() == 1) return convert::json_text(convert::json_of(records.front()));
  convert::Json array = convert::Json::array();
  for (const convert::VerificationRecord& record : records) array.push_back(convert::json_of(record));
  return convert::json_text(array);
}

Result<void> verify_backends(const VerifyPlan& plan, const Messages& messages, const Context& context) {
  const std::unique_ptr<extract::Extractor> first = extract::make_cpu_extractor();
  const auto second = convert::open_backend(convert::Backend::gpu, {plan.gpu});
  if (!second) return tl::unexpected(second.error());
  std::vector<convert::VerificationRecord> records;
  std::string label;
  {
    ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
    Notes notes(messages, bar);
    auto source = open_source(plan, context, notes);
    if (!source) return tl::unexpected(source.error());
    label = source->label;
    for (const convert::ResolvedIso& iso : source->isos) {
      auto record = compare_surface(plan, iso.value, *source, *first, *second->extractor, context);
      if (!record) return tl::unexpected(std::move(record.error()));
      records.push_back(std::move(*record));
    }
  }
  std::string text;
  for (const convert::VerificationRecord& record : records) {
    text += (text.empty() ? "" : "\n") + verification_table(label, record);
  }
  if (auto printed = print_to_stdout(plan.json ? records_json(records) : text); !printed) return printed;
  for (const convert::VerificationRecord& record : records) {
    if (auto same = convert::check_verification(label, record); !same) return same;
  }
  return {};
}

std::string distance_text(const measure::MeshMatch& match) {
  if (match.matched == 0) return "none is at the same place in both";
  if (match.distance == glm::dvec3(0)) return "the very same numbers";
  return fmt::format("at most {} apart, at {}", measure::point_text(match.distance),
                     measure::point_text(match.farthest));
}

std::string match_table(const std::string& path, const std::string& surface, const measure::MeshMatch& match) {
  NamedLines lines;
  lines.plain(fmt::format("{} and {}", path, surface));
  const auto counts = [&](std::string_view name, const std::array<std::uint64_t, 2>& total,
                          const std::array<std::uint64_t, 2>& only, std::string_view what) {
    lines.add(name, fmt::format("{} and {}; {} and {} {} only", total[0], total[1], only[0], only[1], what));
  };
  counts("triangles", match.triangles.total, match.triangles.only, "in one");
  counts("vertices", match.vertices, match.vertices_only, "places in one");
  lines.add("positions", distance_text(match));
  lines.add("allowed", measure::point_text(match.allowed));
  const bool same =
      match.vertices_only == std::array<std::uint64_t, 2>{} && match.triangles.only == std::array<std::uint64_t, 2>{};
  lines.add("same", same ? "yes" : "no");
  return lines.take();
}

// What may have made the meshes different.
std::string hint_for(const measure::MeshMatch& match) {
  const bool fewer = match.triangles.total[0] < match.triangles.total[1];
  if (fewer && match.vertices_only[0] == 0 && match.triangles.only[0] > 0) {
    return "it looks simplified: 'isoextract compare' measures how far it is from a mesh that was written without "
           "--simplify";
  }
  if (match.matched > 0 && match.vertices_only[0] > 0 && match.vertices_only[1] == 0) {
    return "it holds more than that: give every --iso, and --cap if it was written with it";
  }
  if (match.vertices_only[0] > match.vertices[0] / 2) {
    return "give the --iso, --method, --roi and placement options that it was written with";
  }
  return "";
}

// All surfaces that were asked for.
Result<mesh::Mesh> extract_all(const VerifyPlan& plan, convert::Source& source, const Context& context,
                               convert::Events& events) {
  const std::unique_ptr<extract::Extractor> extractor = extract::make_cpu_extractor();
  std::vector<mesh::Mesh> meshes;
  for (const convert::ResolvedIso& iso : source.isos) {
    source.face_outward(iso.value);
    auto extraction = extractor->extract(source.field, source.extract_options(plan.surface, iso.value), context);
    if (!extraction) return tl::unexpected(std::move(extraction.error()));
    auto clipped = convert::clip_mesh(extraction->mesh, source.clip, convert::cut_ends(plan.surface), source.label,
                                      context, events);
    if (!clipped) return tl::unexpected(std::move(clipped.error()));
    meshes.push_back(std::move(extraction->mesh));
  }
  if (meshes.size() == 1) return std::move(meshes.front());
  return mesh::join_meshes(meshes, context);
}

Result<void> verify_mesh(const VerifyPlan& plan, const Messages& messages, const Context& context) {
  measure::MeshMatch match;
  std::string surface;
  {
    ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
    Notes notes(messages, bar);
    context.progress().begin("reading the mesh", 0);
    auto file = meshes::read_mesh(*plan.mesh, context);
    if (!file) return tl::unexpected(std::move(file.error()));
    for (const std::string& text : file->notes) notes.note(text);
    if (!file->mesh.attributes.empty()) {
      std::vector<std::string> names;
      for (const mesh::Attribute& attribute : file->mesh.attributes) names.push_back(printable(attribute.name));
      notes.note(fmt::format("{}: attributes and colours of its vertices are not verified: {}", *plan.mesh,
                             fmt::join(names, ", ")));
    }
    VerifyPlan placed = plan;
    if (const auto record = plan.is_placed ? std::nullopt : convert::read_record(file->placement)) {
      notes.note(fmt::format("{}: it says that it was placed otherwise than usual, and the surface is placed so: {}",
                             *plan.mesh, convert::placement_text(*record)));
      placed.source.placement = record->placement;
    }
    auto source = open_source(placed, context, notes);
    if (!source) return tl::unexpected(source.error());
    std::vector<std::string> isos;
    for (const convert::ResolvedIso& iso : source->isos) isos.push_back(text_of(iso));
    surface = fmt::format("{} iso {}", source->label, fmt::join(isos, ", "));
    const auto extracted = extract_all(plan, *source, context, notes);
    if (!extracted) return tl::unexpected(extracted.error());
    const auto matched = measure::match_meshes(file->mesh, *extracted, plan.float32_world, context);
    if (!matched) return tl::unexpected(matched.error());
    match = *matched;
  }
  const std::vector<std::string> found = measure::differences(match, {"the file", "the volume's surface"});
  const std::string text =
      plan.json ? convert::json_text(convert::json_of(match, found)) : match_table(*plan.mesh, surface, match);
  if (auto printed = print_to_stdout(text); !printed) return printed;
  if (found.empty()) return {};
  return fail(ErrorKind::verification,
              fmt::format("{}: it is not the surface of {}: {}", *plan.mesh, surface, fmt::join(found, "; ")),
              hint_for(match));
}

}  // namespace

Result<void> run_verify(const VerifyPlan& plan, const Messages& messages) {
  const Stopwatch watch;
  for (const std::string& note : plan.notes) messages.note(note);
  const Context context{plan.memory};
  const auto done = plan.mesh ? verify_mesh(plan, messages, context) : verify_backends(plan, messages, context);
  messages.detail(fmt::format("verified in {:.2f} s, peak memory {}", watch.elapsed().wall_seconds,
                              format_byte_size(peak_memory())));
  return done;
}

}  // namespace isoextract::cli
