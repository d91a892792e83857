#include "points/detail/source_points.hpp"

namespace isoextract::points {

Result<SourcePoints> SourcePoints::make(const ParticleSet& particles, double support, const Context& context) {
  SourcePoints points;
  points.positions_ = particles.positions.span();
  points.support_ = support;
  if (!(particles.box && particles.box->is_periodic())) return points;
  points.box_ = TRY(BoxSamples::make(*particles.box, support, particles.label));
  // Images within 2 supports: kernels reach 1 support, and the neighbors that determine their densities 1 more.
  points.images_ = TRY(with_images(points.positions_, *points.box_, points.box_->extent_of_ball(2),
                                   Coordinates::cartesian, context, particles.label));
  points.positions_ = points.images_->positions();
  points.support_ = 1;
  return points;
}

}  // namespace isoextract::points
