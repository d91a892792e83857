// Does not use Interpolant, which computes gradients, and returns NaN beside every sample that is not finite, even one
// of weight 0. The weighted sum of Interpolant can also leave the range of the samples.
#include "field/resample.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "base/checked.hpp"
#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "field/detail/axis_weights.hpp"
#include "field/detail/majority.hpp"
#include "field/detail/sample_rows.hpp"
#include "field/sample_value.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {
namespace {

// Means of a sparse field read the whole box, with the background between blocks. For more voxels, this takes minutes.
constexpr double kMaxVoxelsForMeans = 0x1p35;

template <class T>
using Resampled =
    std::conditional_t<std::is_same_v<T, double> || std::is_same_v<T, std::uint32_t> || std::is_same_v<T, std::int32_t>,
                       double, float>;

// NaN passes the clamp. Without the clamp, rounding could leave the range of a and b, and the range of double.
double blend(double a, double b, double t) {
  return t == 0 ? a : std::clamp((1 - t) * a + t * b, std::min(a, b), std::max(a, b));
}

// Adds weighted samples, one by one.
class WeightedSum {
 public:
  explicit WeightedSum(const AxisWeights& axis) : convex_(axis.is_convex()), mean_(axis.is_mean()) {}

  void start(double weight, double value) {
    sum_ = weight * value;
    low_ = high_ = value;
  }
  void add(double weight, double value) {
    sum_ += weight * value;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  // `a` and `b` are the samples before and after the position. The clamp keeps rounding from leaving the range of the
  // samples. Beside samples that are not finite a kernel is linear: a negative weight would flip an infinity, and more
  // neighbors would contribute than between finite samples.
  [[nodiscard]] double result(double a, double b, double t) const {
    if (!mean_ && !std::isfinite(sum_)) return blend(a, b, t);
    return convex_ || low_ == high_ ? std::clamp(sum_, low_, high_) : sum_;
  }
  [[nodiscard]] double mean() const { return std::clamp(sum_, low_, high_); }

 private:
  friend class PartialMean;

  double sum_ = 0;
  double low_ = 0;
  double high_ = 0;
  bool convex_;
  bool mean_;
};

// The mean of the samples that are numbers, and their share of the total weight.
struct Part {
  double value = 0;
  double share = 1;
};

// The weighted mean of parts, leaving out the weight of NaN.
class PartialMean {
 public:
  PartialMean() = default;
  // Starts with a sum of numbers whose weights add up to `share`.
  PartialMean(const WeightedSum& sum, double share) : sum_(sum.sum_), low_(sum.low_), high_(sum.high_), share_(share) {}

  void add(double weight, const Part& part) {
    const double share = weight * part.share;
    if (!(share > 0)) return;
    sum_ += share * part.value;
    low_ = share_ > 0 ? std::min(low_, part.value) : part.value;
    high_ = share_ > 0 ? std::max(high_, part.value) : part.value;
    share_ += share;
  }
  [[nodiscard]] Part result() const {
    constexpr double kAll = 1 - 1e-12;  // weights are rounded
    if (share_ == 0) return {std::numeric_limits<double>::quiet_NaN(), 0};
    return {std::clamp(sum_ / share_, low_, high_), share_ > kAll ? 1 : share_};
  }

 private:
  double sum_ = 0;
  double low_ = 0;
  double high_ = 0;
  double share_ = 0;
};

// A row of numbers. `shares` holds the part of each number's weight that belongs to samples that are not NaN; `values`
// are the means of those samples. `shares` is empty if the row has no NaN, or if NaN stays in `values`.
struct Row {
  std::span<const double> values;
  std::span<const double> shares;

  [[nodiscard]] Part at(std::size_t i) const { return {values[i], shares.empty() ? 1 : shares[i]}; }
};

// A row to write to.
struct RowBuffer {
  explicit RowBuffer(std::size_t width) : values(width) {}

  [[nodiscard]] Row row() const {
    return {values, masked ? std::span<const double>(shares) : std::span<const double>()};
  }
  void set_masked(bool is_masked) {
    masked = is_masked;
    if (masked) shares.resize(values.size());
  }

