// The stage that clips a mesh: at the requested planes, and at faces of a region that lie between samples.
#pragma once

#include <vector>

#include "convert/conversion_job.hpp"
#include "mesh/half_space.hpp"

namespace isoextract::convert {

// Returns the half-spaces of `planes` in the mesh's coordinates; `planes` are in the coordinates of `space`.
[[nodiscard]] std::vector<mesh::HalfSpace> half_spaces_of(const field::ScalarField& field,
                                                          const field::Affine& output_from_index, Space space,
                                                          const std::vector<ClipPlane>& planes);

}  // namespace isoextract::convert
