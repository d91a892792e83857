// Colors of vertices, as an attribute of theirs.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "edit/colormap.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// How colors are stored: in linear light as u16 with an alpha of 1, which glTF wants, or in sRGB as u8.
enum class ColorStorage { linear_u16, srgb_u8 };

using ValueRange = std::array<double, 2>;

// Where a value lies in a range, from 0 to 1. In a range of one value it is the middle; NaN stays NaN.
[[nodiscard]] double place_in(const ValueRange& range, double value);

struct ValueColors {
  ValueRange range{};             // the values at the ends of the map
  std::uint64_t not_numbers = 0;  // vertices that are grey, as their value is NaN
};

// Adds colors by an attribute of float32 that the mesh has; of several components their length counts. Without a range
// it is that of the finite values. Fails with ErrorCode::input where the memory is not there.
[[nodiscard]] Result<ValueColors> color_by_values(mesh::Mesh& mesh, const std::string& attribute, Colormap map,
                                                  const std::optional<ValueRange>& range, ColorStorage storage,
                                                  const Context& context);

// Adds one color of all vertices, in sRGB, as u8. Fails as color_by_values() does.
[[nodiscard]] Result<void> color_all(mesh::Mesh& mesh, const glm::dvec3& color, const Context& context);

}  // namespace isoextract::edit
