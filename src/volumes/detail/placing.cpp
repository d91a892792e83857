#include "volumes/detail/placing.hpp"

#include <fmt/format.h>

namespace isoextract::volumes {

Result<void> set_frame(field::ScalarField& field, const Frame& frame, const ReadOptions& options) {
  field::Affine affine = frame.index_to_world;
  if (options.spacing) {
    // An axis-aligned frame has no other entries than those that the spacing replaces.
    const glm::dmat3 diagonal = field::scaling({affine.linear[0][0], affine.linear[1][1], affine.linear[2][2]}).linear;
    const bool mirrored = affine.linear[0][0] < 0 || affine.linear[1][1] < 0 || affine.linear[2][2] < 0;
    if (!frame.problem.empty()) {
      field.notes.push_back(fmt::format("the given spacing replaces the frame of the file ({})", frame.problem));
      affine = {};
    } else if (affine.linear != diagonal || mirrored) {
      field.notes.emplace_back("the given spacing replaces the rotated, sheared or mirrored axes of the file");
    }
    affine.linear = field::scaling(*options.spacing).linear;
  } else if (!frame.problem.empty()) {
    return fail(ErrorKind::input, fmt::format("{}: {}", field.source, frame.problem), Remedy::place_by_hand);
  }
  if (options.origin) affine.offset = *options.origin;
  if (!affine.is_regular()) {
    return fail(ErrorKind::input, field.source + ": the axes of the volume are flat or not finite in the world",
                Remedy::place_by_hand);
  }
  field.index_to_world = affine;
  return {};
}

}  // namespace isoextract::volumes
