// The parts of a run (surface_run.hpp) that look at no sample: checks, allocation, the cap's part of a mesh.
#pragma once

#include "extract/border_cap.hpp"
#include "extract/edge_geometry.hpp"

namespace isoextract::extract {

struct MeshSizes {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

// What no extraction can be made with: ErrorCode::usage for an iso value that is not finite, ErrorCode::input for a
// placement that flattens space.
[[nodiscard]] Result<void> check_request(const field::ScalarField& field, const ExtractOptions& options);

// The samples to extract from: the part of options.region within `box`. Fails with ErrorCode::input where that holds no
// cell (two samples along each axis).
[[nodiscard]] Result<field::IndexBox> clip_region(const field::ScalarField& field, const field::IndexBox& box,
                                                  const ExtractOptions& options);

// Fails with ErrorCode::input where float32 cannot hold the mesh (OutputFrame::fits_float32).
[[nodiscard]] Result<void> check_placement(const field::ScalarField& field, const OutputFrame& placement);

// For what allocate_mesh() takes. Fails with ErrorCode::input where there is no memory, and for more vertices than
// 32-bit numbers count.
[[nodiscard]] Result<Reservation> reserve_mesh(const field::ScalarField& field, const MeshSizes& sizes,
                                               const ExtractOptions& options, const Context& context);

// The sizes of surface and cap together.
[[nodiscard]] MeshSizes with_cap(const MeshSizes& surface, const BorderCap& cap);

// For numbering the cap's vertices while it is made, and then for the cap.
[[nodiscard]] Result<Reservation> reserve_cap_numbers(const field::ScalarField& field, const field::IndexBox& box,
                                                      const Context& context);
[[nodiscard]] Result<Reservation> reserve_cap(const field::ScalarField& field, const BorderCap& cap,
                                              const Context& context);

// `first` is told as an index of the file.
[[nodiscard]] tl::unexpected<Error> nan_error(const field::ScalarField& field, std::uint64_t count,
                                              const glm::ivec3& first);

// Room for the surface and the cap; nothing is initialised.
void allocate_mesh(mesh::Mesh& mesh, const MeshSizes& surface, const BorderCap& cap, const ExtractOptions& options);

// Gives the vertices of the surface whose normals are unknown (OutputFrame) the mean of the normals of their triangles,
// weighted by area, and where these cancel out, or there are none, the direction of their edge. Before append_cap().
[[nodiscard]] Result<void> fill_normals(mesh::Mesh& mesh, const MeshSizes& surface, const field::ScalarField& field,
                                        const Context& context);

// Writes the cap of `box` behind the surface.
void append_cap(mesh::Mesh& mesh, const MeshSizes& surface, const BorderCap& cap, const field::IndexBox& box,
                const OutputFrame& placement);

}  // namespace isoextract::extract
