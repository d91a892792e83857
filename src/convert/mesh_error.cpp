#include "convert/mesh_error.hpp"

#include <utility>

namespace isoextract::convert {
namespace {

Json json_of(const measure::Length& length) { return {{"voxels", length.voxels}, {"world", length.world}}; }

Json json_of(const measure::ErrorStatistics& error) {
  Json json{{"points", error.points}};
  if (error.points > 0) {
    json["rms"] = json_of(error.rms);
    json["percentile99"] = json_of(error.percentile99);
    json["max"] = json_of(error.max);
    json["worst"] = convert::json_of(error.worst);
  }
  json["not_finite"] = error.not_finite;
  json["outside"] = error.outside;
  json["unreached"] = error.unreached;
  json["corrected"] = error.corrected;
  return json;
}

Json json_of(const measure::AngleStatistics& angles) {
  if (angles.points == 0) return nullptr;
  return {{"points", angles.points}, {"rms_degrees", angles.rms_degrees}, {"max_degrees", angles.max_degrees}};
}

Json json_of_size(double measured, double exact) {
  return {{"measured", measured}, {"exact", exact}, {"relative_error", measured / exact - 1}};
}

Json json_of(const measure::AnalyticError& analytic, const std::optional<field::SurfaceSize>& exact) {
  return {{"closed_form", analytic.closed_form},
          {"interior", json_of(analytic.interior)},
          {"vertices", json_of(analytic.vertices)},
          {"smooth_normals", json_of(analytic.smooth_normals)},
          {"flat_normals", json_of(analytic.flat_normals)},
          {"area", exact ? json_of_size(analytic.area, exact->area) : Json(nullptr)},
          {"volume", exact && analytic.volume ? json_of_size(*analytic.volume, exact->volume) : Json(nullptr)}};
}

Json json_of(const measure::SurfaceCoverage& coverage, int parts) {
  Json json{{"distances", json_of(coverage.distances)},
            {"parts", parts},
            {"components", coverage.components},
            {"lost_components", coverage.lost}};
  if (coverage.distances.points > 0) json["max_at_most"] = json_of(coverage.max_at_most);
  return json;
}

}  // namespace

Result<MeshError> measure_mesh_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                                     const extract::ExtractOptions& extracted, field::Interpolation interpolation,
                                     const field::ScalarField* grid, std::span<const mesh::HalfSpace> clipped,
                                     const MeshChanges& changes, const Context& context) {
  MeshError error;
  error.iso = extracted.iso;
  measure::FieldErrorOptions options;
  options.interpolation = interpolation;
  options.grid = grid;
  if (extracted.cap) options.caps.cuts = clipped;
  options.vertices_on_edges = extract::method_info(extracted.method).traits.vertices_on_edges;
  if (changes.off_edges) options.vertices_on_edges = false;
  options.caps.moved = changes.simplified_by;
  options.clipped = clipped;
  error.field = TRY(measure::measure_field_error(mesh, field, extracted, options, context));
  auto analytic = TRY(measure::measure_analytic_error(mesh, field, extracted, grid, options.caps, context));
  error.analytic = analytic;
  if (error.analytic && field.kind == field::FieldKind::density) {
    const double unit = error.analytic->unit;
    error.exact = field::find_analytic_field(field.name)->size(extracted.iso);
    if (error.exact)
      error.exact = field::SurfaceSize{error.exact->area * unit * unit, error.exact->volume * unit * unit * unit};
  }
  // Known is the size of the whole surface.
  if (error.exact && (extracted.region || !clipped.empty())) {
    error.of_part = true;
    error.exact.reset();
  }
  return error;
}

Json json_of(const MeshError& error) {
  return {{"interpolant", word_of(error.field.interpolation)},
          {"interior", json_of(error.field.interior)},
          {"vertices", json_of(error.field.vertices)},
          {"storage", json_of(error.field.storage)},
          {"cap_triangles", error.field.cap_triangles},
          {"coverage", error.field.coverage ? json_of(*error.field.coverage, error.field.parts) : Json(nullptr)},
          {"analytic", error.analytic ? json_of(*error.analytic, error.exact) : Json(nullptr)}};
}

}  // namespace isoextract::convert
