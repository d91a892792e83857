// What a mesh has lost of the isosurface of its data: how far that is from the mesh. field_error measures the other
// way, from the mesh, and sees nothing of a part that has no triangle.
//
// The isosurface is that of all stored samples, extracted by marching cubes. Its vertices are the crossings of the
// edges between them, and from each the nearest point of the mesh is looked for. A part of it that hangs together
// counts as lost where no vertex of the mesh is nearer to it than to every other part: that needs no distance to be
// chosen, and a small part beside a large one is not taken for there because the large one is near.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "base/context.hpp"
#include "base/error.hpp"
#include "extract/extractor.hpp"
#include "measure/error_statistics.hpp"
#include "mesh/half_space.hpp"

namespace isoextract::measure {

struct SurfaceCoverage {
  ErrorStatistics distances;     // of the crossings from the mesh, each alike; without points where it has no triangle
  std::uint64_t components = 0;  // of the isosurface
  std::uint64_t lost = 0;        // of these
};

// As measure_field_error(): `extracted` is how `mesh` was extracted from `field`, or from `grid` if there is one, which
// resample() made of it. Where a region cuts voxels of the field, only whole ones within it are looked at; nothing
// where there is none. Of a mesh that was cut, `clipped` says what was kept, in its coordinates, and
// nothing else of the isosurface counts. Memory is reserved. Fails as an extraction of the field does. The same answer
// for any number of threads.
[[nodiscard]] Result<std::optional<SurfaceCoverage>> measure_surface_coverage(
    const mesh::Mesh& mesh, const field::ScalarField& field, const extract::ExtractOptions& extracted,
    const field::ScalarField* grid, std::span<const mesh::HalfSpace> clipped = {}, const Context& context = Context());

}  // namespace isoextract::measure
