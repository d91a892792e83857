#include "points/detail/periodic_images.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/number_text.hpp"

namespace isoextract::points {
namespace {

// Converts a number of images for an allocation; fails if 32-bit indices do not suffice.
Result<std::size_t> checked_count(double images, const std::string& label) {
  if (images < static_cast<double>(std::numeric_limits<std::uint32_t>::max())) return static_cast<std::size_t>(images);
  return fail(
      ErrorCode::input,
      fmt::format("{}: expected fewer than 2^32 particles with their periodic images, found {:.3g}: the kernels "
                  "reach too far for the periodic box",
                  label, images),
      {Remedy::lower, Setting::radius});
}

Ellipsoid in_index_coordinates(const Ellipsoid& shape, const BoxSamples& box) {
  const glm::dmat3 form(shape.xx, shape.xy, shape.xz, shape.xy, shape.yy, shape.yz, shape.xz, shape.yz, shape.zz);
  const glm::dmat3& map = box.cartesian_from_index();
  const glm::dmat3 mapped = glm::transpose(map) * form * map;
  return {static_cast<float>(mapped[0][0]),
          static_cast<float>(mapped[1][0]),
          static_cast<float>(mapped[2][0]),
          static_cast<float>(mapped[1][1]),
          static_cast<float>(mapped[2][1]),
          static_cast<float>(mapped[2][2]),
          static_cast<float>(box.longest_stretch() * static_cast<double>(shape.reach))};
}

Ellipsoid ball(double radius) {
  const auto form = static_cast<float>(1 / (radius * radius));
  return {form, 0, 0, form, 0, form, static_cast<float>(radius)};
}

}  // namespace

field::IndexBox needed_samples(const BoxSamples& box, int more) {
  field::IndexBox needed = box.region();
  for (int k = 0; k < 3; ++k) {
    if (needed.min[k] != 0) continue;  // an edge without periods, along which the region is unbounded
    needed.min[k] -= kPeriodicMargin + more;
    needed.max[k] += kPeriodicMargin + more;
  }
  return needed;
}

glm::dvec3 reach_of_images(const glm::dvec3& extent, int more) {
  return extent + static_cast<double>(kPeriodicMargin + more + field::SparseBlock::kSize - 1);
}

Result<ParticleImages> with_images(std::span<const glm::dvec3> positions, const BoxSamples& box,
                                   const glm::dvec3& reach, Coordinates coordinates, const Context& context,
                                   const std::string& label) {
  double images = static_cast<double>(positions.size());
  for (const glm::dvec3& p : positions) {
    if (!is_finite(p)) continue;
    const glm::dvec3 index = box.wrapped_index(p);
    if (!(std::max({std::abs(index.x), std::abs(index.y), std::abs(index.z)}) < field::kMaxSparseIndex / 2.0)) {
      return fail(ErrorCode::input,
                  fmt::format("{}: a particle at {} is more than {} samples away from the "
                              "origin of the periodic box",
                              label, point_text(p), field::kMaxSparseIndex / 2),
                  {{Remedy::set, Setting::selection, "CONDITION to leave stray particles out"},
                   {Remedy::raise, Setting::cell_size}});
    }
    images += box.count_images(index, reach) - 1;
  }
  const std::size_t count = TRY(checked_count(images, label));
  const std::string what = fmt::format("{}: {} particles and periodic images", label, count);
  ParticleImages all;
  all.places = TRY(make_reserved_buffer<glm::dvec3>(count, context, what));
  all.sources = TRY(make_reserved_buffer<std::uint32_t>(count, context, what));
  const glm::dmat3 map = coordinates == Coordinates::cartesian ? box.cartesian_from_index() : glm::dmat3(1.0);
  std::size_t next = positions.size();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    all.places->values[i] = positions[i];
    all.sources->values[i] = static_cast<std::uint32_t>(i);
    if (!is_finite(positions[i])) continue;
    const glm::dvec3 index = box.wrapped_index(positions[i]);
    all.places->values[i] = map * index;
    box.for_each_image(index, reach, [&](const glm::dvec3& image) {
      if (image == index) return;
      all.places->values[next] = map * image;
      all.sources->values[next++] = static_cast<std::uint32_t>(i);
    });
  }
  return all;
}

Result<RepeatedKernels> repeat_kernels(const KernelSet& kernels, const std::function<bool(std::size_t)>& is_original,
                                       const BoxSamples& box, int more, const Context& context,
                                       const std::string& label) {
  const CellGrid& from = *kernels.grid;
  const auto reach_of = [&](std::size_t s) {
    const double reach = kernels.shapes != nullptr ? static_cast<double>(kernels.shapes[s].reach) : kernels.reach;
    return reach_of_images(box.extent_of_ball(reach), more);
  };
  const auto index_of = [&](std::size_t s) { return box.index_from_cartesian() * from.position(s); };
  double images = 0;
  for (std::size_t s = 0; s < from.size(); ++s) {
    if (is_original(s)) images += box.count_images(index_of(s), reach_of(s));
  }
  const std::size_t count = TRY(checked_count(images, label));
  const std::string what = fmt::format("{}: {} kernels and periodic images", label, count);
  auto centers = TRY(make_reserved_buffer<glm::dvec3>(count, context, what));
  auto sources = TRY(make_reserved_buffer<std::uint32_t>(count, context, what));
  std::size_t next = 0;
  for (std::size_t s = 0; s < from.size(); ++s) {
    if (!is_original(s)) continue;
    box.for_each_image(index_of(s), reach_of(s), [&](const glm::dvec3& image) {
      centers->values[next] = image;
      sources->values[next++] = static_cast<std::uint32_t>(s);
    });
  }
  TRY(context.check());

  RepeatedKernels repeated;
  const bool are_balls = kernels.shapes == nullptr && box.cubic_step();
  repeated.reach = are_balls ? kernels.reach / *box.cubic_step() : kernels.reach * box.longest_stretch();
  repeated.grid = TRY(CellGrid::make(std::as_const(centers->values).span(), GridFrame{}, std::max(repeated.reach, 2.0),
                                     CellGrid::Coinciding::apart, context, label));
  repeated.weights = TRY(make_reserved_buffer<float>(count, context, what));
  repeated.counts = TRY(make_reserved_buffer<std::uint32_t>(count, context, what));
  if (!are_balls) repeated.shapes = TRY(make_reserved_buffer<Ellipsoid>(count, context, what));
  const Ellipsoid common = in_index_coordinates(ball(kernels.reach), box);
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t image = repeated.grid.members(s)[0];
    const std::size_t source = sources->values[image];
    repeated.weights->values[s] = kernels.weights[source];
    const std::size_t particles = kernels.counts != nullptr ? kernels.counts[source] : from.members(source).size();
    const bool is_image = centers->values[image] != index_of(source);
    repeated.counts->values[s] = is_image ? 0 : static_cast<std::uint32_t>(particles);
    if (repeated.shapes) {
      repeated.shapes->values[s] =
          kernels.shapes != nullptr ? in_index_coordinates(kernels.shapes[source], box) : common;
    }
  }
  return repeated;
}

}  // namespace isoextract::points
