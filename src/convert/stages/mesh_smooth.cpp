// The stage that smooths a mesh.
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "convert/stages/surface_stages.hpp"

namespace isoextract::convert {
namespace {

// Returns the box of samples whose outer faces the caps lie on, or nullopt without such caps.
std::optional<field::IndexBox> capped_box(const Source& source) {
  if (source.region) return source.region;
  if (std::holds_alternative<field::SparseSamples>(source.field.samples)) return std::nullopt;
  return source.field.extents();
}

std::string line_of(const SmoothChoice& asked, const edit::SmoothFigures& facts, const std::string& surface) {
  std::string text = fmt::format(
      "smoothed at {}: {} passes of {}, pass band {}; vertices moved by at most {:.4g} voxels, in the mesh's units "
      "{:.4g}",
      surface, asked.passes, word_of(asked.method), asked.pass_band, facts.greatest_move, facts.max_displacement_world);
  if (facts.border_vertices == 0) {
    const double change = facts.volume_before != 0 ? facts.volume_after / facts.volume_before - 1 : 0;
    text += fmt::format("; volume {:.4g} % {}", 100 * std::abs(change), change > 0 ? "more" : "less");
  } else {
    text += fmt::format("; {} vertices of open boundaries stayed in place", facts.border_vertices);
  }
  if (facts.wall_vertices > 0) text += fmt::format("; {} vertices of caps stayed in their planes", facts.wall_vertices);
  return text + fmt::format("; {:.2f} s", facts.time.wall_seconds);
}

}  // namespace

// Smooths the surface. Vertices of caps stay on the faces of the box of samples and in the planes of cuts.
Result<StageReport> smooth_surface(Surface& surface, const StageContext& stage) {
  if (!stage.job.edits.smooth || surface.mesh.triangles.empty()) return StageReport();
  const SmoothChoice& asked = *stage.job.edits.smooth;
  edit::SmoothOptions options;
  options.method = asked.method;
  options.passes = asked.passes;
  options.pass_band = asked.pass_band;
  const field::Affine index_from_output = stage.source.output_from_index.inverse();
  options.to_metric = index_from_output.linear;
  if (stage.job.surface.cap) {
    options.cuts = stage.source.clip;
    if (const auto data = capped_box(stage.source)) {
      options.walls = edit::DataBox{index_from_output.linear, index_from_output.offset, glm::dvec3(data->min),
                                    glm::dvec3(data->max)};
    }
  }
  const edit::SmoothFigures facts = TRY(edit::smooth(surface.mesh, options, stage.context));
  StageReport report = stage.report_on(StageName::smooth, surface);
  report.add_timed(
      {{Key::method, word_of(asked.method)},
       {Key::passes, asked.passes},
       {Key::pass_band, asked.pass_band},
       {Key::vertices, facts.vertices},
       {Key::border_vertices, facts.border_vertices},
       {Key::cap_vertices, facts.wall_vertices},
       {Key::greatest_move, Figures{{Key::voxels, facts.greatest_move}, {Key::world, facts.max_displacement_world}}},
       {Key::volume, Figures{{Key::before, facts.volume_before}, {Key::after, facts.volume_after}}}},
      facts.time);
  report.did = "smoothed";
  report.lines.push_back({line_of(asked, facts, surface.id.name())});
  return report;
}

}  // namespace isoextract::convert
