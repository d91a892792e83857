// The stage that drops pieces of a surface, and what is told of the pieces that are left.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/json_values.hpp"
#include "convert/surface_edits.hpp"
#include "field/affine.hpp"
#include "mesh/component_facts.hpp"

namespace isoextract::convert {

struct PieceRecord {
  double iso = 0;
  edit::PieceFacts facts;
};
[[nodiscard]] Json json_of(const PieceRecord& record);

// `mesh` was placed by `output_from_index`, whose linear part says what a voxel is. It is replaced by what is left.
// Fails as edit::keep_pieces() does.
[[nodiscard]] Result<PieceRecord> drop_pieces(mesh::Mesh& mesh, double iso, const PieceChoice& choice,
                                              const field::Affine& output_from_index, const Context& context);

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
