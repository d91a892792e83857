// The stage that repairs a mesh file.
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"
#include "check/mesh_check.hpp"
#include "convert/stages/surface_stages.hpp"
#include "edit/repair.hpp"

namespace isoextract::convert {
namespace {

std::string steps_text(const edit::RepairFigures& facts, const RepairChoice& choice) {
  std::vector<std::string> steps;
  if (facts.welded > 0) steps.push_back(fmt::format("welded {}", counted(facts.welded, "vertex position")));
  if (facts.without_area > 0) {
    steps.push_back(fmt::format("removed or repaired {} without area", counted(facts.without_area, "triangle")));
  }
  if (facts.duplicates > 0) steps.push_back(fmt::format("dropped {}", counted(facts.duplicates, "duplicate triangle")));
  if (facts.turned > 0) steps.push_back(fmt::format("flipped {}", counted(facts.turned, "triangle")));
  if (facts.holes_filled > 0) {
    steps.push_back(fmt::format("filled {} with {}", counted(facts.holes_filled, "hole"),
                                counted(facts.fill_triangles, "triangle")));
  }
  if (facts.vertices_split > 0) {
    steps.push_back(
        fmt::format("added {} of vertices where sheets touch", counted(facts.vertices_split, "copy", "copies")));
  }
  if (facts.unused_removed > 0) {
    steps.push_back(fmt::format("removed {} without a triangle", counted(facts.unused_removed, "vertex", "vertices")));
  }
  if (facts.components_turned > 0) {
    steps.push_back(fmt::format("flipped the winding of {}", counted(facts.components_turned, "component")));
  }
  if (steps.empty()) steps.emplace_back("nothing to do");
  if (facts.holes_left > 0) {
    const std::string all = counted(facts.holes_left, "hole");
    steps.push_back(facts.holes_too_long == 0 ? fmt::format("left {} open", all)
                                              : fmt::format("left {} open, {} of more than {} edges", all,
                                                            facts.holes_too_long, choice.most_hole_edges));
  }
  if (facts.contradictions > 0) {
    steps.push_back(fmt::format("{} in one-sided patches", counted(facts.contradictions, "edge keeps opposite windings",
                                                                   "edges keep opposite windings")));
  }
  return fmt::format("{}", fmt::join(steps, ", "));
}

// Returns what `check` finds: "printable", or what the mesh lacks.
std::string verdict_of(const check::MeshCheck& found) {
  using Requirement = check::Requirement;
  std::vector<std::string> lacks;
  for (const Requirement one :
       {Requirement::closed, Requirement::manifold, Requirement::oriented, Requirement::outward,
        Requirement::no_self_intersections, Requirement::no_zero_area, Requirement::no_duplicates}) {
    if (const auto why = check::unmet_reason(one, found)) lacks.push_back(*why);
  }
  return lacks.empty() ? std::string("printable") : fmt::format("not printable: {}", fmt::join(lacks, "; "));
}

}  // namespace

Result<StageReport> repair_surface(Surface& surface, const StageContext& stage) {
  const std::optional<RepairChoice>& choice = stage.job.edits.repair;
  if (!choice || surface.mesh.triangles.empty()) return StageReport();
  const std::uint64_t before = surface.mesh.triangles.size();
  const edit::RepairFigures facts = TRY(edit::repair(surface.mesh, {choice->most_hole_edges}, stage.context));
  stage.context.progress().begin("checking", 0);
  const std::string verdict = verdict_of(TRY(check::check_mesh(surface.mesh, stage.context)));
  StageReport report = stage.report_on(StageName::repair, surface);
  report.add_timed({{Key::triangles_before, before},
                    {Key::triangles_after, surface.mesh.triangles.size()},
                    {Key::welded, facts.welded},
                    {Key::without_area, facts.without_area},
                    {Key::duplicates, facts.duplicates},
                    {Key::turned, facts.turned},
                    {Key::contradictions, facts.contradictions},
                    {Key::holes_filled, facts.holes_filled},
                    {Key::fill_triangles, facts.fill_triangles},
                    {Key::holes_left, facts.holes_left},
                    {Key::vertices_split, facts.vertices_split},
                    {Key::unused_removed, facts.unused_removed},
                    {Key::components_turned, facts.components_turned},
                    {Key::verdict, verdict}},
                   facts.time);
  report.did = "repaired";
  if (facts.values_lost > 0) {
    report.notes.push_back(
        {NoteId::corners_joined,
         fmt::format("{}: the repair drops the attributes of {} of {}, because they differ from those of the remaining "
                     "vertex at the same position",
                     report.subject, facts.values_lost, counted(facts.welded, "merged vertex", "merged vertices"))});
  }
  report.lines.push_back({fmt::format("repaired{}: {}; then {}; {:.2f} s", surface.id.at_text(),
                                      steps_text(facts, *choice), verdict, facts.time.wall_seconds)});
  return report;
}

}  // namespace isoextract::convert
