// Bodies of a surface: finds the original positions of relaxed vertices, and splits a mesh into one mesh for each body.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "edit/bodies.hpp"

namespace isoextract::convert {

struct Source;

// Returns for each vertex of a surface net the voxel corner from which relaxation moved the vertex, relative to
// Mesh::origin. The corner is the middle of a cell that the vertex never leaves. From these positions, `edit` finds
// which shell encloses which: relaxed shells may touch.
//
// Vertices on planes of source.clip keep their own position, because they come from no corner. Returns an empty result
// unless SurfaceOptions::relaxes(). Fails as Context::reserve() does.
[[nodiscard]] Result<edit::OriginalPositions> voxel_sites(const mesh::Mesh& mesh, const Source& source,
                                                          const SurfaceOptions& surface, const Context& context);

// Makes the selection of the bodies that the job keeps.
[[nodiscard]] edit::BodySelection body_selection(const PieceChoice& choice, const Source& source);

// Splits the mesh into its bodies, named `NAME piece 1` and so on. An empty mesh gives one empty mesh, or none if
// `into_files`. Fails as edit::split_into_bodies() does, with kMaxPieceFiles bodies as the limit if `into_files`, else
// kMostPieceMeshes.
[[nodiscard]] Result<std::vector<mesh::Mesh>> split_mesh(mesh::Mesh mesh, bool into_files, const Context& context);

// Returns the file name of a body, counted from 1: replaces each kPiecePlaceholder in `pattern` by the number.
[[nodiscard]] std::string piece_path(std::string pattern, std::size_t number);

}  // namespace isoextract::convert
