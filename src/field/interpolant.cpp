#include "field/interpolant.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace isoextract::field {
namespace {

// The weights of an axis' samples in the value and in its derivative.
struct CellWeights {
  std::array<double, 4> value{};
  std::array<double, 4> slope{};
};

CellWeights linear_weights(double t) { return {{1 - t, t}, {-1, 1}}; }

CellWeights catmull_rom_weights(double t) {
  const double t2 = t * t;
  const double t3 = t * t2;
  return {{(-t + 2 * t2 - t3) / 2, (2 - 5 * t2 + 3 * t3) / 2, (t + 4 * t2 - 3 * t3) / 2, (t3 - t2) / 2},
          {(-1 + 4 * t - 3 * t2) / 2, (-10 * t + 9 * t2) / 2, (1 + 8 * t - 9 * t2) / 2, (3 * t2 - 2 * t) / 2}};
}

// Moves the weight of a sample outside the boundary to the samples inside: the parabola through the last three samples,
// or the line through the only two, gives the value outside. So the slope at the boundary is the one-sided second-order
// difference.
void fold_outer_weights(std::array<double, 4>& weights, bool low, bool high) {
  const double before = low ? std::exchange(weights[0], 0.0) : 0.0;
  const double after = high ? std::exchange(weights[3], 0.0) : 0.0;
  if (low && high) {
    weights[1] += 2 * before - after;
    weights[2] += 2 * after - before;
    return;
  }
  weights[1] += 3 * before - 3 * after;
  weights[2] += 3 * after - 3 * before;
  weights[low ? 3 : 0] += before + after;
}

template <int kSize>
Interpolated weighted_sum(const std::array<CellWeights, 3>& weights, const double* values) {
  const auto& [x, y, z] = weights;
  Interpolated sum;
  for (int k = 0; k < kSize; ++k) {
    Interpolated plane;
    for (int j = 0; j < kSize; ++j) {
      double value = 0;
      double slope = 0;
      for (int i = 0; i < kSize; ++i, ++values) {
        value += x.value[i] * *values;
        slope += x.slope[i] * *values;
      }
      plane.value += y.value[j] * value;
      plane.gradient.x += y.value[j] * slope;
      plane.gradient.y += y.slope[j] * value;
    }
    sum.value += z.value[k] * plane.value;
    sum.gradient += glm::dvec3(z.value[k] * plane.gradient.x, z.value[k] * plane.gradient.y, z.slope[k] * plane.value);
  }
  return sum;
}

int stencil_size(Interpolation interpolation) { return interpolation == Interpolation::trilinear ? 2 : 4; }

// Calls take(p, slot) for every sample p of the stencil.
template <class F>
void for_each_sample(const glm::ivec3& first, int size, const F& take) {
  int slot = 0;
  for (int k = 0; k < size; ++k) {
    for (int j = 0; j < size; ++j) {
      for (int i = 0; i < size; ++i) take(first + glm::ivec3(i, j, k), slot++);
    }
  }
}

}  // namespace

Interpolant::Interpolant(const ScalarField& field, Interpolation interpolation, double base)
    : field_(field), interpolation_(interpolation), base_(base) {
  if (const auto* sparse = std::get_if<SparseSamples>(&field.samples)) lookup_.emplace(*sparse);
}

std::uint64_t Interpolant::bytes(const ScalarField& field) {
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  return sparse != nullptr ? SparseLookup::bytes(*sparse) : 0;
}

glm::ivec3 Interpolant::cell_of(const glm::dvec3& index) const {
  const auto* dense = std::get_if<DenseSamples>(&field_.samples);
  const glm::dvec3 low = dense != nullptr ? glm::dvec3(0) : glm::dvec3(-kMaxSparseIndex);
  const glm::dvec3 high = dense != nullptr ? glm::dvec3(dense->dims - 2) : glm::dvec3(kMaxSparseIndex);
  // glm::max(low, NaN) is low: no integer stands for NaN.
  return glm::min(high, glm::max(low, glm::floor(index)));
}