  std::vector<double> values;
  std::vector<double> shares;
  bool masked = false;
};

// Combines old samples along x: part(j) returns old sample j.
template <class PartAt>
Part combine_parts(const AxisWeights& axis, const SampleWeights& use, const PartAt& part) {
  if (use.weights.size() == 1) return part(use.first);
  WeightedSum sum(axis);
  bool whole = true;
  for (std::size_t k = 0; k < use.weights.size(); ++k) {
    const Part one = part(use.first + static_cast<int>(k));
    whole = whole && one.share == 1;
    k == 0 ? sum.start(use.weights[k], one.value) : sum.add(use.weights[k], one.value);
  }
  if (whole && axis.is_mean()) return {sum.mean(), 1};
  PartialMean mean;
  if (axis.is_mean()) {
    for (std::size_t k = 0; k < use.weights.size(); ++k) {
      mean.add(use.weights[k], part(use.first + static_cast<int>(k)));
    }
    return mean.result();
  }
  const Part a = part(use.below);
  const Part b = use.t == 0 ? a : part(use.below + 1);
  if (whole) return {sum.result(a.value, b.value, use.t), 1};
  mean.add(1 - use.t, a);
  mean.add(use.t, b);
  return mean.result();
}

// Scratch memory for combine_rows(), one entry for each sample of a row.
struct RowSums {
  RowSums(const AxisWeights& axis, std::size_t width) : sums(width, WeightedSum(axis)), means(width) {}
  std::vector<WeightedSum> sums;
  std::vector<PartialMean> means;
};

// Averages rows. Adds plain sums up to the first row with NaN, and PartialMean from there on.
template <class GetRow>
void mean_of_rows(const SampleWeights& use, const GetRow& row, RowSums& room, RowBuffer& out) {
  std::vector<WeightedSum>& sums = room.sums;
  std::vector<PartialMean>& means = room.means;
  bool masked = false;
  double before = 0;
  for (std::size_t k = 0; k < use.weights.size(); ++k) {
    const Row one = row(use.first + static_cast<int>(k));
    if (!masked && !one.shares.empty()) {
      masked = true;
      for (std::size_t i = 0; i < means.size(); ++i) {
        means[i] = k == 0 ? PartialMean() : PartialMean(sums[i], before);
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (masked) {
        means[i].add(use.weights[k], one.at(i));
      } else {
        k == 0 ? sums[i].start(use.weights[k], one.values[i]) : sums[i].add(use.weights[k], one.values[i]);
      }
    }
    before += use.weights[k];
  }
  out.set_masked(masked);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const Part part = masked ? means[i].result() : Part{sums[i].mean(), 1};
    out.values[i] = part.value;
    if (masked) out.shares[i] = part.share;
  }
}

// Combines old rows into one. row(j) returns old row j; the last kMaxKernelWeights rows that it returned stay valid.
template <class GetRow>
void combine_rows(const AxisWeights& axis, const SampleWeights& use, const GetRow& row, RowSums& room, RowBuffer& out) {
  if (use.weights.size() > 1 && axis.is_mean()) {
    mean_of_rows(use, row, room, out);
    return;
  }
  std::array<Row, AxisWeights::kMaxKernelWeights> rows;
  bool masked = false;
  for (std::size_t k = 0; k < use.weights.size(); ++k) {
    rows[k] = row(use.first + static_cast<int>(k));
    masked = masked || !rows[k].shares.empty();
  }
  out.set_masked(masked);
  if (masked) {
    for (std::size_t i = 0; i < out.values.size(); ++i) {
      const Part part =
          combine_parts(axis, use, [&](int j) { return rows[static_cast<std::size_t>(j - use.first)].at(i); });
      out.values[i] = part.value;
      out.shares[i] = part.share;
    }
    return;
  }
  if (use.weights.size() == 1) {
    std::ranges::copy(rows[0].values, out.values.begin());
    return;
  }
  const std::span<const double> a = rows[static_cast<std::size_t>(use.below - use.first)].values;
  const std::span<const double> b = use.t == 0 ? a : rows[static_cast<std::size_t>(use.below + 1 - use.first)].values;
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    WeightedSum& sum = room.sums[i];
    sum.start(use.weights[0], rows[0].values[i]);
    for (std::size_t k = 1; k < use.weights.size(); ++k) sum.add(use.weights[k], rows[k].values[i]);
    out.values[i] = sum.result(a[i], b[i], use.t);
  }
}

// Returns a new sample of a row: NaN if NaN samples have more than half of the weight.
double combine_samples(const AxisWeights& axis, const SampleWeights& use, const Row& row) {
  constexpr double kHalf = 0.5 - 1e-9;  // weights are rounded
  const Part part = combine_parts(axis, use, [&](int j) { return row.at(static_cast<std::size_t>(j)); });
  return part.share >= kHalf || std::isnan(part.value) ? part.value : std::numeric_limits<double>::quiet_NaN();
}

// Reads row (y, z). With `leaves_nan_out`, the row gets shares if it has NaN.
template <class T>
void read_row(const SampleRows<T>& source, int y, int z, bool leaves_nan_out, RowBuffer& row) {
  source.read(y, z, row.values.data());
  if constexpr (!is_floating_sample<T>) return;
  row.set_masked(leaves_nan_out && std::ranges::any_of(row.values, [](double value) { return std::isnan(value); }));
  if (!row.masked) return;
  std::ranges::transform(row.values, row.shares.begin(), [](double value) { return std::isnan(value) ? 0.0 : 1.0; });
}

// Keeps the rows that were requested last, by number. Consecutive rows do not displace each other.
class RowCache {
 public:
  explicit RowCache(std::size_t width) : rows_(AxisWeights::kMaxKernelWeights, {-1, RowBuffer(width)}) {}

