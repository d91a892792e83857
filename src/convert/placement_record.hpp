// What mesh files say of where their meshes are, so that what was done to the input's world can be undone: JSON in one
// line, which the writers keep (mesh_io::MeshWriteOptions::placement).
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

// Where nobody says anything: meshes of a z-up world, turned where their format prescribes another axis.
[[nodiscard]] ResolvedPlacement usual_placement(bool format_is_y_up, UpAxis up = UpAxis::z);

// Returns the axis that points up in the output.
[[nodiscard]] UpAxis output_up(const Placement& placement);

// Returns the placement of a mesh that another program made of one that is placed like `other`: that one, but turned so
// that `up` points up in the output.
[[nodiscard]] ResolvedPlacement placed_like(const ResolvedPlacement& other, UpAxis up);

// Empty where there is nothing to say: the placement is the usual one of the format, and none of the attributes changes
// with it.
[[nodiscard]] std::string record_text(const ResolvedPlacement& resolved, mesh_io::MeshFormat format,
                                      const std::vector<NamedKind>& attributes = {});

// Nothing where the text is no such record.
[[nodiscard]] std::optional<ResolvedPlacement> read_record(std::string_view text);

// "voxel coordinates", or what was done to the world's: "turned from z up to y up, scaled by 0.001 (mm to m), moved by
// (1, 2, 3)"; empty where nothing was done.
[[nodiscard]] std::string placement_text(const ResolvedPlacement& resolved);
// "world coordinates, turned from z up to y up, scaled by 0.001 (mm to m)", "voxel coordinates".
[[nodiscard]] std::string world_text(const ResolvedPlacement& resolved);

// Puts the vertices of a mesh without normals where `map` says, changes its attributes by their kinds, and winds its
// triangles the other way round where that mirrors. Turns by right angles round nothing.
void move_mesh(mesh::Mesh& mesh, const field::Affine& map, const std::vector<NamedKind>& attributes = {});

}  // namespace isoextract::convert
