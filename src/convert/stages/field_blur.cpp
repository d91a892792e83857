#include "convert/stages/field_blur.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/stopwatch.hpp"
#include "field/blur.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {
namespace {

// Returns the standard deviation along each axis of the grid, in voxels.
glm::dvec3 sigma_of(const BlurStep& step, const field::ScalarField& field) {
  if (!step.in_world_units) return glm::dvec3(step.size);
  glm::dvec3 sigma;
  for (int axis = 0; axis < 3; ++axis) sigma[axis] = step.size / glm::length(field.index_to_world.linear[axis]);
  return sigma;
}

std::string blurred_text(const field::ScalarField& field) {
  if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
    return fmt::format("{} of {}", counted(dense->count(), "sample"), field::sample_type_name(field.type()));
  }
  return fmt::format("{} (8x8x8) of {}", counted(std::get<field::SparseSamples>(field.samples).blocks.size(), "brick"),
                     field::sample_type_name(field.type()));
}

}  // namespace

std::string text_of(const BlurStep& step) {
  if (step.kind == BlurKind::median) return fmt::format("a median of {} on either side", counted(step.size, "voxel"));
  return step.in_world_units ? fmt::format("a Gaussian of {} of the input's units", step.size)
                             : "a Gaussian of " + counted(step.size, "voxel");
}

Result<void> blur_field(const std::vector<BlurStep>& steps, const std::string& label, const Context& context,
                        Events& events, field::ScalarField& field) {
  for (const BlurStep& step : steps) {
    const Stopwatch watch;
    const glm::dvec3 sigma = sigma_of(step, field);
    if (step.kind == BlurKind::gaussian && glm::any(glm::greaterThan(sigma, glm::dvec3(field::kMaxBlurSigma)))) {
      return fail(ErrorCode::usage, fmt::format("{}: {} is {:.4g} x {:.4g} x {:.4g} voxels; the limit is {} voxels",
                                                label, text_of(step), sigma.x, sigma.y, sigma.z, field::kMaxBlurSigma));
    }
    auto blurred =
        TRY(step.kind == BlurKind::gaussian ? field::blur_gaussian(field, sigma, context)
                                            : field::blur_median(field, static_cast<int>(step.size), context));
    TRY(volume_io::check_mapping_intact(field));
    const std::string in_voxels =
        step.in_world_units ? fmt::format(", {:.4g} x {:.4g} x {:.4g} voxels", sigma.x, sigma.y, sigma.z) : "";
    field = std::move(blurred);
    events.end(report_on_field(StageName::filter, label,
                               {WorkTopic::blur, WorkDone::blurred, std::nullopt, std::nullopt,
                                fmt::format("the samples by {}{}: {}", text_of(step), in_voxels, blurred_text(field))},
                               watch.elapsed()));
    TRY(context.check());
  }
  return {};
}

}  // namespace isoextract::convert
