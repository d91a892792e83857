// Colours of vertices from their attributes, and of whole surfaces from their iso values.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

struct VertexColors {
  std::array<double, 2> range{};  // the values at the ends of the map
  std::uint64_t not_numbers = 0;  // vertices that are grey, as their value is NaN
};

// Adds colours by the attribute that `choice` names, which the mesh has, as float32. glTF wants linear light, and gets
// it as u16 with an alpha of 1; other formats get sRGB as u8. Where all values are alike, without a range of their own,
// they have the middle of the map. Fails with ErrorCode::input where the memory is not there.
[[nodiscard]] Result<VertexColors> add_colours(const ColourChoice& choice, mesh_io::MeshFormat format, mesh::Mesh& mesh,
                                               const Context& context);

// Of the surface at `iso`, one of `isos`, which the job's choices came to: the colour by its place between the least
// and the greatest of them, or in the range that was given, and the opacity. `open`: its inside may be seen. Nothing
// where none of this says anything.
[[nodiscard]] std::optional<mesh::Material> material_of(const ConversionJob& job, std::span<const double> isos,
                                                        double iso, field::FieldKind kind, bool open = false);

}  // namespace isoextract::convert