bool Interpolant::load(const glm::ivec3& cell, std::span<double> values, SampleRange& range) const {
  const int size = stencil_size(interpolation_);
  const glm::ivec3 first = cell - (size / 2 - 1);
  bool finite = true;
  range = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  const auto put = [&](double stored, int slot) {
    const double value = field_.scale(stored) - base_;
    finite = finite && std::isfinite(value);
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
    values[static_cast<std::size_t>(slot)] = value;
  };
  visit_sample_type(field_.type(), [&]<class T>(std::type_identity<T>) {
    if (const auto* dense = std::get_if<DenseSamples>(&field_.samples)) {
      const glm::i64vec3 dims(dense->dims);
      for_each_sample(first, size, [&](const glm::ivec3& p, int slot) {
        const bool inside =
            glm::all(glm::greaterThanEqual(p, glm::ivec3(0))) && glm::all(glm::lessThan(p, dense->dims));
        const auto* samples = static_cast<const T*>(dense->data);
        if (inside) {
          put(static_cast<double>(samples[p.x + dims.x * (p.y + dims.y * p.z)]), slot);
        } else {
          values[static_cast<std::size_t>(slot)] = 0;
        }
      });
      return;
    }
    const auto& sparse = std::get<SparseSamples>(field_.samples);
    glm::ivec3 origin = block_origin(first);
    std::int32_t block = lookup_->block(origin);
    for_each_sample(first, size, [&](const glm::ivec3& p, int slot) {
      if (const glm::ivec3 own = block_origin(p); own != origin) {
        origin = own;
        block = lookup_->block(origin);
      }
      put(block >= 0 ? static_cast<double>(static_cast<const T*>(sparse.blocks[block].values)[block_offset(p)])
                     : lookup_->constant(origin),
          slot);
    });
  });
  return finite;
}

void Interpolant::Cursor::move_to(const glm::ivec3& cell) {
  if (loaded_ && cell == cell_) return;
  cell_ = cell;
  loaded_ = true;
  finite_ = interpolant_.load(cell, values_, range_);
}

std::optional<SampleRange> Interpolant::Cursor::range(const glm::ivec3& cell) {
  move_to(cell);
  return finite_ ? std::optional(range_) : std::nullopt;
}

std::optional<double> Interpolant::Cursor::max_second_derivative(const glm::ivec3& cell) {
  if (interpolant_.interpolation_ != Interpolation::trilinear) return std::nullopt;
  move_to(cell);
  if (!finite_) return std::nullopt;
  // Only the mixed derivatives are not 0. Each is linear along the third axis, so its extremes are at the ends.
  const auto mixed = [&](std::size_t a, std::size_t b, std::size_t along) {
    double greatest = 0;
    for (const std::size_t end : {std::size_t{0}, along}) {
      greatest =
          std::max(greatest, std::abs(values_[end] - values_[end + a] - values_[end + b] + values_[end + a + b]));
    }
    return greatest;
  };
  const glm::dvec3 all(mixed(2, 4, 1), mixed(1, 4, 2), mixed(1, 2, 4));
  // The squares of very large or very small values would leave the range of double.
  const double largest = std::max({all.x, all.y, all.z});
  return largest > 0 ? largest * std::sqrt(2 * glm::dot(all / largest, all / largest)) : 0;
}

Interpolated Interpolant::Cursor::operator()(const glm::dvec3& index) {
  const glm::ivec3 cell = interpolant_.cell_of(index);
  return evaluate_in_cell(cell, index - glm::dvec3(cell));
}

Interpolated Interpolant::Cursor::evaluate_in_cell(const glm::ivec3& cell, const glm::dvec3& t) {
  move_to(cell);
  if (!finite_) return {std::numeric_limits<double>::quiet_NaN(), glm::dvec3(0)};
  std::array<CellWeights, 3> weights;
  if (interpolant_.interpolation_ == Interpolation::trilinear) {
    for (int axis = 0; axis < 3; ++axis) weights[axis] = linear_weights(t[axis]);
    return weighted_sum<2>(weights, values_.data());
  }
  const auto* dense = std::get_if<DenseSamples>(&interpolant_.field_.samples);
  for (int axis = 0; axis < 3; ++axis) {
    weights[axis] = catmull_rom_weights(t[axis]);
    if (dense == nullptr) continue;
    const bool low = cell[axis] == 0;
    const bool high = cell[axis] + 2 == dense->dims[axis];
    if (!low && !high) continue;
    fold_outer_weights(weights[axis].value, low, high);
    fold_outer_weights(weights[axis].slope, low, high);
  }
  return weighted_sum<4>(weights, values_.data());
}

}  // namespace isoextract::field
