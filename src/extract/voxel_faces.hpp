// The ways to turn exposed voxel faces into triangles.
#pragma once

#include <array>

#include "base/enum_words.hpp"

namespace isoextract::extract {

enum class VoxelFaces {
  merged,      // coplanar faces merged into large rectangles; a rectangle's sides also have the corners of adjacent
               // rectangles, so there are no T-junctions
  rectangles,  // the same rectangles as two triangles each: fewest triangles, but with T-junctions
  plain,       // each face by itself, as two triangles
};
constexpr auto words_of(VoxelFaces /*type*/) {
  return std::array{Word{VoxelFaces::merged, "merged"}, Word{VoxelFaces::rectangles, "rectangles"},
                    Word{VoxelFaces::plain, "plain"}};
}

}  // namespace isoextract::extract
