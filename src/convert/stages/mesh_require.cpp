// The stages that make a surface what --require asks for, and test it.
#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"
#include "check/mesh_check.hpp"
#include "convert/stages/mesh_require.hpp"
#include "convert/stages/mesh_smooth.hpp"
#include "convert/stages/mesh_touching.hpp"
#include "edit/untangle.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::convert {
namespace {

// Returns whether the file stores float32 world coordinates and readers weld vertices with equal coordinates.
bool readers_weld(const ConversionJob& job) {
  const auto* const file = job.writes<MeshFileOptions>();
  return file != nullptr && mesh_io::mesh_format_info(file->format).readers_weld;
}

// Returns the mesh as readers of the file find it, without attributes.
Result<mesh::Mesh> welded_copy(const mesh::Mesh& mesh, const Context& context) {
  mesh::Mesh welded;
  welded.name = mesh.name;
  welded.memory = TRY(context.reserve(mesh.positions.size_bytes() + mesh.triangles.size_bytes(),
                                      mesh.name + ": the mesh as readers weld it"));
  welded.positions = written_positions(mesh);
  welded.triangles = Buffer<glm::uvec3>(mesh.triangles.size());
  std::ranges::copy(mesh.triangles, welded.triangles.begin());
  TRY(check::weld_coincident_vertices(welded, context));
  return welded;
}

std::string line_of(const edit::UntangleFigures& done, const Surface& surface, const Source& source) {
  const std::string place = surface.id.at_text();
  if (done.pairs_before == 0) return fmt::format("no triangles intersect{}; {:.2f} s", place, done.time.wall_seconds);
  return fmt::format(
      "untangled{}: {} of {}{} of intersecting triangles left; flipped "
      "edges: {}, moved vertices: {}, split "
      "edges: {}, in {}; the surface moved by at most {:.3g} {}; {:.2f} "
      "s",
      place, done.pairs_after, done.more_before ? "more than " : "", counted(done.pairs_before, "pair"), done.flips,
      done.moved, done.splits, counted(done.rounds, "round"), done.distance,
      source.of_meshes ? "typical edge lengths" : "voxels", done.time.wall_seconds);
}

bool requires_one(const ConversionJob& job, check::Requirement one) {
  return std::ranges::find(job.edits.require, one) != job.edits.require.end();
}

// Returns whether rounding to the coordinates of the file can merge vertices.
bool rounds_coarsely(const Surface& surface, const ConversionJob& job) {
  constexpr double kMostOfEdge = 0.01;
  if (!readers_weld(job)) return false;
  const double edge = mesh::typical_edge(surface.mesh);
  return mesh::float32_resolution(written_positions(surface.mesh).span()) > kMostOfEdge * edge;
}

// Returns the option that helps the mesh to meet requirements, if one is known.
Hint hint_for(std::span<const check::Requirement> unmet, const Surface& surface, const StageContext& stage) {
  using Requirement = check::Requirement;
  const auto lacks = [&](Requirement one) { return std::ranges::find(unmet, one) != unmet.end(); };
  constexpr std::array kRounded{Requirement::manifold, Requirement::no_zero_area, Requirement::no_duplicates,
                                Requirement::no_self_intersections};
  if (std::ranges::any_of(kRounded, lacks) && rounds_coarsely(surface, stage.job)) {
    return {Remedy::use, Setting::position};
  }
  if (!stage.source.of_meshes) {
    return lacks(Requirement::closed) && surface.open_boundary.at_data_boundary ? Hint(Remedy::use, Setting::cap)
                                                                                : Hint();
  }
  if (stage.job.edits.repair) {
    return lacks(Requirement::closed) ? Hint(Remedy::raise, Setting::hole_edges) : Hint();
  }
  constexpr std::array kRepaired{Requirement::closed, Requirement::oriented, Requirement::outward,
                                 Requirement::no_zero_area, Requirement::no_duplicates};
  return std::ranges::any_of(kRepaired, lacks) ? Hint(Remedy::use, Setting::repair) : Hint();
}

Result<void> check_requirements(const check::MeshCheck& found, const Surface& surface, const StageContext& stage) {
  std::vector<check::Requirement> unmet;
  std::vector<std::string_view> words;
  std::vector<std::string> reasons;
  for (const check::Requirement one : stage.job.edits.require) {
    const auto reason = check::unmet_reason(one, found);
    if (!reason) continue;
    unmet.push_back(one);
    words.push_back(word_of(one));
    if (std::ranges::find(reasons, *reason) == reasons.end()) reasons.push_back(*reason);
  }
  if (unmet.empty()) return {};
  return fail(ErrorCode::verification,
              fmt::format("{}: the mesh does not meet the requirement{} {}: {}", stage.subject(surface),
                          words.size() == 1 ? "" : "s", fmt::join(words, ", "), fmt::join(reasons, "; ")),
              hint_for(unmet, surface, stage));
}

}  // namespace

