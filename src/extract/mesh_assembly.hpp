// The steps of a run (surface_run.hpp) that read no samples: checks, allocation, writing the cap.
#pragma once

#include "extract/boundary_cap.hpp"
#include "extract/edge_geometry.hpp"
#include "mesh/mesh_sink.hpp"

namespace isoextract::extract {

struct MeshSizes {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

// Fails with ErrorCode::usage for an iso value that is not finite, with ErrorCode::input for a transform that is
// singular or not finite.
[[nodiscard]] Result<void> check_request(const field::ScalarField& field, const ExtractOptions& options);

// Returns the part of options.region that is inside `box`, or the whole `box` if options.region is unset. Fails with
// ErrorCode::input if the result contains no cell (two samples along each axis).
[[nodiscard]] Result<field::IndexBox> clip_region(const field::ScalarField& field, const field::IndexBox& box,
                                                  const ExtractOptions& options);

// Fails with ErrorCode::input if float32 cannot hold the positions of the mesh (OutputPlacement::fits_float32()).
[[nodiscard]] Result<void> check_placement(const field::ScalarField& field, const OutputPlacement& placement);

// Fails with ErrorCode::input for more vertices than 32-bit indices can number.
[[nodiscard]] Result<void> check_vertex_count(const field::ScalarField& field, const MeshSizes& sizes);

// Reserves memory for the arrays of allocate_mesh(); `sizes` count the surface and the cap. Fails with
// ErrorCode::out_of_memory.
[[nodiscard]] Result<Reservation> reserve_mesh(const field::ScalarField& field, const MeshSizes& sizes,
                                               const ExtractOptions& options, const Context& context);

// Returns the sizes of surface and cap together, with the cap of all ranks.
[[nodiscard]] MeshSizes with_cap(const MeshSizes& surface, const BoundaryCap& cap);

// reserve_cap_numbers() reserves memory for the table of vertex numbers that building the cap needs. reserve_cap()
// reserves memory for the finished cap. Both fail with ErrorCode::out_of_memory.
[[nodiscard]] Result<Reservation> reserve_cap_numbers(const field::ScalarField& field, const field::IndexBox& box,
                                                      const Context& context);
[[nodiscard]] Result<Reservation> reserve_cap(const field::ScalarField& field, const BoundaryCap& cap,
                                              const Context& context);

// Returns the error about `count` NaN samples. The message names the first one by its index in the file; `first` is its
// index in the field.
[[nodiscard]] tl::unexpected<Error> nan_error(const field::ScalarField& field, std::uint64_t count,
                                              const glm::ivec3& first);

// Allocates the arrays of the mesh for surface and cap, uninitialized: normals and edge keys only if `options` ask for
// them.
void allocate_mesh(mesh::Mesh& mesh, const MeshSizes& surface, const BoundaryCap& cap, const ExtractOptions& options);

// Replaces unknown normals (OutputPlacement::placeholder_normal) by the mean of the normals of the triangles at the
// vertex, weighted by area. If that mean is zero up to rounding or the vertex has no triangle, the normal is the
// direction of the vertex's grid edge, from the inside sample to the outside one. Call it before append_cap(). Fails
// with ErrorCode::out_of_memory.
[[nodiscard]] Result<void> fill_normals(mesh::Mesh& mesh, const MeshSizes& surface, const field::ScalarField& field,
                                        const Context& context);

// Writes the cap of `box` into the arrays after the vertices and triangles of the surface, where allocate_mesh() left
// room for it.
void append_cap(mesh::Mesh& mesh, const MeshSizes& surface, const BoundaryCap& cap, const field::IndexBox& box,
                const OutputPlacement& placement);

// Returns `options`, without smooth_normals if the pass does not ask for normals.
[[nodiscard]] ExtractOptions options_in(const mesh::PartPass& pass, ExtractOptions options);
// Returns `sizes`, with 0 vertices or triangles if the pass asks for no array of them.
[[nodiscard]] MeshSizes sizes_in(const mesh::PartPass& pass, const MeshSizes& sizes);

// Hands the sink the arrays of `part` that the pass asks for, cut to the numbers of elements in `sizes`. `first` holds
// the numbers of the part's first vertex and first triangle in the whole mesh. Fails as the sink does.
[[nodiscard]] Result<void> deliver_part(mesh::MeshSink& sink, const mesh::PartPass& pass, const mesh::Mesh& part,
                                        const MeshSizes& first, const MeshSizes& sizes);

// Calls the sink's begin() with `shape` and, as far_vertices, the vertices of the surface that triangles of the cap
// use, or with `share` its shared vertices. Returns whether the sink takes the mesh. Fails with
// ErrorCode::out_of_memory, and as the sink does.
[[nodiscard]] Result<bool> offer_mesh(mesh::MeshSink& sink, mesh::MeshShape shape, const MeshSizes& surface,
                                      const BoundaryCap& cap, const std::optional<RankSlices>& share,
                                      const Context& context);

// Hands the cap of `box` to a sink in a pass: as the part that follows the surface, or the share of a rank in several
// parts. Fails with ErrorCode::out_of_memory, and as the sink does.
[[nodiscard]] Result<void> deliver_cap(mesh::MeshSink& sink, const mesh::PartPass& pass, const MeshSizes& surface,
                                       const BoundaryCap& cap, const field::IndexBox& box,
                                       const OutputPlacement& placement, const ExtractOptions& options,
                                       const Context& context);

}  // namespace isoextract::extract
