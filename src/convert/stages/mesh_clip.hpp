// Where a mesh is cut: at planes that were asked for, and at the faces of a region that are not along samples.
#pragma once

#include <vector>

#include "convert/conversion_job.hpp"
#include "mesh/half_space.hpp"

namespace isoextract::convert {

// The half-spaces of `planes`, which are in the coordinates of placement.space, in those of the mesh.
[[nodiscard]] std::vector<mesh::HalfSpace> half_spaces_of(const field::ScalarField& field,
                                                          const field::Affine& output_from_index, Space space,
                                                          const std::vector<ClipPlane>& planes);

}  // namespace isoextract::convert
