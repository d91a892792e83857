// Simplifies a mesh that is too large for one simplifier (simplifier.hpp) in windows that slide along its longest axis.
//
// Planes divide the mesh into slabs. A window is a new slab and, of the two slabs before it, all triangles that meet
// the plane between old and new, and a margin. Vertices of triangles that leave the window stay; the next window can
// move them, so no plane remains visible: no triangle at the upper plane of a window is longer than two slabs. Each
// window holds all original triangles within the distance limit of its slabs, and all present triangles within that
// limit of these. So a window proves the whole distance for the triangles that it changes, as if it held the mesh.
//
// Flat regions keep a few more triangles than with one simplifier, because of these limits.
#pragma once

#include <cstdint>
#include <optional>

#include "base/context.hpp"
#include "base/error.hpp"
#include "edit/bounded_simplify.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// Returns the number of triangles of a slab, a power of 2, whose windows fit into `bytes` of memory besides the mesh;
// null if none is large enough.
[[nodiscard]] std::optional<std::uint64_t> slab_triangles_for(std::uint64_t vertices, std::uint64_t triangles,
                                                              std::uint64_t bytes);

// Returns the triangles of a large window: three slabs, and those within reach of them.
[[nodiscard]] std::uint64_t window_triangles(std::uint64_t slab_triangles);

// Simplifies as simplify_mesh() does, to a finite distance. Changes the triangles of `mesh`, and drops vertices without
// triangles. Keeps about `options.triangles` triangles or more: each window keeps its share. Fails with
// ErrorCode::out_of_memory if a slab has far more than `slab_triangles`, because no plane divides it. Throws
// std::bad_alloc.
[[nodiscard]] Result<void> simplify_in_windows(mesh::Mesh& mesh, const SimplifyOptions& options,
                                               std::uint64_t slab_triangles, SimplifyFigures& facts,
                                               const Context& context);

}  // namespace isoextract::edit
