#include "cli/verify_command.hpp"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/byte_size.hpp"
#include "base/machine.hpp"
#include "base/stopwatch.hpp"
#include "cli/layout.hpp"
#include "cli/progress_bar.hpp"
#include "cli/verification_text.hpp"
#include "convert/source.hpp"
#include "measure/mesh_match.hpp"
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

Result<void> verify_backends(const VerifyPlan& plan, const Messages& messages, const Context& context) {
  const std::unique_ptr<extract::Extractor> first = extract::make_cpu_extractor();
  const auto second = convert::open_backend(convert::Backend::gpu, {plan.gpu});
  if (!second) return tl::unexpected(second.error());
  convert::VerificationRecord record;
  std::string label;
  {
    ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
    Notes notes(messages, bar);
    const auto source = convert::open_source(plan.source, false, context, notes);
    if (!source) return tl::unexpected(source.error());
    label = source->label;
    extract::ExtractOptions options = source->extract_options(plan.surface, plan.iso);
    const extract::MethodInfo& method = extract::method_info(options.method);
    options.smooth_normals = method.traits.gradient_normals;
    options.edge_keys = method.traits.vertices_on_edges;
    const auto extraction = first->extract(source->field, options, context);
    if (!extraction) return tl::unexpected(extraction.error());
    auto compared = convert::compare_backends(source->field, options, method, extraction->mesh, *first,
                                              *second->extractor, context);
    if (!compared) return tl::unexpected(std::move(compared.error()));
    record = std::move(*compared);
  }
  const std::string text = plan.json ? convert::json_text(convert::json_of(record)) : verification_table(label, record);
  if (auto printed = print_to_stdout(text); !printed) return printed;
  return convert::check_verification(label, record);
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
  const bool exact = match.distance == glm::dvec3(0);
  lines.add("positions", exact ? std::string("the very same numbers")
                               : fmt::format("at most {} apart, at {}", measure::point_text(match.distance),
                                             measure::point_text(match.farthest)));
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
  if (match.vertices_only[0] > match.vertices[0] / 2) {
    return "give the --iso, --method, --roi and placement options that it was written with";
  }
  return "";
}

Result<void> verify_mesh(const VerifyPlan& plan, const Messages& messages, const Context& context) {
  const std::unique_ptr<extract::Extractor> extractor = extract::make_cpu_extractor();
  measure::MeshMatch match;
  std::string surface;
  {
    ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
    Notes notes(messages, bar);
    context.progress().begin("reading the mesh", 0);
    auto file = meshes::read_mesh(*plan.mesh, context);
    if (!file) return tl::unexpected(std::move(file.error()));
    for (const std::string& text : file->notes) notes.note(text);
    const auto source = convert::open_source(plan.source, false, context, notes);
    if (!source) return tl::unexpected(source.error());
    surface = fmt::format("{} iso {}", source->label, plan.iso);
    const auto extraction = extractor->extract(source->field, source->extract_options(plan.surface, plan.iso), context);
    if (!extraction) return tl::unexpected(extraction.error());
    const auto matched = measure::match_meshes(file->mesh, extraction->mesh, plan.float32_world, context);
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
