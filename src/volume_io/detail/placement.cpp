#include "volume_io/detail/placement.hpp"

#include <fmt/format.h>

namespace isoextract::volume_io {
namespace {

std::string dims_text(const glm::ivec3& dims) { return fmt::format("{} x {} x {}", dims.x, dims.y, dims.z); }

// Returns the placement that `other` gives to a file without one.
Result<field::Affine> placement_by_reference(field::ScalarField& field, const ReferenceVolume& other) {
  const std::string states_none = field.source + " states no spacing and no origin";
  if (other.spacing) {
    if (!other.origin)
      field.notes.push_back(
          {NoteId::placement_assumed, states_none + ": the program places its first sample at 0,0,0"});
    return field::Affine{field::scaling(*other.spacing).linear, other.origin.value_or(glm::dvec3(0))};
  }
  const glm::ivec3 dims = field.extents().max + 1;
  if (dims != other.dims) {
    if (other.dims == glm::ivec3(0)) {
      return fail(ErrorCode::input,
                  fmt::format("{} states no spacing and no origin, and {}, a sparse grid, cannot place it: expected "
                              "a spacing after the file name, found none",
                              field.source, other.source),
                  "add its placement to the name: NAME=FILE:spacing=SX,SY,SZ:origin=X,Y,Z");
    }
    return fail(ErrorCode::input,
                fmt::format("{} states no spacing and no origin, so its samples must be on the grid of {}: expected {} "
                            "samples, found {}",
                            field.source, other.source, dims_text(other.dims), dims_text(dims)),
                "add spacing and origin to the name: NAME=FILE:spacing=SX,SY,SZ:origin=X,Y,Z");
  }
  if (other.source != field.source) {
    field.notes.push_back(
        {NoteId::placement_assumed,
         fmt::format("{}: the program places it on the grid of {}, which has {} samples too{}", states_none,
                     other.source, dims_text(dims), other.origin ? ", but at the given origin" : "")});
  }
  return field::Affine{other.index_to_world.linear, other.origin.value_or(other.index_to_world.offset)};
}

// Returns the file's placement, with spacing and origin replaced by the options.
Result<field::Affine> placement_of_file(field::ScalarField& field, const Frame& frame, const ReadOptions& options) {
  field::Affine affine = frame.index_to_world;
  if (options.spacing) {
    // For an axis-aligned transform the spacing replaces all nonzero entries.
    const glm::dmat3 diagonal = field::scaling({affine.linear[0][0], affine.linear[1][1], affine.linear[2][2]}).linear;
    const bool mirrored = affine.linear[0][0] < 0 || affine.linear[1][1] < 0 || affine.linear[2][2] < 0;
    if (!frame.problem.empty()) {
      field.notes.push_back({NoteId::placement_replaced,
                             fmt::format("the given spacing replaces the placement in the file ({})", frame.problem)});
      affine = {};
    } else if (affine.linear != diagonal || mirrored) {
      field.notes.push_back(
          {NoteId::placement_replaced, "the given spacing replaces the rotated, sheared or mirrored axes of the file"});
    }
    affine.linear = field::scaling(*options.spacing).linear;
  } else if (!frame.problem.empty()) {
    return fail(ErrorCode::input, fmt::format("{}: {}", field.source, frame.problem),
                {Remedy::give, Setting::spacing_and_origin});
  }
  if (options.origin) affine.offset = *options.origin;
  return affine;
}

}  // namespace

Result<void> set_placement(field::ScalarField& field, const Frame& frame, const ReadOptions& options) {
  const bool beside = !frame.stated && options.beside;
  const auto tell = [&](const Notes& assumed) {
    field.notes.insert(field.notes.end(), assumed.begin(), assumed.end());
  };
  if (!beside && !options.spacing) tell(frame.assumed_axes);
  if (!beside && !options.origin) tell(frame.assumed_origin);
  auto placed = TRY(beside ? placement_by_reference(field, *options.beside) : placement_of_file(field, frame, options));
  const field::Affine& affine = placed;
  if (!affine.is_invertible()) {
    return fail(ErrorCode::input,
                field.source + ": in world coordinates, the axes of the volume are linearly dependent, or not finite",
                {Remedy::give, Setting::spacing_and_origin});
  }
  field.index_to_world = affine;
  return {};
}

}  // namespace isoextract::volume_io
