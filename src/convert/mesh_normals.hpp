// The stage that makes normals fit the triangles that are written: those of caps, of simplified meshes, and where they
// are asked for of the triangles.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "extract/extractor.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

// Triangles of simplified meshes whose planes turn by more than this have a crease between them.
constexpr double kCreaseDegrees = 30;

// Whether vertices may be copied for their normals.
[[nodiscard]] bool copies_vertices(const ConversionJob& job);

// Whether a surface that was extracted so may have a border.
[[nodiscard]] bool may_be_open(const extract::ExtractStats& stats, const extract::ExtractOptions& extracted);

}  // namespace isoextract::convert
