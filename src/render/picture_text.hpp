// Draws short texts into pictures: numbers, units, frame names.
#pragma once

#include <string_view>

#include <glm/glm.hpp>

#include "render/picture.hpp"

namespace isoextract::render {

// The color of text in pictures, linear.
inline constexpr glm::vec3 kTextColor{0.02F, 0.02F, 0.03F};
// Returns the color of text on a background: dark, but light on a dark opaque background. `background` is linear, with
// straight alpha.
[[nodiscard]] glm::vec3 text_color(const glm::dvec4& background);

// Returns the size of a text in pixels. Glyphs have 5 x 7 dots in cells of 6 x 9; a dot is a square of `scale` pixels.
[[nodiscard]] glm::ivec2 text_size(std::string_view text, int scale);

// Draws text with its upper left corner at `at`, clipped to the picture. Glyphs exist for digits, letters (capitals are
// drawn as small letters), blanks and the characters in ".-+_/". Other characters become a box. `color` is linear; text
// is opaque. Depth and normals stay unchanged.
void draw_text(Picture& picture, glm::ivec2 at, std::string_view text, int scale, const glm::vec3& color);

// Fills the pixels [min, max), clipped to the picture, with an opaque linear color. Depth and normals stay unchanged.
void fill_box(Picture& picture, glm::ivec2 min, glm::ivec2 max, const glm::vec3& color);

}  // namespace isoextract::render
