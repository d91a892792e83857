// The placement record: one line of JSON in a mesh file with the changes from the input's world to the file's
// coordinates (axes, unit, offset), so that readers can undo them. Mesh writers store it
// (mesh_io::MeshWriteOptions::placement).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "convert/attribute_kinds.hpp"
#include "convert/placement.hpp"
#include "field/affine.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::convert {

// Returns the placement that a mesh file without a record has: world coordinates in which the axis `up` points up. They
// are turned from z up to y up if `up` is z and the file format prescribes y up.
[[nodiscard]] ResolvedPlacement default_placement(bool format_is_y_up, UpAxis up = UpAxis::z);

// Returns the up axis in the output.
[[nodiscard]] UpAxis output_up(const Placement& placement);

// Returns `other`, turned so that the axis `up` points up in the output. `isoextract compare` uses it for a mesh of
// another program, if `other` is the placement of a mesh that isoextract made of the same input.
[[nodiscard]] ResolvedPlacement placed_like(const ResolvedPlacement& other, UpAxis up);

// Returns the placement of a mesh that was read from a file with the placement `before`, and then placed by `again`.
// Combines the two placements. With voxel coordinates in `before`, instead returns `before` if `again` changes nothing,
// else `again`, which treats the file's voxel coordinates as world coordinates.
[[nodiscard]] ResolvedPlacement placed_again(const ResolvedPlacement& before, const ResolvedPlacement& again);

// Returns the record. Returns an empty text if `resolved` equals default_placement() of the format and `attributes` has
// no kinds to store. For STL, whose header has 80 bytes, the record omits values that follow from the others.
[[nodiscard]] std::string write_placement_record(const ResolvedPlacement& resolved, mesh_io::MeshFormat format,
                                                 const std::vector<NamedKind>& attributes = {});

// Parses a record. Returns nullopt if the text is no valid record.
[[nodiscard]] std::optional<ResolvedPlacement> parse_placement_record(std::string_view text);

// Returns "voxel coordinates" if the mesh is in voxel coordinates. Otherwise lists how the output's coordinates differ
// from the input's world, and their space or unit if stated. Empty if there is none of these. An example: "turned from
// z up to y up, scaled by 0.001 (mm to m), moved by (1, 2, 3)".
[[nodiscard]] std::string placement_text(const ResolvedPlacement& resolved);
// Returns "world coordinates, turned from z up to y up, scaled by 0.001 (mm to m)", or "voxel coordinates".
[[nodiscard]] std::string world_text(const ResolvedPlacement& resolved);
// Returns the text for an input that is a mesh file: "the file's coordinates, turned from z up to y up".
[[nodiscard]] std::string file_text(const ResolvedPlacement& resolved);

// Applies `map` to the vertices of a mesh, which must have no normals, and to the attributes according to their kinds
// (vectors turn, scalars stay). Reverses the winding if `map` mirrors. Turns by right angles are exact.
void move_mesh(mesh::Mesh& mesh, const field::Affine& map, const std::vector<NamedKind>& attributes = {});

}  // namespace isoextract::convert
