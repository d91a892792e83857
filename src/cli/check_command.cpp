// `isoextract check`: prints the defects of a mesh to stdout, as a table or JSON.
#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/byte_size.hpp"
#include "base/context.hpp"
#include "base/machine.hpp"
#include "base/stopwatch.hpp"
#include "cli/check_plan.hpp"
#include "cli/check_report.hpp"
#include "cli/planned_command.hpp"
#include "cli/progress_bar.hpp"
#include "cli/wrong_file_kind.hpp"
#include "convert/json_values.hpp"
#include "convert/placement_record.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"
#include "mesh/mesh_part.hpp"
#include "mesh_io/mesh_reader.hpp"

namespace isoextract::cli {
namespace {

// Checks one mesh with its normals, welded first if `weld`.
Result<check::MeshCheck> check_one(mesh::Mesh& mesh, const mesh_io::FileNormals& normals,
                                   std::span<const glm::uvec3> normal_numbers, bool weld, const Context& context) {
  if (weld) {
    TRY(check::weld_coincident_vertices(mesh, context));
  }
  auto check = check::check_mesh(mesh, context);
  if (check && !normals.empty()) {
    check->normals = check::check_normals(mesh, normals.values.span(), normal_numbers);
    // This mesh has no normals, but other meshes of the file have normals.
    if (check->normals->corners == 0) check->normals.reset();
  }
  return check;
}

Result<void> check_parts(const CheckPlan& plan, const mesh_io::MeshFile& file, const Context& context,
                         CheckReport& report) {
  for (const mesh_io::MeshPart& part : file.parts) {
    auto mesh = TRY(mesh::copy_part(file.mesh, part, mesh::PartData::positions, context));
    const auto numbers = file.normals.empty()
                             ? std::span<const glm::uvec3>()
                             : file.normals.numbers.span().subspan(part.first_triangle, part.triangles);
    auto check = TRY(check_one(mesh, file.normals, numbers, plan.weld, context));
    report.parts.push_back({part.name, std::move(check)});
  }
  return {};
}

Result<CheckReport> make_report(const CheckPlan& plan, const Messages& messages, const Context& context) {
  CheckReport report;
  report.file = files::input_label(plan.mesh);
  report.welded = plan.weld;
  report.required = plan.required;
  ProgressBar bar(context.progress(), messages.verbosity() != Verbosity::quiet);
  context.progress().begin("reading the mesh", 0);
  auto file = mesh_io::read_mesh(plan.mesh, context, {.normals = true});
  if (!file) return tl::unexpected(add_mesh_file_hint(std::move(file.error()), plan.mesh));
  bar.above([&] {
    for (const Note& note : file->notes) messages.note(note);
  });
  file->mesh.name = report.file;
  report.format = file->format;
  report.is_gltf = file->y_up;  // glTF is the only format that prescribes y up, and meters
  const auto record = convert::parse_placement_record(file->placement);
  if (record) report.unit = convert::find_length_unit(record->placement.to_unit);
  if (report.is_gltf) report.unit = convert::meter();
  report.has_normals = !file->normals.empty();
  TRY(check_parts(plan, *file, context, report));
  report.whole = TRY(check_one(file->mesh, file->normals, file->normals.numbers.span(), plan.weld, context));
  return report;
}

Result<void> meet_requirements(const CheckReport& report) {
  std::vector<std::string_view> words;
  std::vector<std::string> found;
  for (const check::Requirement one : report.required) {
    const auto why = unmet_reason(one, report);
    if (!why) continue;
    words.push_back(word_of(one));
    if (std::ranges::find(found, *why) == found.end()) found.push_back(*why);
  }
  if (words.empty()) return {};
  const auto& joined = report.whole.welded;
  const bool would_close = joined && joined->open_edges == 0 && report.whole.topology.open_edges > 0;
  return fail(ErrorCode::verification,
              fmt::format("{}: the mesh does not meet the requirement{} {}: {}", report.file,
                          words.size() == 1 ? "" : "s", fmt::join(words, ", "), fmt::join(found, "; ")),
              would_close ? "with --weld, which welds vertices at equal positions, the mesh is closed" : "");
}

// Fails with ErrorCode::verification, after the report, if the mesh is not what --require asks for.
Result<void> run_check(const CheckPlan& plan, const Messages& messages) {
  const Stopwatch watch;
  const Context context{plan.memory};
  const auto report = TRY(make_report(plan, messages, context));
  messages.detail(fmt::format("checked in {:.2f} s, peak memory {}", watch.elapsed().wall_seconds,
                              format_byte_size(peak_memory())));
  const std::string json = plan.json || plan.report ? convert::json_text(check_json(report)) : std::string();
  if (plan.report) {
    TRY(files::write_file(*plan.report, json));
  }
  TRY(print_to_stdout(plan.json ? json : check_text(report)));
  return meet_requirements(report);
}

}  // namespace

std::unique_ptr<Command> make_check_command() {
  return std::make_unique<PlannedCommand<CheckFlags, plan_check, run_check>>(
      CommandWords{"check", "MESH [options]", "List the defects of a mesh, for printing or solvers."});
}

}  // namespace isoextract::cli
