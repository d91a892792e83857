// Colors of whole surfaces from their iso values; the stage that colors vertices as well is color_surface().
#pragma once

#include <optional>
#include <span>

#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

// Of the surface `id`, one of `all` that the job's choices came to: the colour by its place between the least
// and the greatest of them, or in the range that was given, and the opacity. `open`: its inside may be seen. Nothing
// where none of this says anything.
[[nodiscard]] std::optional<mesh::Material> material_of(const ConversionJob& job, std::span<const SurfaceId> all,
                                                        const SurfaceId& id, field::FieldKind kind, bool open = false);

}  // namespace isoextract::convert
