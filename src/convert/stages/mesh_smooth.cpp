#include "convert/stages/mesh_smooth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/reserved_buffer.hpp"
#include "convert/attribute_source.hpp"
#include "points/attribute_sampling.hpp"
#include "points/neighbor_counts.hpp"

namespace isoextract::convert {
namespace {

// Returns the box of samples of a field with bounds.
std::optional<field::IndexBox> capped_box(const Source& source) {
  if (source.region) return source.region;
  if (std::holds_alternative<field::SparseSamples>(source.field.samples)) return std::nullopt;
  return source.field.extents();
}

std::string line_of(const SmoothChoice& asked, const edit::SmoothFigures& facts, const Surface& surface,
                    const Source& source) {
  std::string text = fmt::format(
      "smoothed{}: {} of {}, {}; vertices moved by at most {}", surface.id.at_text(),
      counted(asked.passes, "pass", "passes"), word_of(asked.method),
      facts.mean_weight ? fmt::format("mean weight {:.3g}", *facts.mean_weight)
                        : fmt::format("pass band {}", asked.pass_band),
      source.length_text(fmt::format("{:.4g}", facts.greatest_move), fmt::format("{:.4g}", facts.greatest_move_world)));
  if (facts.boundary_vertices == 0) {
    const double change = facts.volume_before != 0 ? facts.volume_after / facts.volume_before - 1 : 0;
    text += fmt::format("; volume {:.4g} % {}", 100 * std::abs(change), change > 0 ? "more" : "less");
  } else {
    text +=
        fmt::format("; {} on boundary edges stayed in place", counted(facts.boundary_vertices, "vertex", "vertices"));
  }
  if (facts.wall_vertices > 0)
    text += fmt::format("; {} of caps stayed in their planes", counted(facts.wall_vertices, "vertex", "vertices"));
  if (facts.held_vertices > 0) {
    text += fmt::format("; {} moved less, so that no triangles intersect",
                        counted(facts.held_vertices, "vertex", "vertices"));
  }
  return text + fmt::format("; {:.2f} s", facts.time.wall_seconds);
}

// Returns the weights of the vertices: points::smoothing_weight() of the interpolated neighbor counts.
Result<std::shared_ptr<ReservedBuffer<float>>> vertex_weights(const NeighborCounts& neighbors, const Source& source,
                                                              const mesh::Mesh& mesh, const Context& context) {
  const field::Affine world_from_output = source.field.index_to_world.after(source.output_from_index.inverse());
  const auto places = TRY(world_positions(world_from_output, mesh, context));
  const auto sampled =
      TRY(points::sample_attributes(*neighbors.particles, std::array{neighbors.attribute}, places->values.span(),
                                    neighbors.radius, neighbors.smoothing_length, context));
  auto weights = make_reserved_buffer<float>(mesh.positions.size(), context, mesh.name + ": weights of vertices");
  if (!weights) return weights;
  std::ranges::transform(sampled.attributes.front().values, (*weights)->values.begin(), [](float count) {
    return static_cast<float>(points::smoothing_weight(static_cast<double>(count)));
  });
  return weights;
}

}  // namespace

std::optional<edit::DataBox> box_of_caps(const StageContext& stage) {
  if (!stage.job.surface.cap) return std::nullopt;
  const auto data = capped_box(stage.source);
  if (!data) return std::nullopt;
  const field::Affine index_from_output = stage.source.output_from_index.inverse();
  return edit::DataBox{index_from_output.linear, index_from_output.offset, glm::dvec3(data->min),
                       glm::dvec3(data->max)};
}

// Smooths the surface. Vertices of caps stay on the faces of the box of samples and in the planes of cuts.
Result<StageReport> smooth_surface(Surface& surface, const StageContext& stage) {
  if (!stage.job.edits.smooth || surface.mesh.triangles.empty()) return StageReport();
  const SmoothChoice& asked = *stage.job.edits.smooth;
  edit::SmoothOptions options;
  options.method = asked.method;
  options.passes = asked.passes;
  options.pass_band = asked.pass_band;
  options.to_metric = stage.source.output_from_index.inverse().linear;
  options.walls = box_of_caps(stage);
  if (stage.job.surface.cap) options.cuts = stage.source.clip;
  std::shared_ptr<ReservedBuffer<float>> weights;
  if (stage.source.neighbors) {
    weights = TRY(vertex_weights(*stage.source.neighbors, stage.source, surface.mesh, stage.context));
    options.weights = std::as_const(weights->values).span();
  }
  const edit::SmoothFigures facts = TRY(edit::smooth(surface.mesh, options, stage.context));
  StageReport report = stage.report_on(StageName::smooth, surface);
  report.add_timed(
      {{Key::method, word_of(asked.method)},
       {Key::passes, asked.passes},
       {Key::pass_band, facts.mean_weight ? Value() : Value(asked.pass_band)},
       {Key::mean_weight, facts.mean_weight ? Value(*facts.mean_weight) : Value()},
       {Key::vertices, facts.vertices},
       {Key::border_vertices, facts.boundary_vertices},
       {Key::cap_vertices, facts.wall_vertices},
       {Key::held_vertices, facts.held_vertices},
       {Key::greatest_move, Figures{{Key::voxels, facts.greatest_move}, {Key::world, facts.greatest_move_world}}},
       {Key::volume, Figures{{Key::before, facts.volume_before}, {Key::after, facts.volume_after}}},
       {Key::zero_area_triangles, Figures{{Key::before, facts.zero_area_before}, {Key::after, facts.zero_area_after}}}},
      facts.time);
  report.did = "smoothed";
  report.lines.push_back({line_of(asked, facts, surface, stage.source)});
  if (facts.zero_area_after > facts.zero_area_before) {
    report.notes.push_back(
        {NoteId::zero_area,
         fmt::format("{}: smoothing left {} of {} triangles without area (before: {})", report.subject,
                     facts.zero_area_after, surface.mesh.triangles.size(), facts.zero_area_before)});
  }
  return report;
}

}  // namespace isoextract::convert
