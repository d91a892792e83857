#include "field/dense_field.hpp"

#include <limits>
#include <memory>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "field/resample.hpp"
#include "field/sample_value.hpp"

namespace isoextract::field {
namespace {

constexpr std::size_t kConvertedPerTask = std::size_t{1} << 16;

template <class From, class To>
Result<DenseSamples> converted(const ScalarField& field, const DenseSamples& samples, const Context& context) {
  const std::size_t count = samples.count();
  auto made = TRY(make_reserved_buffer<To>(
      count, context,
      fmt::format("{}: {} samples of {}", field.source, count, sample_type_name(sample_type_of<To>()))));
  const From* const from = static_cast<const From*>(samples.data);
  To* const to = made->values.data();
  for_each_range(count, kConvertedPerTask, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) to[i] = to_sample<To>(field.scale(static_cast<double>(from[i])));
  });
  if (samples.lost()) {
    return fail(ErrorCode::input, field.source + ": the file became shorter, or reading it failed, during the run");
  }
  DenseSamples result;
  result.type = sample_type_of<To>();
  result.dims = samples.dims;
  result.data = to;
  result.owner = std::move(made);
  return result;
}

// Returns `field` with dense samples of the same type.
Result<ScalarField> without_sparse(const ScalarField& field, const Context& context) {
  if (std::holds_alternative<DenseSamples>(field.samples)) {
    ScalarField same = field;
    same.notes.clear();
    return same;
  }
  const glm::i64vec3 dims = resampled_box(field).dims();
  if (glm::any(glm::greaterThan(dims, glm::i64vec3(std::numeric_limits<int>::max())))) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected fewer than 2^31 samples along each axis, found {} x {} x {}", field.source,
                            dims.x, dims.y, dims.z));
  }
  return resample(field, glm::ivec3(dims), ResampleKernel::nearest, NanHandling::spread, context);
}

}  // namespace

Result<ScalarField> as_dense(const ScalarField& field, SampleType type, const Context& context) {
  auto dense = TRY(without_sparse(field, context));
  if (dense.type() == type && dense.scale.is_identity()) return dense;
  const auto& samples = std::get<DenseSamples>(dense.samples);
  auto values = TRY(visit_sample_type(samples.type, [&]<class From>(std::type_identity<From>) {
    if (type == SampleType::f16) return converted<From, Half>(dense, samples, context);
    if (type == SampleType::f32) return converted<From, float>(dense, samples, context);
    return converted<From, double>(dense, samples, context);
  }));
  TRY(context.check());
  dense.samples = std::move(values);
  dense.scale = {};
  return dense;
}

}  // namespace isoextract::field
