// The pieces of a surface: where they are told from each other, and as meshes of their own.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "edit/pieces.hpp"

namespace isoextract::convert {

struct Source;

// The corners of voxels from which the vertices of surface nets were moved, each within its cell: sides of shells are
// those of the samples, whatever relaxation made of thin ones. Vertices on planes of source.clip have no such place and
// keep their own. Nothing (empty) of other methods, whose vertices are where the field puts them.
[[nodiscard]] Result<edit::Sites> voxel_sites(const mesh::Mesh& mesh, const Source& source,
                                              const SurfaceOptions& surface, const Context& context);

// The pieces as meshes, called "NAME piece 1" and so on; of an empty mesh that alone, and nothing into files. Fails as
// edit::split_pieces() does.
[[nodiscard]] Result<std::vector<mesh::Mesh>> split_mesh(mesh::Mesh mesh, bool into_files, const Context& context);

// The name of the file of a piece, counted from 1; `pattern` has kPieceWord in it.
[[nodiscard]] std::string piece_path(std::string pattern, std::size_t number);

}  // namespace isoextract::convert
