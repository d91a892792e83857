// Makes materials of whole surfaces from their iso values. The stage color_surface() sets them, and colors vertices.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "edit/vertex_colors.hpp"
#include "field/scalar_field.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

struct Source;

// All surfaces of a grid.
struct SurfaceList {
  SurfaceList() = default;
  explicit SurfaceList(std::vector<SurfaceId> surfaces);

  std::vector<SurfaceId> in_order;  // the job's order
  std::vector<SurfaceId> rising;    // sorted, each once
};

// Returns the material of surface `id`, one of `all`: its color and opacity. The color comes from the position of the
// iso value in the job's range, else in the range of `all`. `kind` tells which surfaces are outer ones, which may be
// translucent (ConversionJob::opacity). `open` makes the material double-sided, because the inside may be visible.
// Returns nullopt if the job neither colors by iso value nor sets an opacity, and `open` is false.
[[nodiscard]] std::optional<mesh::Material> material_of(const ConversionJob& job, const SurfaceList& all,
                                                        const SurfaceId& id, field::FieldKind kind, bool open = false);

// Returns the attribute that gives the vertices of an extracted surface their colors; null if there is none.
[[nodiscard]] const std::string* color_attribute_of(const ConversionJob& job, const Source& source);

// Colors the vertices of a mesh by an attribute, which it has, as the job asks. Without `range`, uses the range of the
// attribute's finite values in this mesh. Fails as edit::color_by_values() does.
[[nodiscard]] Result<edit::ValueColors> color_vertices(mesh::Mesh& mesh, const ConversionJob& job,
                                                       const std::optional<edit::ValueRange>& range,
                                                       const Context& context);

// Removes the attributes that only give colors.
void drop_unwritten(const ConversionJob& job, mesh::Mesh& mesh);

}  // namespace isoextract::convert
