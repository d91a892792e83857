// How the exposed faces of voxels become triangles.
#pragma once

#include <array>

#include "base/words.hpp"

namespace isoextract::extract {

enum class VoxelFaces {
  merged,      // coplanar faces as large rectangles, each with the vertices that its neighbours have on its border
  rectangles,  // the same rectangles as two triangles each: fewest triangles, but not closed edge by edge
  plain,       // each by itself, as two triangles
};
constexpr auto words_of(VoxelFaces /*type*/) {
  return std::array{Word{VoxelFaces::merged, "merged"}, Word{VoxelFaces::rectangles, "rectangles"},
                    Word{VoxelFaces::plain, "plain"}};
}

}  // namespace isoextract::extract
