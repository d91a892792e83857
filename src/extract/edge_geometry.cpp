#include "extract/edge_geometry.hpp"

#include <algorithm>

#include "mesh/local_origin.hpp"

namespace isoextract::extract {
namespace {

double max_component(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

constexpr double kLargestMargin = 0x1p-6;
constexpr double kRounding = 0x1p-24;  // half a unit in the last place of 1, as float32

// Returns eight times the float32 rounding error, as a fraction of the shortest grid step along which the error can
// move a vertex. At 512 samples a side, the result is 0.0002 of an edge.
double wanted_margin(const field::Affine& local_from_index, const field::Box& local) {
  constexpr double kFactor = 8;
  const glm::dvec3 farthest = glm::max(glm::abs(local.min), glm::abs(local.max));
  double margin = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 step = local_from_index.linear[axis];
    const double length = glm::length(step);
    for (int component = 0; component < 3; ++component) {
      if (std::abs(step[component]) <= 1e-9 * length) continue;
      margin = std::max(margin, kFactor * kRounding * farthest[component] / length);
    }
  }
  return margin;
}

// Returns how far rounding to float32 can move a vertex along any axis of the index space.
double rounding_in_index_space(const glm::dmat3& covector_map, const field::Box& local) {
  const glm::dvec3 farthest = glm::max(glm::abs(local.min), glm::abs(local.max));
  double most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    most = std::max(most, kRounding * glm::dot(glm::abs(covector_map[axis]), farthest));
  }
  return most;
}

}  // namespace

OutputPlacement::OutputPlacement(const field::Affine& output_from_index, const field::IndexBox& box,
                                 field::FieldKind kind, const field::ValueScale& scale)
    : local_from_index_(output_from_index),
      covector_map_(glm::transpose(glm::inverse(output_from_index.linear))),
      outward_((kind == field::FieldKind::level_set) == (scale.slope > 0) ? 1 : -1),
      mirrored_(output_from_index.determinant() < 0) {
  const field::Box world = field::image_of(output_from_index, {glm::dvec3(box.min), glm::dvec3(box.max)});
  origin_ = mesh::choose_local_origin(world.min, world.max);
  local_from_index_.offset -= origin_;
  const field::Box local{world.min - origin_, world.max - origin_};
  const double margin = wanted_margin(local_from_index_, local);
  margin_ = std::min(margin, kLargestMargin);

  // Two vertices on different edges differ along some axis of the index space by the margin at least.
  constexpr double kRoundings = 3;  // one of each vertex, and one for safety
  keeps_apart_ = margin_ > kRoundings * rounding_in_index_space(covector_map_, local);
  const double farthest = max_component(glm::max(glm::abs(local.min), glm::abs(local.max)));
  double shortest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) shortest = std::min(shortest, glm::length(local_from_index_.linear[axis]));
  constexpr double kRoundingEats = 16;  // times the largest margin; rounding is then twice the margin
  in_range_ = farthest < std::numeric_limits<float>::max() && shortest * margin_ > std::numeric_limits<float>::min();
  reaches_too_far_ = !(margin <= kRoundingEats * kLargestMargin);
}

glm::vec3 OutputPlacement::normal(const glm::dvec3& gradient, const glm::dvec3& out) const {
  const glm::dvec3 mapped = covector_map_ * (outward_ * gradient);
  // Scales before taking the length: squares of very large or very small gradients leave the range of double.
  const double largest = max_component(glm::abs(mapped));
  if (largest > 0 && std::isfinite(largest)) {
    const glm::dvec3 scaled = mapped / largest;
    const double length = glm::length(scaled);
    if (std::isfinite(length) && length > 0) return scaled / length;
  }
  return glm::normalize(local_from_index_.linear * out);
}

OutputPlacement output_placement(const field::ScalarField& field, const ExtractOptions& options,
                                 const field::IndexBox& stored, const field::IndexBox& region) {
  // Farther than one step from the stored samples, only caps have triangles.
  field::IndexBox drawn = region;
  if (!options.cap) drawn = {glm::max(region.min, stored.min - 1), glm::min(region.max, stored.max + 1)};
  if (drawn.empty()) drawn = {region.min, region.min};
  const auto holds = [](const field::IndexBox& box, const field::IndexBox& other) {
    return glm::all(glm::lessThanEqual(box.min, other.min)) && glm::all(glm::greaterThanEqual(box.max, other.max));
  };
  if (holds({stored.min - 1, stored.max + 1}, drawn)) {
    const OutputPlacement whole(options.output_from_index, stored, field.kind, field.scale);
    constexpr double kSharedMargin = 0x1p-12;  // the margin of about 512 samples a side
    if (options.shared_origin || holds(drawn, stored) || whole.margin() <= kSharedMargin) return whole;
  }
  return {options.output_from_index, drawn, field.kind, field.scale};
}

}  // namespace isoextract::extract
