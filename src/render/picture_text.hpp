// Short words in pictures: numbers, units, names of frames.
#pragma once

#include <string_view>

#include <glm/glm.hpp>

#include "render/picture.hpp"

namespace isoextract::render {

// The colour of words in pictures, linear.
inline constexpr glm::vec3 kInk{0.02F, 0.02F, 0.03F};

// Glyphs are 5 x 7 dots in cells of 6 x 9, a dot `scale` pixels wide and high.
[[nodiscard]] glm::ivec2 text_size(std::string_view text, int scale);

// With its upper left corner at `at`; what does not fit into the picture is cut off. Digits, small letters, blanks and
// . - + _ / have glyphs, capitals those of the small letters, all else a box. Colour is linear and opaque; depth and
// normals are left.
void draw_text(Picture& picture, glm::ivec2 at, std::string_view text, int scale, const glm::vec3& colour);

// Pixels [min, max), cut off likewise.
void fill_box(Picture& picture, glm::ivec2 min, glm::ivec2 max, const glm::vec3& colour);

}  // namespace isoextract::render
