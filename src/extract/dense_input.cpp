#include "extract/dense_input.hpp"

#include <fmt/format.h>

namespace isoextract::extract {

Result<field::IndexBox> dense_region(const field::ScalarField& field, const field::DenseSamples& samples,
                                     const ExtractOptions& options) {
  constexpr int kMaxDim = 1 << 30;  // positions in a row are ints
  if (glm::any(glm::greaterThan(samples.dims, glm::ivec3(kMaxDim)))) {
    return fail(ErrorCode::input, fmt::format("{}: expected at most {} samples along an axis, found {} x {} x {}",
                                              field.source, kMaxDim, samples.dims.x, samples.dims.y, samples.dims.z));
  }
  return clip_region(field, {glm::ivec3(0), samples.dims - 1}, options);
}

Result<DenseMasks> make_masks(const field::ScalarField& field, const glm::ivec3& dims, int slices,
                              const Context& context) {
  auto memory = TRY(context.reserve(
      DenseMasks::bytes({dims.x, dims.y, slices}),
      fmt::format("{}: the inside masks of its {} x {} x {} samples", field.source, dims.x, dims.y, slices)));
  return DenseMasks(dims, slices, std::move(memory));
}

}  // namespace isoextract::extract
