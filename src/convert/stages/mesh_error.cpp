// The stage that measures the distance of a mesh from its isosurface.
#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "accuracy/analytic_error.hpp"
#include "accuracy/field_error.hpp"
#include "base/counted.hpp"
#include "base/number_text.hpp"
#include "base/stopwatch.hpp"
#include "convert/stages/surface_stages.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {
namespace {

struct MeshError {
  accuracy::FieldError field;
  std::optional<accuracy::AnalyticError> analytic;  // for demo fields with a formula
  // Exact area and volume in the mesh's units, if known; nullopt for a part of the surface.
  std::optional<field::SurfaceSize> exact;
  bool of_part = false;  // a region or clipping may have removed a part of the surface
};

Figures figures_of(const accuracy::Length& length) {
  return {{Key::voxels, length.voxels}, {Key::world, length.world}};
}

Figures figures_of(const accuracy::ErrorStatistics& error) {
  Figures figures{{Key::points, error.points}};
  if (error.points > 0) {
    figures.insert(figures.end(), {{Key::rms, figures_of(error.rms)},
                                   {Key::percentile99, figures_of(error.percentile99)},
                                   {Key::max, figures_of(error.max)},
                                   {Key::worst, Value(error.worst)}});
  }
  figures.insert(figures.end(), {{Key::not_finite, error.not_finite},
                                 {Key::outside, error.outside},
                                 {Key::unreached, error.unreached},
                                 {Key::corrected, error.corrected}});
  return figures;
}

Value angles_value(const accuracy::AngleStatistics& angles) {
  if (angles.points == 0) return Value();
  return Value(Figures{
      {Key::points, angles.points}, {Key::rms_degrees, angles.rms_degrees}, {Key::max_degrees, angles.max_degrees}});
}

Value size_value(double measured, double exact) {
  return Value(Figures{{Key::measured, measured}, {Key::exact, exact}, {Key::relative_error, measured / exact - 1}});
}

Figures figures_of(const accuracy::AnalyticError& analytic, const std::optional<field::SurfaceSize>& exact) {
  return {{Key::closed_form, analytic.closed_form},
          {Key::interior, figures_of(analytic.interior)},
          {Key::vertices, figures_of(analytic.vertices)},
          {Key::smooth_normals, angles_value(analytic.smooth_normals)},
          {Key::flat_normals, angles_value(analytic.flat_normals)},
          {Key::area, exact ? size_value(analytic.area, exact->area) : Value()},
          {Key::volume, exact && analytic.volume ? size_value(*analytic.volume, exact->volume) : Value()}};
}

Figures figures_of(const accuracy::SurfaceCoverage& coverage, int parts) {
  Figures figures{{Key::distances, figures_of(coverage.distances)},
                  {Key::parts, parts},
                  {Key::components, coverage.components},
                  {Key::lost_components, coverage.lost}};
  if (coverage.distances.points > 0) figures.emplace_back(Key::max_at_most, figures_of(coverage.max_at_most));
  return figures;
}

Figures figures_of(const MeshError& error) {
  const accuracy::FieldError& field = error.field;
  return {{Key::interpolant, word_of(field.interpolation)},
          {Key::interior, figures_of(field.interior)},
          {Key::vertices, figures_of(field.vertices)},
          {Key::storage, figures_of(field.storage)},
          {Key::cap_triangles, field.cap_triangles},
          {Key::coverage, field.coverage ? Value(figures_of(*field.coverage, field.parts)) : Value()},
          {Key::analytic, error.analytic ? Value(figures_of(*error.analytic, error.exact)) : Value()}};
}

std::string sizes_text(const accuracy::ErrorStatistics& error) {
  return fmt::format("rms {:.3g}, 99 % {:.3g}, max {:.3g} voxels", error.rms.voxels, error.percentile99.voxels,
                     error.max.voxels);
}

std::string world_text(const accuracy::ErrorStatistics& error) {
  return fmt::format("in the mesh's units rms {:.3g}, 99 % {:.3g}, max {:.3g} at {}", error.rms.world,
                     error.percentile99.world, error.max.world, point_text(error.worst));
}

// Returns "3 beside samples that are not finite, 1 beyond the outermost samples".
std::string unmeasured_text(const accuracy::ErrorStatistics& error) {
  std::vector<std::string> parts;
  if (error.not_finite > 0) parts.push_back(fmt::format("{} beside samples that are not finite", error.not_finite));
  if (error.outside > 0) parts.push_back(fmt::format("{} beyond the outermost samples", error.outside));
  if (error.unreached > 0) parts.push_back(fmt::format("{} with no isosurface to measure to", error.unreached));
  return fmt::format("{}", fmt::join(parts, ", "));
}

void add_unmeasured(std::vector<std::string>& lines, std::string_view what, const accuracy::ErrorStatistics& error) {
  if (error.unmeasured() == 0) return;
  lines.push_back(fmt::format("not measured: {} of {} {}: {}", error.unmeasured(), error.unmeasured() + error.points,
                              what, unmeasured_text(error)));
}

std::string percent_text(double measured, double exact) {
  return fmt::format("{:+.3g} %", 100 * (measured / exact - 1));
}

std::string analytic_text(const MeshError& error, double iso) {
  const accuracy::AnalyticError& analytic = *error.analytic;
  std::string text = fmt::format(
      "error at iso {} against the formula: {}; normals rms {}{:.3g} degrees flat", iso, sizes_text(analytic.interior),
      analytic.smooth_normals.points == 0 ? ""
                                          : fmt::format("{:.3g} degrees smooth, ", analytic.smooth_normals.rms_degrees),
      analytic.flat_normals.rms_degrees);
  if (error.exact) text += "; area " + percent_text(analytic.area, error.exact->area);
  if (error.exact && analytic.volume) text += ", volume " + percent_text(*analytic.volume, error.exact->volume);
  if (error.of_part)
    text += "; area and volume not compared: the mesh covers a part of the surface, the formula covers all of it";
  return text;
}

std::string coverage_text(double iso, const accuracy::SurfaceCoverage& coverage) {
  const accuracy::ErrorStatistics& distances = coverage.distances;
  std::string sizes;
  if (distances.points > 0) {
    sizes = fmt::format("{}, everywhere at most about {:.3g}; {}; ", sizes_text(distances), coverage.max_at_most.voxels,
                        world_text(distances));
  }
  return fmt::format(
      "error at iso {} from the surface of the data to the mesh: {}{}", iso, sizes,
      coverage.lost == 0
          ? coverage.components == 1 ? "the mesh has the surface's only component"
                                     : fmt::format("the mesh has all {} components", coverage.components)
          : fmt::format("the mesh lacks {} of {}", coverage.lost, counted(coverage.components, "component")));
}

std::vector<std::string> summary_of(const MeshError& error, double iso) {
  const accuracy::ErrorStatistics& interior = error.field.interior;
  std::vector<std::string> lines;
  lines.push_back(interior.points == 0
                      ? fmt::format("error at iso {}: no point has a measurable distance", iso)
                      : fmt::format("error at iso {} against the {} interpolant: {}; {}", iso,
                                    word_of(error.field.interpolation), sizes_text(interior), world_text(interior)));
  add_unmeasured(lines, "points", interior);
  if (error.field.coverage && error.field.coverage->components > 0) {
    lines.push_back(coverage_text(iso, *error.field.coverage));
  }
  if (error.analytic && error.analytic->interior.points > 0) {
    lines.push_back(analytic_text(error, iso));
    add_unmeasured(lines, "points", error.analytic->interior);
  }
  return lines;
}

std::vector<std::string> details_of(const MeshError& error) {
  const accuracy::FieldError& field = error.field;
  std::vector<std::string> lines;
  lines.push_back(fmt::format(
      "measured: the distance to the nearest point of the isosurface, at {} points inside the triangles, by area",
      field.interior.points));
  if (field.coverage && field.coverage->distances.points > 0) {
    lines.push_back(
        fmt::format("  and the distance to the mesh, at {} points of the isosurface, found with cells divided into {} "
                    "parts along each axis, by area",
                    field.coverage->distances.points, field.parts));
  }
  if (field.interior.corrected > 0) {
    lines.push_back(
        fmt::format("  at {} of these points the gradient is uneven: the distance differs from |f - iso| / |grad f| by "
                    "more than half",
                    field.interior.corrected));
  }
  if (field.cap_triangles > 0) {
    lines.push_back(
        fmt::format("left out: {} triangles of caps and beyond the outermost samples, which are not on the isosurface",
                    field.cap_triangles));
  }
  if (field.vertices.points > 0) {
    lines.push_back(fmt::format("at the {} vertices: {}", field.vertices.points, sizes_text(field.vertices)));
  }
  add_unmeasured(lines, "vertices", field.vertices);
  if (field.storage.points > 0) {
    lines.push_back(fmt::format("storage error (float32, at the {} vertices on edges along the axes): {}",
                                field.storage.points, sizes_text(field.storage)));
  }
  return lines;
}

// Measures the error of the surface's mesh against `field`. `grid` is null, or the field that the mesh was extracted
// from, made from `field` by resampling or blurring. Fails as measure_field_error() does.
Result<MeshError> measure_mesh_error(const Surface& surface, const StageContext& stage, const field::ScalarField& field,
                                     const field::ScalarField* grid) {
  const mesh::Mesh& mesh = surface.mesh;
  const Context& context = stage.context;
  const std::span<const mesh::HalfSpace> clipped = stage.source.clip;
  const extract::ExtractOptions extracted = extract_options_of(stage.job, stage.source, surface.id.iso());
  MeshError error;
  accuracy::FieldErrorOptions options;
  options.interpolation = *stage.job.error;
  options.grid = grid;
  if (extracted.cap) options.caps.cuts = clipped;
  options.vertices_on_edges = extract::method_info(extracted.method).traits.vertices_on_edges;
  if (stage.job.edits.smooth) options.vertices_on_edges = false;
  options.caps.moved = surface.simplified_by;
  options.clipped = clipped;
  if (surface.taken) {
    error.field = TRY(accuracy::measure_extraction_error(field, extracted, options, context));
    return error;
  }
  error.field = TRY(accuracy::measure_field_error(mesh, field, extracted, options, context));
  error.analytic = TRY(accuracy::measure_analytic_error(mesh, field, extracted, grid, options.caps, context));
  if (error.analytic && field.kind == field::FieldKind::density) {
    const double unit = error.analytic->unit;
    error.exact = field::find_analytic_field(field.name)->size(extracted.iso);
    if (error.exact)
      error.exact = field::SurfaceSize{error.exact->area * unit * unit, error.exact->volume * unit * unit * unit};
  }
  // The formula gives the size of the whole surface, which cannot be compared with a part.
  if (error.exact && (extracted.region || !clipped.empty())) {
    error.of_part = true;
    error.exact.reset();
  }
  return error;
}

}  // namespace

Result<StageReport> measure_error(Surface& surface, const StageContext& stage) {
  if (!stage.job.error) return StageReport();
  StageReport report = stage.report_on(StageName::error, surface);
  if (surface.id.is_label()) {
    report.notes.push_back(
        {NoteId::error_not_measured,
         "the program cannot measure the error of labels: they have no isosurface between the samples"});
    return report;
  }
  const Stopwatch watch;
  const bool has_data = stage.source.data.has_value();
  const field::ScalarField& data = has_data ? *stage.source.data : stage.source.field;
  const MeshError error = TRY(measure_mesh_error(surface, stage, data, has_data ? &stage.source.field : nullptr));
  TRY(volume_io::check_mapping_intact(data));
  surface.error = figures_of(error);
  report.entries.push_back(*surface.error);
  report.time = watch.elapsed();
  report.did = "error measured";
  for (std::string& line : summary_of(error, surface.id.iso())) report.lines.push_back({std::move(line)});
  for (std::string& line : details_of(error)) report.lines.push_back({std::move(line), true});
  return report;
}

}  // namespace isoextract::convert
