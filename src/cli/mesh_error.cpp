#include "cli/mesh_error.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::cli {
namespace {

std::string sizes_text(const measure::ErrorStatistics& error) {
  return fmt::format("rms {:.3g}, 99 % {:.3g}, max {:.3g} voxels", error.rms.voxels, error.percentile99.voxels,
                     error.max.voxels);
}

std::string world_text(const measure::ErrorStatistics& error) {
  return fmt::format("in the mesh's units rms {:.3g}, 99 % {:.3g}, max {:.3g} at ({:.6g}, {:.6g}, {:.6g})",
                     error.rms.world, error.percentile99.world, error.max.world, error.worst.x, error.worst.y,
                     error.worst.z);
}

// "3 beside samples that are not finite, 1 where the field is constant"
std::string unmeasured_text(const measure::ErrorStatistics& error) {
  std::vector<std::string> parts;
  if (error.not_finite > 0) parts.push_back(fmt::format("{} beside samples that are not finite", error.not_finite));
  if (error.flat > 0) parts.push_back(fmt::format("{} where the gradient is zero", error.flat));
  if (error.unreached > 0) {
    parts.push_back(fmt::format("{} with no surface near along the gradient", error.unreached));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void add_unmeasured(std::vector<std::string>& lines, std::string_view what, const measure::ErrorStatistics& error) {
  if (error.unmeasured() == 0) return;
  lines.push_back(fmt::format("not in this: {} of {} {}: {}", error.unmeasured(), error.unmeasured() + error.points,
                              what, unmeasured_text(error)));
}

std::string percent_text(double measured, double exact) {
  return fmt::format("{:+.3g} %", 100 * (measured / exact - 1));
}

std::string analytic_text(const MeshError& error) {
  const measure::AnalyticError& analytic = *error.analytic;
  std::string text = fmt::format("error at iso {} against the formula: {}; normals rms {}{:.3g} degrees flat",
                                 error.iso, sizes_text(analytic.interior),
                                 analytic.smooth_normals.points == 0
                                     ? ""
                                     : fmt::format("{:.3g} degrees smooth, ", analytic.smooth_normals.rms_degrees),
                                 analytic.flat_normals.rms_degrees);
  if (error.exact) text += "; area " + percent_text(analytic.area, error.exact->area);
  if (error.exact && analytic.volume) text += ", volume " + percent_text(*analytic.volume, error.exact->volume);
  return text;
}

convert::Json json_of(const measure::Length& length) { return {{"voxels", length.voxels}, {"world", length.world}}; }

convert::Json json_of(const measure::ErrorStatistics& error) {
  convert::Json json{{"points", error.points}};
  if (error.points > 0) {
    json["rms"] = json_of(error.rms);
    json["percentile99"] = json_of(error.percentile99);
    json["max"] = json_of(error.max);
    json["worst"] = convert::json_of(error.worst);
  }
  json["not_finite"] = error.not_finite;
  json["flat"] = error.flat;
  json["unreached"] = error.unreached;
  json["corrected"] = error.corrected;
  return json;
}

convert::Json json_of(const measure::AngleStatistics& angles) {
  if (angles.points == 0) return nullptr;
  return {{"points", angles.points}, {"rms_degrees", angles.rms_degrees}, {"max_degrees", angles.max_degrees}};
}

convert::Json json_of_size(double measured, double exact) {
  return {{"measured", measured}, {"exact", exact}, {"relative_error", measured / exact - 1}};
}

convert::Json json_of(const measure::AnalyticError& analytic, const std::optional<field::SurfaceSize>& exact) {
  return {
      {"closed_form", analytic.closed_form},
      {"interior", json_of(analytic.interior)},
      {"vertices", json_of(analytic.vertices)},
      {"smooth_normals", json_of(analytic.smooth_normals)},
      {"flat_normals", json_of(analytic.flat_normals)},
      {"area", exact ? json_of_size(analytic.area, exact->area) : convert::Json(nullptr)},
      {"volume", exact && analytic.volume ? json_of_size(*analytic.volume, exact->volume) : convert::Json(nullptr)}};
}

// How far from the surface of the data, in their voxels, the mesh of another grid may be: a coarser one's is off by
// voxels of its own.
double reach_from(const field::ScalarField& grid) {
  double longest = 0;
  for (int axis = 0; axis < 3; ++axis) longest = std::max(longest, glm::length(grid.index_to_file.linear[axis]));
  return std::max(1.0, 2 * longest);
}

}  // namespace

MeshError measure_mesh_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                             const extract::ExtractOptions& extracted, field::Interpolation interpolation,
                             const field::ScalarField* grid, const Context& context) {
  MeshError error;
  error.iso = extracted.iso;
  measure::FieldErrorOptions options;
  options.interpolation = interpolation;
  options.grid = grid;
  if (grid != nullptr) options.reach = reach_from(*grid);
  options.progress = &context.progress();
  error.field = measure::measure_field_error(mesh, field, extracted, options);
  error.analytic = measure::measure_analytic_error(mesh, field, extracted, grid, context);
  if (error.analytic && !extracted.region && field.kind == field::FieldKind::density) {
    const double unit = error.analytic->unit;
    error.exact = field::find_analytic_field(field.name)->size(extracted.iso);
    if (error.exact)
      error.exact = field::SurfaceSize{error.exact->area * unit * unit, error.exact->volume * unit * unit * unit};
  }
  return error;
}

std::string_view interpolation_name(field::Interpolation interpolation) {
  return interpolation == field::Interpolation::trilinear ? "trilinear" : "tricubic";
}

std::vector<std::string> error_summary(const MeshError& error) {
  const measure::ErrorStatistics& interior = error.field.interior;
  std::vector<std::string> lines;
  lines.push_back(interior.points == 0 ? fmt::format("error at iso {}: nothing could be measured", error.iso)
                                       : fmt::format("error at iso {} against the {} interpolant: {}; {}", error.iso,
                                                     interpolation_name(error.field.interpolation),
                                                     sizes_text(interior), world_text(interior)));
  add_unmeasured(lines, "points", interior);
  if (error.analytic && error.analytic->interior.points > 0) {
    lines.push_back(analytic_text(error));
    add_unmeasured(lines, "points", error.analytic->interior);
  }
  return lines;
}

std::vector<std::string> error_details(const MeshError& error) {
  const measure::FieldError& field = error.field;
  std::vector<std::string> lines;
  lines.push_back(fmt::format(
      "measured: the distance to the isosurface along the gradient, at {} points inside the triangles, by area",
      field.interior.points));
  if (field.interior.corrected > 0) {
    lines.push_back(
        fmt::format("  of which {} have a gradient so uneven that |f - iso| / |grad f| alone is off by half",
                    field.interior.corrected));
  }
  if (field.cap_triangles > 0) {
    lines.push_back(
        fmt::format("left out: {} triangles of caps, which are not on the isosurface", field.cap_triangles));
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

convert::Json json_of(const MeshError& error) {
  return {{"interpolant", interpolation_name(error.field.interpolation)},
          {"interior", json_of(error.field.interior)},
          {"vertices", json_of(error.field.vertices)},
          {"storage", json_of(error.field.storage)},
          {"cap_triangles", error.field.cap_triangles},
          {"analytic", error.analytic ? json_of(*error.analytic, error.exact) : convert::Json(nullptr)}};
}

}  // namespace isoextract::cli
