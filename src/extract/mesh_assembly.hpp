// The parts of a run (surface_run.hpp) that look at no sample: checks, allocation, the cap's part of a mesh.
#pragma once

#include <new>
#include <stdexcept>
#include <variant>

#include "extract/border_cap.hpp"
#include "extract/edge_geometry.hpp"

namespace isoextract::extract {

struct MeshSizes {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

// What no extraction can be made with: ErrorKind::usage for an iso value that is not finite, ErrorKind::input for a
// placement that flattens space.
[[nodiscard]] Result<void> check_request(const field::ScalarField& field, const ExtractOptions& options);

// The frame of every extraction: check_request(), `extract` with the field's samples, dense or sparse, and the mesh's
// name. Memory that runs out is ErrorKind::input.
template <class Extract>
[[nodiscard]] Result<Extraction> extract_guarded(const field::ScalarField& field, const ExtractOptions& options,
                                                 const Extract& extract) {
  constexpr const char* kHint = "extract it in parts with --roi";
  if (auto sound = check_request(field, options); !sound) return tl::unexpected(sound.error());
  try {
    Result<Extraction> result = std::visit(extract, field.samples);
    if (result) result->mesh.name = field.name;
    return result;
  } catch (const std::bad_alloc&) {
    return fail(ErrorKind::input, field.source + ": not enough memory for the surface", kHint);
  } catch (const std::length_error&) {
    return fail(ErrorKind::input, field.source + ": the surface is larger than memory can be", kHint);
  }
}

// The samples to extract from: the part of options.region within `box`. Fails with ErrorKind::input where that holds no
// cell (two samples along each axis).
[[nodiscard]] Result<field::IndexBox> clip_region(const field::ScalarField& field, const field::IndexBox& box,
                                                  const ExtractOptions& options);

// Fails with ErrorKind::input where float32 cannot hold the mesh (OutputFrame::fits_float32).
[[nodiscard]] Result<void> check_placement(const field::ScalarField& field, const OutputFrame& placement);

// Vertex numbers are 32-bit, and the mesh must fit into the memory limit.
[[nodiscard]] Result<void> check_mesh_size(const field::ScalarField& field, const MeshSizes& sizes,
                                           const ExtractOptions& options);

// The sizes of surface and cap together.
[[nodiscard]] MeshSizes with_cap(const MeshSizes& surface, const BorderCap& cap);

// What numbering the cap's vertices needs, held against the memory limit.
[[nodiscard]] Result<void> check_cap_size(const field::ScalarField& field, const field::IndexBox& box,
                                          const ExtractOptions& options);

// `first` is told as an index of the file.
[[nodiscard]] tl::unexpected<Error> nan_error(const field::ScalarField& field, std::uint64_t count,
                                              const glm::ivec3& first);

// Room for the surface and the cap; nothing is initialised.
void allocate_mesh(mesh::Mesh& mesh, const MeshSizes& surface, const BorderCap& cap, const ExtractOptions& options);

// Writes the cap of `box` behind the surface.
void append_cap(mesh::Mesh& mesh, const MeshSizes& surface, const BorderCap& cap, const field::IndexBox& box,
                const OutputFrame& placement);

}  // namespace isoextract::extract