bool tests_by_parts(std::span<const check::Requirement> required) {
  using Requirement = check::Requirement;
  constexpr std::array kByParts{Requirement::closed, Requirement::manifold, Requirement::oriented,
                                Requirement::no_unused_vertices, Requirement::one_component};
  return std::ranges::all_of(required,
                             [&](Requirement one) { return std::ranges::find(kByParts, one) != kByParts.end(); });
}

Result<void> require_of_parts(const mesh::MeshMeasures& measures, const SurfaceId& id, const StageContext& stage) {
  check::MeshCheck found;
  for (const mesh::ComponentFacts& component : measures.components) found.triangles += component.triangles;
  found.topology = measures.topology;
  Surface surface;
  surface.id = id;
  surface.open_boundary.at_data_boundary = measures.topology.open_edges > 0 && !stage.job.surface.cap;
  return check_requirements(found, surface, stage);
}

Result<StageReport> untangle_surface(Surface& surface, const StageContext& stage) {
  if (!stage.job.edits.untangles() || surface.mesh.triangles.empty()) return StageReport();
  // An open surface fails anyway, and flips and moves leave it open.
  if (requires_one(stage.job, check::Requirement::closed)) {
    const auto topology = TRY(mesh::measure_topology(surface.mesh, stage.context));
    if (topology.open_edges > 0) return StageReport();
  }
  edit::UntangleOptions options;
  options.to_metric = stage.source.output_from_index.inverse().linear;
  // Rounding to the coordinates of the file moves triangles, so it comes first.
  double rounded_by = 0;
  if (readers_weld(stage.job) && surface.mesh.origin != glm::dvec3(0)) {
    Buffer<glm::vec3> rounded = written_positions(surface.mesh);
    for (std::size_t v = 0; v < rounded.size(); ++v) {
      const glm::dvec3 step = glm::dvec3(rounded[v]) - surface.mesh.position(v);
      rounded_by = std::max(rounded_by, glm::length(options.to_metric * step));
    }
    surface.mesh.positions = std::move(rounded);
    surface.mesh.origin = glm::dvec3(0);
  }
  options.walls = box_of_caps(stage);
  if (stage.job.surface.cap) options.cuts = stage.source.clip;
  const edit::UntangleFigures done = TRY(edit::untangle(surface.mesh, options, stage.context));
  surface.untangled_by = rounded_by + done.distance;
  StageReport report = stage.report_on(StageName::untangle, surface);
  report.add_timed({{Key::pairs, Figures{{Key::before, done.pairs_before}, {Key::after, done.pairs_after}}},
                    {Key::flips, done.flips},
                    {Key::moved, done.moved},
                    {Key::splits, done.splits},
                    {Key::greatest_move, done.greatest_move},
                    {Key::distance, done.distance},
                    {Key::passes, done.rounds}},
                   done.time);
  report.did = "untangled";
  report.lines.push_back({line_of(done, surface, stage.source)});
  return report;
}

Result<StageReport> require_properties(Surface& surface, const StageContext& stage) {
  const std::vector<check::Requirement>& required = stage.job.edits.require;
  if (required.empty() || surface.mesh.triangles.empty()) return StageReport();
  check::MeshCheck found;
  if (readers_weld(stage.job)) {
    const mesh::Mesh welded = TRY(welded_copy(surface.mesh, stage.context));
    found = TRY(check::check_mesh(welded, stage.context));
  } else {
    found = TRY(check::check_mesh(surface.mesh, stage.context));
  }
  TRY(check_requirements(found, surface, stage));
  return StageReport();
}

}  // namespace isoextract::convert
