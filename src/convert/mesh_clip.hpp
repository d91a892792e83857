// The stage that cuts a mesh: at planes that were asked for, and at the faces of a region that are not along samples.
#pragma once

#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"
#include "edit/half_space_clip.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

// The half-spaces of `planes`, which are in the coordinates of placement.space, in those of the mesh.
[[nodiscard]] std::vector<mesh::HalfSpace> half_spaces_of(const field::ScalarField& field,
                                                          const field::Affine& output_from_index, Space space,
                                                          const std::vector<ClipPlane>& planes);

// Keeps what lies in all of source.clip, closed there if the job says so, and tells how much that is. Nothing happens
// where there are none.
[[nodiscard]] Result<edit::ClipFacts> clip_mesh(mesh::Mesh& mesh, const ConversionJob& job, const Source& source,
                                                const std::string& label, const Context& context, Events& events);

}  // namespace isoextract::convert
