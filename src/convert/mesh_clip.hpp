// The stage that cuts a mesh: at planes that were asked for, and at a region of the world where the samples' axes are
// oblique to it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "edit/half_space_clip.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

// The half-spaces that `planes` and `box` stand for, both in the coordinates of placement.space, in those of the mesh.
[[nodiscard]] std::vector<mesh::HalfSpace> half_spaces_of(const field::ScalarField& field,
                                                          const field::Affine& output_from_index, Space space,
                                                          const std::vector<ClipPlane>& planes,
                                                          const std::optional<field::Box>& box);

[[nodiscard]] inline edit::CutEnds cut_ends(const SurfaceOptions& surface) {
  return surface.cap ? edit::CutEnds::capped : edit::CutEnds::open;
}

// Keeps what lies in all of them, closed there if `ends` says so, and tells how much that is. Nothing happens where
// there are none.
[[nodiscard]] Result<void> clip_mesh(mesh::Mesh& mesh, std::span<const mesh::HalfSpace> kept, edit::CutEnds ends,
                                     const std::string& label, const Context& context, Events& events);

}  // namespace isoextract::convert
