#include "convert/stages/mesh_hollow.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/stopwatch.hpp"
#include "convert/detail/place_report.hpp"
#include "convert/placement.hpp"
#include "convert/stages/surface_stages.hpp"
#include "extract/inner_wall.hpp"
#include "mesh/attributes.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::convert {
namespace {

// Returns the thickness in the mesh's units.
Result<double> thickness_of(const HollowChoice& choice, const Source& source) {
  if (choice.unit == kVoxelUnit) {
    return choice.thickness * std::cbrt(std::abs(source.output_from_index.determinant()));
  }
  if (choice.unit == kWorldUnit) return choice.thickness;
  const auto asked = find_length_unit(choice.unit);
  const auto unit = find_length_unit(unit_of_lengths(source.placement.placement, source.field));
  if (asked && unit) return choice.thickness * unit_ratio(*asked, *unit);
  return fail(
      ErrorCode::input,
      fmt::format("{}: a wall of {:.6g} {} needs the unit of the mesh, but neither the file nor an option states "
                  "the unit",
                  source.label, choice.thickness, choice.unit),
      {{Remedy::give, Setting::unit},
       {Remedy::set, Setting::hollow,
        fmt::format("{:.6g}world for a thickness in the units of the mesh", choice.thickness)}});
}

// Appends the wall to the surface, whose own vertices and triangles stay.
void append(const extract::InnerWall& wall, mesh::Mesh& mesh) {
  const std::size_t before = mesh.positions.size();
  const std::size_t added = wall.mesh.positions.size();
  Buffer<std::uint32_t> old_of_new(before + added);
  std::iota(old_of_new.begin(), old_of_new.begin() + before, 0U);
  std::ranges::copy(wall.nearest_vertices, old_of_new.begin() + before);
  mesh.edges = {};
  mesh::gather_vertices(mesh, std::as_const(old_of_new).span());
  std::ranges::copy(wall.mesh.positions, mesh.positions.begin() + before);
  if (!mesh.normals.empty()) std::ranges::copy(wall.mesh.normals, mesh.normals.begin() + before);
  Buffer<glm::uvec3> triangles(mesh.triangles.size() + wall.mesh.triangles.size());
  std::ranges::copy(mesh.triangles.span(), triangles.begin());
  std::ranges::transform(wall.mesh.triangles, triangles.begin() + mesh.triangles.size(),
                         [&](const glm::uvec3& t) { return t + static_cast<std::uint32_t>(before); });
  mesh.triangles = std::move(triangles);
}

}  // namespace

double wall_cell(double thickness, const Source& source) {
  constexpr double kCellsPerWall = 4;
  double cell = thickness / kCellsPerWall;
  if (source.of_meshes) return cell;
  const glm::dmat3& axes = source.output_from_index.linear;
  for (int axis = 0; axis < 3; ++axis) cell = std::min(cell, glm::length(axes[axis]));
  return cell;
}

double thickness_or_zero(const HollowChoice& choice, const Source& source) {
  return thickness_of(choice, source).value_or(0);
}

Result<StageReport> hollow_surface(Surface& surface, const StageContext& stage) {
  if (!stage.job.edits.hollow || surface.mesh.triangles.empty()) return StageReport();
  const Stopwatch watch;
  const Context& context = stage.context;
  const mesh::Topology topology = TRY(mesh::measure_topology(surface.mesh, context));
  if (topology.open_edges > 0) {
    Hint hint;
    if (surface.open_boundary.at_data_boundary || surface.open_boundary.cut) hint = Hint(Remedy::use, Setting::cap);
    if (stage.source.of_meshes && !surface.open_boundary.cut) hint = Hint(Remedy::use, Setting::repair);
    return fail(ErrorCode::input,
                fmt::format("{}: only a closed surface can be hollow, and this one has {}", stage.subject(surface),
                            counted(topology.open_edges, "boundary edge")),
                hint);
  }
  const HollowChoice& choice = *stage.job.edits.hollow;
  const double thickness = TRY(thickness_of(choice, stage.source));
  const double cell = wall_cell(thickness, stage.source);
  extract::InnerWall wall = TRY(extract::make_inner_wall(surface.mesh, {thickness, cell}, context));
  const extract::WallFigures facts = wall.figures;
  const std::uint64_t triangles = wall.mesh.triangles.size();
  const double cavity_volume = triangles > 0 ? -mesh::measure_size(wall.mesh).volume : 0;
  if (triangles > 0) {
    auto memory = TRY(context.reserve((surface.mesh.positions.size() + wall.mesh.positions.size()) *
                                              (mesh::vertex_bytes(surface.mesh) + sizeof(std::uint32_t)) +
                                          (surface.mesh.triangles.size() + triangles) * sizeof(glm::uvec3),
                                      stage.subject(surface) + ": its inner wall"));
    append(wall, surface.mesh);
    surface.mesh.memory = std::move(memory);
  }
  StageReport report = stage.report_on(StageName::hollow, surface);
  report.add_timed({{Key::asked, thickness},
                    {Key::step, cell},
                    {Key::cavities, facts.cavities},
                    {Key::bodies, facts.loose_walls},
                    {Key::triangles, triangles},
                    {Key::volume, cavity_volume},
                    {Key::min, triangles > 0 ? Value(facts.thinnest) : Value()},
                    {Key::max, triangles > 0 ? Value(facts.thickest) : Value()},
                    {Key::rms, triangles > 0 ? Value(facts.rms_difference) : Value()}},
                   watch.elapsed());
  report.did = "hollowed";
  if (facts.cavities == 0) {
    report.notes.push_back(
        {NoteId::no_effect, fmt::format("{}: no part is thicker than two walls of {:.4g}{} each, {:.4g} in the units "
                                        "of the mesh, so the surface stays solid; a thinner wall can leave a cavity",
                                        stage.subject(surface), choice.thickness, choice.unit, thickness)});
    report.lines.push_back(
        {fmt::format("hollowed{}: no cavity; {:.2f} s", surface.id.at_text(), watch.elapsed().wall_seconds)});
    return report;
  }
  std::string text = fmt::format(
      "hollowed{}: wall of {:.4g}; {} of volume {:.4g}, {}; measured thickness {:.4g} to {:.4g}, typical "
      "difference {:.2g} (cells of {:.4g})",
      surface.id.at_text(), thickness, counted(facts.cavities, "cavity", "cavities"), cavity_volume,
      counted(triangles, "triangle"), facts.thinnest, facts.thickest, facts.rms_difference, cell);
  if (facts.loose_walls == 1) text += "; 1 wall around a cavity of the surface does not touch the outer wall";
  if (facts.loose_walls > 1) {
    text += fmt::format("; {} walls around cavities of the surface do not touch the outer wall", facts.loose_walls);
  }
  report.lines.push_back({text + fmt::format("; {:.2f} s", watch.elapsed().wall_seconds)});
  return report;
}

}  // namespace isoextract::convert
