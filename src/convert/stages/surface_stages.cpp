#include "convert/stages/surface_stages.hpp"

#include <utility>

#include <fmt/format.h>

#include "convert/mesh_packing.hpp"

namespace isoextract::convert {

std::string StageContext::subject(const Surface& surface) const {
  return surface.id.is_only_surface() ? source.label : fmt::format("{} {}", source.label, surface.id.name());
}

StageReport StageContext::report_on(StageName stage, const Surface& surface) const {
  return StageReport(stage, subject(surface), source.label, surface.id);
}

extract::ExtractOptions extract_options_of(const ConversionJob& job, const Source& source, double iso) {
  extract::ExtractOptions options = source.extract_options(job.surface, iso);
  options.smooth_normals = job.normals == Normals::smooth;
  options.shared_origin = mesh_packing(job.meshes().packing, source).quantizes();
  options.edge_keys = job.verify && extract::method_info(job.surface.method).traits.vertices_on_edges;
  return options;
}

OpenBoundary open_boundary_of(const extract::ExtractStats& stats, const extract::ExtractOptions& options,
                              const Source& source) {
  return {.at_data_boundary = stats.meets_boundary && !options.cap,
          .periodic = source.period.has_value(),
          .hole_cells = stats.hole_cells};
}

Result<void> tell(const StageReport& report, Events& events) {
  const bool tells = report.time || !report.entries.empty() || !report.work.empty() || report.output;
  if (tells) events.end(report);
  for (const Note& text : report.notes) events.note(text);
  if (report.error) return tl::unexpected(*report.error);
  return {};
}

Error about_surface(Error error, const std::string& mesh_name, const std::string& subject) {
  const std::string start = mesh_name + ": ";
  if (error.message.starts_with(start)) error.message.replace(0, mesh_name.size(), subject);
  return error;
}

Result<StageReport> run_edit(EditSurface& edit, const StageContext& context, Surface& surface) {
  const std::string name = surface.mesh.name;  // the edit may move the mesh away before it fails
  auto report = edit(surface, context);
  if (!report) return tl::unexpected(about_surface(std::move(report.error()), name, context.subject(surface)));
  return report;
}

Result<void> run_stage(const StageInfo& stage, const StageContext& context, Events& events, Surface& surface) {
  StageReport report = TRY(run_edit(*stage.edit, context, surface));
  if (report.lines.empty() && !report.entries.empty() && !stage.done.empty()) {
    report.lines.push_back(
        {fmt::format("{}{}: {}", stage.done, surface.id.at_text(), text_of(report.entries.front()))});
  }
  return tell(report, events);
}

Result<void> edit_surface(const StageContext& context, Events& events, Surface& surface, const StageRange& range) {
  for (const StageInfo& stage : kStages) {
    if (stage.name < range.first || stage.name > range.last) continue;
    const bool is_of_pieces = stage.name == StageName::normals && context.job.edits.pieces.split;
    if (stage.edit != nullptr && !is_of_pieces) TRY(run_stage(stage, context, events, surface));
  }
  return {};
}

}  // namespace isoextract::convert