  // Returns the row, and calls make(buffer) to fill it if it is not cached.
  template <class Make>
  Row get(int number, const Make& make) {
    auto& [held, buffer] = rows_[static_cast<std::size_t>(number) % rows_.size()];
    if (held != number) {
      held = number;
      make(buffer);
    }
    return buffer.row();
  }
  void forget() {
    for (auto& [held, buffer] : rows_) held = -1;
  }

 private:
  std::vector<std::pair<int, RowBuffer>> rows_;
};

using Weights = std::array<AxisWeights, 3>;  // along x, y and z

template <class T, class Value>
void fill(const SampleRows<T>& source, bool leaves_nan_out, const glm::ivec3& old_dims, const glm::ivec3& dims,
          const Weights& weights, Value* values, const Context& context) {
  constexpr int kRows = 64;  // of a new plane, per task
  const AxisWeights& along_x = weights[0];
  const AxisWeights& along_y = weights[1];
  const AxisWeights& along_z = weights[2];
  const std::int64_t bands = (std::int64_t{dims.y} + kRows - 1) / kRows;
  context.progress().begin("resampling", static_cast<std::uint64_t>(bands * dims.z));
  for_each_index(bands * dims.z, [&](std::int64_t part) {
    if (context.cancelled()) return;
    const auto k = static_cast<int>(part / bands);
    const int first = static_cast<int>(part % bands) * kRows;
    const int end = first + std::min(kRows, dims.y - first);
    const auto width = static_cast<std::size_t>(old_dims.x);
    const SampleWeights z = along_z.of(k);
    RowCache read(width);
    RowCache plane(width);  // old rows combined along z
    RowSums z_sums(along_z, width);
    RowSums y_sums(along_y, width);
    const auto plane_row = [&](int y) {
      return plane.get(y, [&](RowBuffer& out) {
        read.forget();
        combine_rows(
            along_z, z,
            [&](int at) { return read.get(at, [&](RowBuffer& row) { read_row(source, y, at, leaves_nan_out, row); }); },
            z_sums, out);
      });
    };
    RowBuffer row(width);
    Value* out = values + static_cast<std::int64_t>(dims.x) * (first + static_cast<std::int64_t>(dims.y) * k);
    for (int j = first; j < end; ++j) {
      combine_rows(along_y, along_y.of(j), plane_row, y_sums, row);
      for (int i = 0; i < dims.x; ++i) {
        *out++ = to_sample<Value>(combine_samples(along_x, along_x.of(i), row.row()));
      }
    }
    source.leave(along_y.of(first).first, along_y.of(end - 1).end(), z.first, z.end());
    context.progress().advance(1);
  });
}

// Returns the box outside of which, and on whose faces, everything is background.
template <class T>
IndexBox box_in_background(const SparseSamples& sparse) {
  IndexBox box = sparse.active_box;
  const auto add = [&](const glm::ivec3& low, const glm::ivec3& high) {
    box = box.empty() ? IndexBox{low, high} : IndexBox{glm::min(box.min, low), glm::max(box.max, high)};
  };
  for (const SparseBlock& block : sparse.blocks) {
    const glm::ivec3 last = block.origin + (SparseBlock::kSize - 1);
    if (glm::min(box.min, block.origin) == box.min && glm::max(box.max, last) == box.max) continue;
    for (int v = 0; v < SparseBlock::kSize * SparseBlock::kSize * SparseBlock::kSize; ++v) {
      if (static_cast<double>(static_cast<const T*>(block.values)[v]) == sparse.background) continue;
      const glm::ivec3 p = block.origin + glm::ivec3(v >> 6, v >> 3 & 7, v & 7);
      add(p, p);
    }
  }
  for (const SparseTile& tile : sparse.tiles) add(tile.origin, tile.origin + (tile.size - 1));
  if (box.empty()) box = {glm::ivec3(0), glm::ivec3(0)};
  return {box.min - 1, box.max + 1};
}

std::string dims_text(const glm::i64vec3& dims) { return fmt::format("{} x {} x {}", dims.x, dims.y, dims.z); }

// Reserves the memory of the weights, unless it is at most 1 MiB, which is negligible.
Result<Reservation> reserve_weights(const ScalarField& field, const glm::ivec3& old_dims, const glm::ivec3& dims,
                                    const Context& context) {
  constexpr std::uint64_t kSmall = std::uint64_t{1} << 20;
  std::uint64_t bytes = 0;
  for (int axis = 0; axis < 3; ++axis) bytes += AxisWeights::bytes(old_dims[axis], dims[axis]);
  if (bytes <= kSmall) return Reservation();
  return context.reserve(bytes, fmt::format("{}: weights of samples", field.source));
}

// Fails if a dense field has fewer than two samples along an axis; sparse fields have background around them. `what`
// names the operation in the message.
Result<void> check_has_steps(const ScalarField& field, std::string_view what) {
  const auto* dense = std::get_if<DenseSamples>(&field.samples);
  if (dense == nullptr || glm::all(glm::greaterThanEqual(dense->dims, glm::ivec3(2)))) return {};
  return fail(ErrorCode::input, fmt::format("{}: {} needs at least 2 samples along each axis, found {}", field.source,
                                            what, dims_text(dense->dims)));
}

template <class T, class Value>
Result<ScalarField> resampled(const ScalarField& field, const glm::ivec3& resolution, ResampleKernel kernel,
                              NanHandling nan, const Context& context) {
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  const IndexBox box = resampled_box(field);
  const glm::ivec3 old_dims(box.dims());
  ScalarField result = field;
  result.notes.clear();
  const bool same = sparse == nullptr && old_dims == resolution;
  if (same && kernel != ResampleKernel::bspline) return result;

  const glm::u64vec3 counts(resolution);
  const std::uint64_t count = checked_product(counts.x, counts.y, counts.z).value_or(~std::uint64_t{0});
  const std::string size =
      fmt::format("{} samples of {}", dims_text(resolution), sample_type_name(sample_type_of<Value>()));
  auto values = TRY(make_reserved_buffer<Value>(count, context, fmt::format("{}: {}", field.source, size)));
  if (sparse != nullptr) {
    result.notes.push_back(
        {NoteId::sparse_made_dense,
         fmt::format("{}: its sparse samples become {} ({}), which cover the voxels ({}, {}, {}) .. ({}, {}, {})",
                     field.source, size, format_byte_size(count * sizeof(Value)), box.min.x, box.min.y, box.min.z,
                     box.max.x, box.max.y, box.max.z)});
  }
  DenseSamples samples;
  samples.type = sample_type_of<Value>();
  samples.dims = resolution;
  const glm::dvec3 extent(old_dims);
  const bool means = sparse == nullptr || extent.x * extent.y * extent.z <= kMaxVoxelsForMeans;
  if (!means && kernel != ResampleKernel::nearest && glm::any(glm::lessThan(resolution, old_dims))) {
    result.notes.push_back(
        {NoteId::means_not_possible, fmt::format("{}: {} voxels are too many to average; new samples can miss details",
                                                 field.source, dims_text(old_dims))});
  }
  auto weight_memory = TRY(reserve_weights(field, old_dims, resolution, context));
  const auto lookup_memory = TRY(
      context.reserve(sparse != nullptr ? SparseLookup::bytes(*sparse) : 0, field.source + ": the index of blocks"));
  const SampleRows<T> source(field.samples, box);
  if (kernel == ResampleKernel::majority && means) {
    fill_majority([&](int y, int z, double* row) { source.read(y, z, row); },
                  [&](int first, int end) { source.leave(0, old_dims.y, first, end); }, old_dims, resolution,
                  nan == NanHandling::spread, values->values.data(), context);
  } else {
    const auto along = [&](int axis) { return AxisWeights(old_dims[axis], resolution[axis], kernel, means); };
    const Weights weights{along(0), along(1), along(2)};
    fill(source, nan == NanHandling::left_out, old_dims, resolution, weights, values->values.data(), context);
  }
  TRY(context.check());
  samples.data = values->values.data();
  samples.owner = std::move(values);

  Affine old_from_new = scaling(glm::dvec3(old_dims - 1) / glm::dvec3(resolution - 1));
  old_from_new.offset = box.min;
  result.index_to_world = field.index_to_world.after(old_from_new);
  result.index_to_file = field.index_to_file.after(old_from_new);
  result.samples = std::move(samples);
  return result;
}

}  // namespace

