// The placement record: one line of JSON in a mesh file that says how its mesh was placed, so that readers can undo the
// placement. Mesh writers store it (mesh_io::MeshWriteOptions::placement).
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

// Returns the placement of a mesh without a record: a world in which `up` points up, turned if that is z and the file
// format prescribes y up.
[[nodiscard]] ResolvedPlacement default_placement(bool format_is_y_up, UpAxis up = UpAxis::z);

// Returns the up axis in the output.
[[nodiscard]] UpAxis output_up(const Placement& placement);

// Returns the placement of a mesh that another program made from one placed like `other`: the same placement, turned so
// that `up` points up in the output.
[[nodiscard]] ResolvedPlacement placed_like(const ResolvedPlacement& other, UpAxis up);

// Returns the record. Returns an empty text if the placement is the format's usual one and no attribute changes with
// the mesh.
[[nodiscard]] std::string write_placement_record(const ResolvedPlacement& resolved, mesh_io::MeshFormat format,
                                                 const std::vector<NamedKind>& attributes = {});

// Parses a record. Returns nullopt if the text is no valid record.
[[nodiscard]] std::optional<ResolvedPlacement> parse_placement_record(std::string_view text);

// Returns "voxel coordinates", or the changes to the world's coordinates: "turned from z up to y up, scaled by 0.001
// (mm to m), moved by (1, 2, 3)". Empty if there are none.
[[nodiscard]] std::string placement_text(const ResolvedPlacement& resolved);
// Returns "world coordinates, turned from z up to y up, scaled by 0.001 (mm to m)", or "voxel coordinates".
[[nodiscard]] std::string world_text(const ResolvedPlacement& resolved);

// Moves the vertices of a mesh without normals by `map`, changes its attributes by their kinds, and reverses the
// winding of its triangles if `map` mirrors. Turns by right angles are exact.
void move_mesh(mesh::Mesh& mesh, const field::Affine& map, const std::vector<NamedKind>& attributes = {});

}  // namespace isoextract::convert
