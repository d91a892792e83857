#include "cli/mesh_error_text.hpp"

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
  if (error.outside > 0) parts.push_back(fmt::format("{} beyond the outermost samples", error.outside));
  if (error.unreached > 0) parts.push_back(fmt::format("{} with no isosurface to measure to", error.unreached));
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

std::string analytic_text(const convert::MeshError& error) {
  const measure::AnalyticError& analytic = *error.analytic;
  std::string text = fmt::format("error at iso {} against the formula: {}; normals rms {}{:.3g} degrees flat",
                                 error.iso, sizes_text(analytic.interior),
                                 analytic.smooth_normals.points == 0
                                     ? ""
                                     : fmt::format("{:.3g} degrees smooth, ", analytic.smooth_normals.rms_degrees),
                                 analytic.flat_normals.rms_degrees);
  if (error.exact) text += "; area " + percent_text(analytic.area, error.exact->area);
  if (error.exact && analytic.volume) text += ", volume " + percent_text(*analytic.volume, error.exact->volume);
  if (error.of_part) text += "; area and volume are those of a part, and the formula's are of the whole: not compared";
  return text;
}

std::string coverage_text(double iso, const measure::SurfaceCoverage& coverage) {
  const measure::ErrorStatistics& distances = coverage.distances;
  std::string sizes;
  if (distances.points > 0) {
    sizes = fmt::format("{}, nowhere more than {:.3g}; {}; ", sizes_text(distances), coverage.max_at_most.voxels,
                        world_text(distances));
  }
  return fmt::format("error at iso {} from the surface of the data to the mesh: {}{}", iso, sizes,
                     coverage.lost == 0
                         ? fmt::format("all of its {} components are there", coverage.components)
                         : fmt::format("{} of its {} components are lost", coverage.lost, coverage.components));
}

}  // namespace

std::vector<std::string> error_summary(const convert::MeshError& error) {
  const measure::ErrorStatistics& interior = error.field.interior;
  std::vector<std::string> lines;
  lines.push_back(interior.points == 0
                      ? fmt::format("error at iso {}: nothing could be measured", error.iso)
                      : fmt::format("error at iso {} against the {} interpolant: {}; {}", error.iso,
                                    word_of(error.field.interpolation), sizes_text(interior), world_text(interior)));
  add_unmeasured(lines, "points", interior);
  if (error.field.coverage && error.field.coverage->components > 0) {
    lines.push_back(coverage_text(error.iso, *error.field.coverage));
  }
  if (error.analytic && error.analytic->interior.points > 0) {
    lines.push_back(analytic_text(error));
    add_unmeasured(lines, "points", error.analytic->interior);
  }
  return lines;
}

std::vector<std::string> error_details(const convert::MeshError& error) {
  const measure::FieldError& field = error.field;
  std::vector<std::string> lines;
  lines.push_back(fmt::format(
      "measured: the distance to the nearest point of the isosurface, at {} points inside the triangles, by area",
      field.interior.points));
  if (field.coverage && field.coverage->distances.points > 0) {
    lines.push_back(fmt::format(
        "  and back from {} points of the isosurface, found with cells divided into {} parts along each axis, by area",
        field.coverage->distances.points, field.parts));
  }
  if (field.interior.corrected > 0) {
    lines.push_back(
        fmt::format("  of which {} have a gradient so uneven that |f - iso| / |grad f| alone is off by half",
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

}  // namespace isoextract::cli