IndexBox resampled_box(const ScalarField& field) {
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  if (sparse == nullptr) return field.extents();
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) { return box_in_background<T>(*sparse); });
}

Result<ScalarField> resample(const ScalarField& field, const glm::ivec3& resolution, ResampleKernel kernel,
                             NanHandling nan, const Context& context) {
  if (glm::any(glm::lessThan(resolution, glm::ivec3(2)))) {
    return fail(ErrorCode::usage,
                fmt::format("a resolution needs at least 2 samples along each axis, found {}", dims_text(resolution)));
  }
  TRY(check_has_steps(field, "resampling to another resolution"));
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    return takes_old_samples(kernel) ? resampled<T, T>(field, resolution, kernel, nan, context)
                                     : resampled<T, Resampled<T>>(field, resolution, kernel, nan, context);
  });
}

Result<glm::ivec3> resolution_of_voxel_size(const ScalarField& field, const glm::dvec3& voxel_size) {
  TRY(check_has_steps(field, "resampling to another voxel size"));
  const glm::i64vec3 dims = resampled_box(field).dims();
  glm::ivec3 resolution(0);
  for (int axis = 0; axis < 3; ++axis) {
    const double length = static_cast<double>(dims[axis] - 1) * glm::length(field.index_to_world.linear[axis]);
    const double steps = std::round(length / voxel_size[axis]);
    constexpr int kMostSteps = std::numeric_limits<int>::max() - 1;
    if (!(voxel_size[axis] > 0 && steps >= 1 && steps <= kMostSteps)) {
      return fail(
          ErrorCode::usage,
          fmt::format("{}: expected a voxel size along {} from {:.6g} (at most {} voxels) to {:.6g} (twice the "
                      "extent of the samples), found {}",
                      field.source, "xyz"[axis], length / kMostSteps, kMostSteps, 2 * length, voxel_size[axis]));
    }
    resolution[axis] = static_cast<int>(steps) + 1;
  }
  return resolution;
}

}  // namespace isoextract::field
