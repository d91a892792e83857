// The stage that fits vertex normals to the written triangles: on caps, on simplified meshes, and with Normals::area.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "extract/extractor.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

// Simplified meshes get a crease at edges of flat parts where the planes of the triangles differ by more than this
// angle (mesh::ShadingOptions::crease_degrees).
constexpr double kCreaseDegrees = 30;

// Returns whether the normals stage may duplicate vertices, to give each copy another normal.
[[nodiscard]] bool copies_vertices(const ConversionJob& job);

// Returns whether a surface may be open, given the options `extracted` and the result `stats` of its extraction.
// Boundary edges at the T-junctions of VoxelFaces::rectangles do not count.
[[nodiscard]] bool may_be_open(const extract::ExtractStats& stats, const extract::ExtractOptions& extracted);

}  // namespace isoextract::convert
