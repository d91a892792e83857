#include <algorithm>
#include <cmath>
#include <iterator>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "field/blur.hpp"
#include "field/detail/blurred_samples.hpp"
#include "field/sample_value.hpp"

namespace isoextract::field {
namespace {

// Returns the lower median of at least one value, none of them NaN.
template <class T>
T median_of(std::vector<T>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <class T>
bool is_nan(T value) {
  if constexpr (is_floating_sample<T>) return std::isnan(static_cast<double>(value));
  return false;
}

template <class T>
Result<Samples> median_dense(const ScalarField& field, const DenseSamples& data, int radius, const Context& context) {
  auto made = TRY(make_reserved_buffer<T>(data.count(), context, memory_label(field)));
  T* const values = made->values.data();
  const auto* from = static_cast<const T*>(data.data);
  const glm::i64vec3 dims(data.dims);
  tbb::enumerable_thread_specific<std::vector<T>> windows;
  for_each_slice(data, radius, context, [&](int k, std::size_t first, std::size_t) {
    std::vector<T>& window = windows.local();
    T* to = values + first;
    for (int j = 0; j < data.dims.y; ++j) {
      for (int i = 0; i < data.dims.x; ++i, ++to) {
        const glm::ivec3 at(i, j, k);
        const glm::ivec3 low = glm::max(at - radius, glm::ivec3(0));
        const glm::ivec3 high = glm::min(at + radius, data.dims - 1);
        *to = from[i + dims.x * (j + dims.y * k)];
        if (is_nan(*to)) continue;
        window.clear();
        for (std::int64_t z = low.z; z <= high.z; ++z) {
          for (std::int64_t y = low.y; y <= high.y; ++y) {
            const T* row = from + dims.x * (y + dims.y * z);
            std::copy_if(row + low.x, row + high.x + 1, std::back_inserter(window), [](T v) { return !is_nan(v); });
          }
        }
        *to = median_of(window);
      }
    }
    context.progress().advance(1);
  });
  TRY(context.check());
  DenseSamples blurred;
  blurred.type = data.type;
  blurred.dims = data.dims;
  blurred.data = values;
  blurred.owner = std::move(made);
  return blurred;
}

template <class T>
void median_block(int radius, const glm::ivec3& dims, const double* values, T* block) {
  std::vector<double> window;
  const auto value = [&](int x, int y, int z) {
    return values +
           (static_cast<std::size_t>(x) * static_cast<std::size_t>(dims.y) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(dims.z) +
           z;
  };
  for (int x = 0; x < kBlurBlockSide; ++x) {
    for (int y = 0; y < kBlurBlockSide; ++y) {
      for (int z = 0; z < kBlurBlockSide; ++z, ++block) {
        const double here = *value(x + radius, y + radius, z + radius);
        *block = to_sample<T>(here);
        if (std::isnan(here)) continue;
        window.clear();
        for (int i = x; i <= x + 2 * radius; ++i) {
          for (int j = y; j <= y + 2 * radius; ++j) {
            std::copy_if(value(i, j, z), value(i, j, z + 2 * radius + 1), std::back_inserter(window),
                         [](double v) { return !std::isnan(v); });
          }
        }
        *block = to_sample<T>(median_of(window));
      }
    }
  }
}

}  // namespace

Result<ScalarField> blur_median(const ScalarField& field, int radius, const Context& context) {
  if (radius < 1 || radius > kMaxMedianRadius) {
    return fail(ErrorCode::usage, fmt::format("{}: median blur: expected a radius of 1 to {} voxels, found {}",
                                              field.source, kMaxMedianRadius, radius));
  }
  context.progress().begin("blurring", 0);
  auto samples = TRY(visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) -> Result<Samples> {
    if (const auto* dense = std::get_if<DenseSamples>(&field.samples)) {
      return median_dense<T>(field, *dense, radius, context);
    }
    return blur_sparse<T, T>(field, std::get<SparseSamples>(field.samples), glm::ivec3(radius), 1, context,
                             [&](const glm::ivec3& dims, const double* values, double*, T* block) {
                               median_block(radius, dims, values, block);
                             });
  }));
  ScalarField blurred = without_samples(field);
  blurred.samples = std::move(samples);
  return blurred;
}

}  // namespace isoextract::field
