#include "convert/mesh_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/parallel.hpp"
#include "convert/stages/surface_stages.hpp"
#include "mesh/half_space.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::convert {
namespace {

Figures figures_of(const edit::BodyCounts& counts) {
  return {{Key::triangles, counts.triangles}, {Key::components, counts.components}, {Key::bodies, counts.bodies}};
}

std::string line_of(const edit::BodyFigures& facts, const std::string& surface) {
  const edit::BodyCounts& before = facts.before;
  const edit::BodyCounts& after = facts.after;
  const auto cavities = [](const edit::BodyCounts& counts) { return counts.components - counts.bodies; };
  return fmt::format("components{}: kept {} of {}, {} of {}, {} of {}; {:.2f} s", surface, after.bodies,
                     counted(before.bodies, "body", "bodies"), cavities(after),
                     counted(cavities(before), "cavity", "cavities"), after.triangles,
                     counted(before.triangles, "triangle"), facts.time.wall_seconds);
}

}  // namespace

Result<edit::OriginalPositions> voxel_sites(const mesh::Mesh& mesh, const Source& source, const SurfaceOptions& surface,
                                            const Context& context) {
  if (!surface.relaxes()) return edit::OriginalPositions();
  const auto memory = TRY(context.reserve(mesh.positions.size_bytes(), mesh.name + ": the voxels of its components"));
  const double on_plane = 2 * mesh::on_plane_tolerance(mesh::farthest_coordinate(mesh.positions.span()));
  const field::Affine index_from_output = source.output_from_index.inverse();
  edit::OriginalPositions sites(mesh.positions.size());
  for_each_range(sites.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v != end; ++v) {
      const glm::dvec3 place = mesh.position(v);
      const bool is_cut = std::ranges::any_of(
          source.clip, [&](const mesh::HalfSpace& kept) { return std::abs(kept.depth(place)) <= on_plane; });
      const glm::dvec3 corner = glm::floor(index_from_output(place)) + 0.5;
      sites[v] = is_cut ? mesh.positions[v] : glm::vec3(source.output_from_index(corner) - mesh.origin);
    }
  });
  return sites;
}

edit::BodySelection body_selection(const PieceChoice& choice, const Source& source) {
  edit::BodySelection selection;
  if (choice.least) {
    selection.least = choice.least->amount;
    selection.measure = choice.least->measure;
    if (!choice.least->in_world_units) selection.to_metric = glm::inverse(source.output_from_index.linear);
  }
  selection.fill_cavities = choice.fill_cavities;
  selection.largest = choice.largest;
  return selection;
}

Result<StageReport> drop_pieces(Surface& surface, const StageContext& stage) {
  const PieceChoice& choice = stage.job.edits.pieces;
  if (!choice.drops()) return StageReport();
  edit::BodyFigures facts;
  if (surface.bodies) {
    facts = *surface.bodies;
  } else {
    auto sites = TRY(voxel_sites(surface.mesh, stage.source, stage.job.surface, stage.context));
    stage.context.progress().begin("finding components", 0);
    auto kept = TRY(edit::select_bodies(std::move(surface.mesh), body_selection(choice, stage.source), stage.context,
                                        std::move(sites)));
    surface.mesh = std::move(kept.mesh);
    facts = kept.facts;
  }
  StageReport report = stage.report_on(StageName::pieces, surface);
  report.add_timed({{Key::before, figures_of(facts.before)},
                    {Key::after, figures_of(facts.after)},
                    {Key::without_volume, facts.without_volume}},
                   facts.time);
  report.did = "components found";
  report.lines.push_back({line_of(facts, surface.id.at_text())});
  if (facts.without_volume > 0) {
    report.notes.push_back(
        {NoteId::open_components_kept, fmt::format("{}: kept {}, because an open component has no volume to compare",
                                                   report.subject, counted(facts.without_volume, "open component"))});
  }
  if (facts.before.triangles > 0 && surface.triangles() == 0 && stage.job.empty == EmptyPolicy::error) {
    report.error = Error{ErrorCode::no_surface,
                         fmt::format("{}: none of the {}{} has the requested size", stage.source.label,
                                     counted(facts.before.components, "component"), surface.id.at_text()),
                         {Remedy::use, Setting::empty_policy}};
  }
  return report;
}

Result<std::vector<mesh::Mesh>> split_mesh(mesh::Mesh mesh, bool into_files, const Context& context) {
  const std::string name = mesh.name;
  auto pieces = edit::split_into_bodies(std::move(mesh), into_files ? kMaxPieceFiles : kMostPieceMeshes, context);
  if (!pieces) return pieces;
  for (std::size_t i = 0; i < pieces->size(); ++i) (*pieces)[i].name += fmt::format(" piece {}", i + 1);
  if (pieces->empty() && !into_files) pieces->emplace_back().name = name;
  return pieces;
}

std::string piece_path(std::string pattern, std::size_t number) {
  const std::string text = std::to_string(number);
  for (std::size_t at = pattern.find(kPiecePlaceholder); at != std::string::npos;
       at = pattern.find(kPiecePlaceholder, at)) {
    pattern.replace(at, kPiecePlaceholder.size(), text);
    at += text.size();
  }
  return pattern;
}

}  // namespace isoextract::convert
