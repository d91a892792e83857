// Colors of vertices, stored as an attribute.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "edit/colormap.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// linear_u16: linear light, as glTF requires, with an alpha of 1. srgb_u8: sRGB without alpha.
enum class ColorStorage { linear_u16, srgb_u8 };

using ValueRange = std::array<double, 2>;

// Returns where a value lies in a range, 0 at its start and 1 at its end, not clamped; 0.5 if the range is one value or
// descends. NaN stays NaN.
[[nodiscard]] double place_in(const ValueRange& range, double value);

struct ValueColors {
  ValueRange range{};             // the values that get the first and the last color
  std::uint64_t not_numbers = 0;  // vertices with a NaN value, which are gray
};

// Returns the range of the finite values of an attribute, which the mesh must have; of the lengths if it has several
// components. Returns nullopt if no value is finite.
[[nodiscard]] std::optional<ValueRange> range_of_attribute(const mesh::Mesh& mesh, const std::string& attribute);

// Colors the vertices by an attribute, which the mesh must have. An attribute of several components counts by its
// length as a vector. Replaces the present colors. Without `range` uses the range of the finite values, 0 to 0 if there
// are none. Fails with ErrorCode::out_of_memory if memory is short.
[[nodiscard]] Result<ValueColors> color_by_values(mesh::Mesh& mesh, const std::string& attribute, Colormap map,
                                                  const std::optional<ValueRange>& range, ColorStorage storage,
                                                  const Context& context);

// Gives all vertices one color, in sRGB with channels from 0 to 1, stored as srgb_u8. The mesh must have no colors yet.
// Fails with ErrorCode::out_of_memory if memory is short.
[[nodiscard]] Result<void> color_uniformly(mesh::Mesh& mesh, const glm::dvec3& color, const Context& context);

// The color of a range of vertices, in sRGB with channels from 0 to 1.
struct RangeColor {
  std::size_t first_vertex = 0;
  std::size_t vertices = 0;
  glm::dvec3 color{1.0};
};

// Colors ranges of vertices as color_uniformly() does; vertices outside all ranges become white.
[[nodiscard]] Result<void> color_ranges(mesh::Mesh& mesh, std::span<const RangeColor> ranges, const Context& context);

// Converts the vertex colors (AttributeRole::color) to `storage`. `are_linear` states whether the present colors are
// linear light; otherwise they are sRGB. Alpha stays; linear_u16 adds an alpha of 1 if there is none. Does nothing
// without colors. Conversion from srgb_u8 to linear_u16 and back changes no color. Fails with ErrorCode::out_of_memory
// if memory is short.
[[nodiscard]] Result<void> store_colors(mesh::Mesh& mesh, bool are_linear, ColorStorage storage,
                                        const Context& context);

}  // namespace isoextract::edit
