#include "field/point_samples.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/parallel.hpp"

namespace isoextract::field {
namespace {

// A rounding error may move a vertex on the data boundary slightly outside.
constexpr double kTolerance = 1e-3;  // voxels

// A sample of weight 0 must not contribute, because it may not be a number.
double value_between(double a, double b, double t) { return t == 0 ? a : t == 1 ? b : (1 - t) * a + t * b; }

// Interpolates stored values at index positions.
template <class T>
class StoredValues {
 public:
  // `lookup` is that of sparse samples; null for dense ones.
  StoredValues(const Samples& samples, const SparseLookup* lookup)
      : dense_(std::get_if<DenseSamples>(&samples)), sparse_(std::get_if<SparseSamples>(&samples)), lookup_(lookup) {}

  // Clamps a position without NaN to the range of the samples.
  [[nodiscard]] glm::dvec3 nearest(const glm::dvec3& index) const {
    const glm::dvec3 low = dense_ != nullptr ? glm::dvec3(0) : glm::dvec3(-kMaxSparseIndex);
    const glm::dvec3 high = dense_ != nullptr ? glm::dvec3(dense_->dims - 1) : glm::dvec3(kMaxSparseIndex - 1);
    return glm::clamp(index, low, high);
  }

  // Returns the trilinear interpolant at a position within the range of the samples.
  [[nodiscard]] double operator()(const glm::dvec3& index) const {
    const glm::ivec3 cell(glm::floor(index));
    const glm::dvec3 t = index - glm::dvec3(cell);
    const glm::ivec3 next = cell + glm::ivec3(glm::greaterThan(t, glm::dvec3(0)));
    std::array<double, 4> along_x{};
    for (int edge = 0; edge < 4; ++edge) {
      const int y = (edge & 1) != 0 ? next.y : cell.y;
      const int z = (edge & 2) != 0 ? next.z : cell.z;
      along_x[static_cast<std::size_t>(edge)] = value_between(at({cell.x, y, z}), at({next.x, y, z}), t.x);
    }
    return value_between(value_between(along_x[0], along_x[1], t.y), value_between(along_x[2], along_x[3], t.y), t.z);
  }

 private:
  [[nodiscard]] double at(const glm::ivec3& p) const {
    if (dense_ != nullptr) {
      const glm::i64vec3 dims(dense_->dims);
      return static_cast<double>(static_cast<const T*>(dense_->data)[p.x + dims.x * (p.y + dims.y * p.z)]);
    }
    const glm::ivec3 origin = block_origin(p);
    const std::int32_t block = lookup_->block(origin);
    if (block < 0) return lookup_->constant(origin);
    return static_cast<double>(
        static_cast<const T*>(sparse_->blocks[static_cast<std::size_t>(block)].values)[block_offset(p)]);
  }

  const DenseSamples* dense_;
  const SparseSamples* sparse_;
  const SparseLookup* lookup_;
};

}  // namespace

Result<PointSampler> PointSampler::make(const ScalarField& field, const Context& context) {
  PointSampler sampler(field);
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  if (sparse == nullptr) return sampler;
  const std::vector<glm::ivec3> nodes = SparseLookup::node_origins(*sparse);
  // The table of the nodes' origins is small beside the nodes.
  sampler.memory_ =
      TRY(context.reserve(nodes.size() * sizeof(SparseLookup::Node), field.source + ": the index of blocks"));
  sampler.lookup_.emplace(*sparse, nodes);
  return sampler;
}

Result<PointCounts> PointSampler::sample(std::span<const glm::dvec3> places, std::span<float> values,
                                         std::size_t stride, const Context& context) const {
  const ScalarField& field = *field_;
  const bool dense = std::holds_alternative<DenseSamples>(field.samples);
  std::atomic<std::uint64_t> outside{0};
  std::atomic<std::uint64_t> not_finite{0};
  context.progress().begin("sampling attributes", places.size());
  visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    const StoredValues<T> stored(field.samples, lookup_ ? &*lookup_ : nullptr);
    for_each_range(places.size(), 2048, [&](std::size_t begin, std::size_t end) {
      if (context.cancelled()) return;
      std::uint64_t beyond = 0;
      std::uint64_t no_numbers = 0;
      for (std::size_t i = begin; i != end; ++i) {
        const glm::dvec3 index = index_of_world_(places[i]);
        if (glm::any(glm::isnan(index))) {
          ++no_numbers;
          values[stride * i] = std::numeric_limits<float>::quiet_NaN();
          continue;
        }
        const glm::dvec3 nearest = stored.nearest(index);
        if (dense && glm::any(glm::greaterThan(glm::abs(index - nearest), glm::dvec3(kTolerance)))) ++beyond;
        const auto value = static_cast<float>(field.scale(stored(nearest)));
        if (!std::isfinite(value)) ++no_numbers;
        values[stride * i] = value;
      }
      outside.fetch_add(beyond, std::memory_order_relaxed);
      not_finite.fetch_add(no_numbers, std::memory_order_relaxed);
      context.progress().advance(end - begin);
    });
  });
  TRY(context.check());
  return PointCounts{outside.load(), not_finite.load()};
}

Result<PointCounts> sample_points(const ScalarField& field, std::span<const glm::dvec3> places, std::span<float> values,
                                  std::size_t stride, const Context& context) {
  const auto sampler = TRY(PointSampler::make(field, context));
  return sampler.sample(places, values, stride, context);
}

}  // namespace isoextract::field
