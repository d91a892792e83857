// Requirements of a mesh that goes to its file part by part (the stage require_properties() tests meshes in memory).
#pragma once

#include <span>

#include "base/error.hpp"
#include "check/mesh_requirement.hpp"
#include "convert/stages/surface_stages.hpp"
#include "mesh/mesh_measures.hpp"

namespace isoextract::convert {

// Returns whether the measures of a mesh tell if it meets these requirements.
[[nodiscard]] bool tests_by_parts(std::span<const check::Requirement> required);

// Fails with ErrorCode::verification if the surface `id`, with these measures, does not meet the job's requirements.
[[nodiscard]] Result<void> require_of_parts(const mesh::MeshMeasures& measures, const SurfaceId& id,
                                            const StageContext& stage);

}  // namespace isoextract::convert
