// The stage that drops pieces of a surface, and what is told of the pieces that are left.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/json_values.hpp"
#include "convert/surface_edits.hpp"
#include "mesh/component_facts.hpp"

namespace isoextract::convert {

struct Source;

struct PieceRecord {
  double iso = 0;
  edit::PieceFacts facts;
  std::string grid = {};  // whose surface it is, where the job has several
};
[[nodiscard]] Json json_of(const PieceRecord& record);

// `mesh` is of `source`, of its positions or `sites`. It is replaced by what is left. Fails as edit::keep_pieces()
// does.
[[nodiscard]] Result<PieceRecord> drop_pieces(mesh::Mesh& mesh, double iso, const PieceChoice& choice,
                                              const Source& source, edit::Sites sites, const Context& context);

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

// The components of a mesh that was written: the largest by area, at most kMostTold, and how many others there are.
struct ComponentTable {
  static constexpr std::size_t kMostTold = 100;
  std::vector<mesh::ComponentFacts> largest;
  std::uint64_t others = 0;
  std::uint64_t triangles_of_others = 0;
};
[[nodiscard]] Result<ComponentTable> component_table(const mesh::Mesh& mesh, const Context& context);
[[nodiscard]] Json json_of(const ComponentTable& table);

}  // namespace isoextract::convert
