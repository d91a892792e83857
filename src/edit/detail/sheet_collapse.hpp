// Simplifies a surface whose sheets may meet in curves (bounded_simplify.hpp tells how). A single mesh is one sheet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "edit/bounded_simplify.hpp"
#include "edit/detail/sheet_trees.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// The two corners (0 to 2) of a triangle that a collapse merged; negative for a triangle that stays.
struct MergedCorners {
  std::int8_t from = -1;
  std::int8_t to = -1;
};

// The result of collapse_sheets(). Both lists are empty if nothing changed.
struct CollapsedSheets {
  std::vector<glm::uvec3> corners;    // of each triangle; of a removed one, the last corners
  std::vector<MergedCorners> merged;  // for each triangle

  [[nodiscard]] bool changed() const { return !corners.empty(); }
  [[nodiscard]] bool stays(std::size_t triangle) const { return merged[triangle].from < 0; }
};

// Collapses edges of the mesh as simplify_mesh() does, and fails as it does. Each sheet stays within the distance of
// its original. The sheets keep their curves and the ends of curves. An edge where sheets meet is kept in all these
// sheets or collapsed in all. Sets all figures but the time. Throws std::bad_alloc.
[[nodiscard]] Result<CollapsedSheets> collapse_sheets(const mesh::Mesh& mesh, const Sheets& sheets,
                                                      const SimplifyOptions& options, SimplifyFigures& facts,
                                                      const Context& context);

// Sets the triangles and drops vertices without a triangle; the other vertices keep their order. Drops the edge keys,
// as they describe only extracted meshes.
void set_triangles(mesh::Mesh& mesh, std::span<const glm::uvec3> triangles);

}  // namespace isoextract::edit
