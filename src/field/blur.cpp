// Axis by axis: a Gaussian is the product of one a direction, and so is normalised convolution, the weighted mean of
// what is known (H. Knutsson and C.-F. Westin, Normalized and differential convolution. CVPR 1993), as long as each
// pass hands on how much was known.
#include "field/blur.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "base/reserved_buffer.hpp"
#include "field/detail/blurred_blocks.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {
namespace {

template <class T>
using Blurred =
    std::conditional_t<std::is_same_v<T, double> || std::is_same_v<T, std::uint32_t> || std::is_same_v<T, std::int32_t>,
                       double, float>;

constexpr int kBlurBlockSide = SparseBlock::kSize;
constexpr std::size_t kBlurBlockSamples = std::size_t{kBlurBlockSide} * kBlurBlockSide * kBlurBlockSide;

// Of a Gaussian: the weight at the middle, and those beside it.
std::vector<double> gaussian_weights(double sigma) {
  std::vector<double> weights{1};
  for (int i = 1; i <= static_cast<int>(std::ceil(3 * sigma)); ++i)
    weights.push_back(std::exp(-i * i / (2 * sigma * sigma)));
  return weights;
}

// Rows of numbers of the same length, one behind the other, and how much is known of each number; null: all.
struct Rows {
  const double* values;
  const double* known;
  std::size_t length;
};

// The weighted mean of the rows from `first` to `last`, around the one at `middle`. The differences to that one are
// summed: what does not vary comes out exactly.
void weigh_rows(const std::vector<double>& weights, const Rows& rows, int first, int middle, int last, double* means,
                double* known) {
  const std::size_t length = rows.length;
  const auto row = [&](const double* of, int i) { return of + static_cast<std::size_t>(i) * length; };
  const auto weight = [&](int i) { return weights[static_cast<std::size_t>(std::abs(i - middle))]; };
  const double* const here = row(rows.values, middle);
  std::fill_n(means, length, 0.0);
  if (rows.known == nullptr) {
    double total = 0;
    for (int i = first; i <= last; ++i) {
      const double w = weight(i);
      const double* const there = row(rows.values, i);
      total += w;
      for (std::size_t l = 0; l < length; ++l) means[l] += w * (there[l] - here[l]);
    }
    for (std::size_t l = 0; l < length; ++l) means[l] = here[l] + means[l] / total;
  } else {
    const double* const known_here = row(rows.known, middle);
    std::fill_n(known, length, 0.0);
    for (int i = first; i <= last; ++i) {
      const double w = weight(i);
      const double* const there = row(rows.values, i);
      const double* const known_there = row(rows.known, i);
      for (std::size_t l = 0; l < length; ++l) {
        const double base = known_here[l] > 0 ? here[l] : 0;
        means[l] += w * known_there[l] * (there[l] - base);
        known[l] += w * known_there[l];
      }
    }
    for (std::size_t l = 0; l < length; ++l) {
      const double base = known_here[l] > 0 ? here[l] : 0;
      means[l] = known[l] > 0 ? base + means[l] / known[l] : 0;
    }
  }
  // Differences may leave the range of double where the numbers themselves do not.
  for (std::size_t l = 0; l < length; ++l) {
    if (std::isfinite(means[l])) continue;
    double total = 0;
    for (int i = first; i <= last; ++i) total += weight(i) * (rows.known != nullptr ? row(rows.known, i)[l] : 1);
    means[l] = 0;
    for (int i = first; i <= last; ++i) {
      means[l] += weight(i) * (rows.known != nullptr ? row(rows.known, i)[l] : 1) / total * row(rows.values, i)[l];
    }
  }
}

// All of a field but its samples.
ScalarField without_samples(const ScalarField& field) {
  ScalarField other;
  other.name = field.name;
  other.source = field.source;
  other.format = field.format;
  other.world_space = field.world_space;
  other.grids = field.grids;
  other.grid = field.grid;
  other.kind = field.kind;
  other.scale = field.scale;
  other.index_to_world = field.index_to_world;
  other.index_to_file = field.index_to_file;
  return other;
}

std::string work_on(const ScalarField& field) { return field.source + ": its blurred samples"; }

std::uint64_t threads_at_most() { return static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency()) + 1; }

// A few lines of samples along an axis at a time, side by side.
constexpr std::int64_t kLines = 32;

template <class Out>
class DensePasses {
 public:
  DensePasses(Out* values, float* known, const glm::ivec3& dims, const Context& context)
      : values_(values), known_(known), dims_(dims), context_(context) {}

  void pass(int axis, const std::vector<double>& weights) {
    const std::array<std::int64_t, 3> strides{1, dims_.x, dims_.x * dims_.y};
    const std::int64_t step = strides[static_cast<std::size_t>(axis)];
    // Lines lie side by side along one other axis, and groups of them along the third.
    const int beside = axis == 0 ? 1 : 0;
    const int groups = axis == 2 ? 1 : 2;
    const std::int64_t beside_step = strides[static_cast<std::size_t>(beside)];
    const std::int64_t group_step = strides[static_cast<std::size_t>(groups)];
    tbb::enumerable_thread_specific<std::vector<double>> scratch;
    tbb::parallel_for(std::int64_t{0}, std::int64_t{dims_[groups]}, [&](std::int64_t group) {
      if (context_.cancelled()) return;
      for (std::int64_t line = 0; line < dims_[beside]; line += kLines) {
        const std::int64_t lines = std::min(kLines, dims_[beside] - line);
        filter(group * group_step + line * beside_step, step, beside_step, dims_[axis], lines, weights,
               scratch.local());
      }
      context_.progress().advance(1);
    });
  }

  // What a thread takes.
  static std::uint64_t scratch_bytes(const glm::ivec3& dims) {
    const auto longest = static_cast<std::uint64_t>(std::max({dims.x, dims.y, dims.z}));
    return 2 * (longest + 1) * kLines * sizeof(double);
  }

 private:
  void filter(std::int64_t first, std::int64_t step, std::int64_t beside, std::int64_t length, std::int64_t lines,
              const std::vector<double>& weights, std::vector<double>& scratch) {
    const auto width = static_cast<std::size_t>(lines);
    const std::size_t size = static_cast<std::size_t>(length) * width;
    scratch.resize(2 * size + 2 * width);
    double* const values = scratch.data();
    double* const known = known_ != nullptr ? values + size : nullptr;
    double* const means = values + 2 * size;
    const auto each = [&](const auto& f) {
      for (std::int64_t i = 0; i < length; ++i) {
        for (std::int64_t l = 0; l < lines; ++l)
          f(static_cast<std::size_t>(i * lines + l), first + i * step + l * beside);
      }
    };
    each([&](std::size_t to, std::int64_t from) { values[to] = static_cast<double>(values_[from]); });
    if (known != nullptr)
      each([&](std::size_t to, std::int64_t from) { known[to] = static_cast<double>(known_[from]); });
    const int reach = static_cast<int>(weights.size()) - 1;
    for (std::int64_t i = 0; i < length; ++i) {
      const auto at = static_cast<int>(i);
      weigh_rows(weights, {values, known, width}, std::max(0, at - reach), at,
                 std::min(static_cast<int>(length) - 1, at + reach), means, means + width);
      for (std::int64_t l = 0; l < lines; ++l) {
        const std::int64_t to = first + i * step + l * beside;
        values_[to] = static_cast<Out>(means[l]);
        if (known != nullptr) known_[to] = static_cast<float>(means[width + static_cast<std::size_t>(l)]);
      }
    }
  }

  Out* values_;
  float* known_;
  glm::i64vec3 dims_;
  const Context& context_;
};

template <class T>
bool is_known_number(T value) {
  if constexpr (is_floating_sample<T>) return std::isfinite(static_cast<double>(value));
  return true;
}

template <class F>
void for_slices(const DenseSamples& samples, const Context& context, const F& f) {
  const std::size_t slice = static_cast<std::size_t>(samples.dims.x) * static_cast<std::size_t>(samples.dims.y);
  tbb::parallel_for(0, samples.dims.z, [&](int k) {
    if (!context.cancelled()) f(k, static_cast<std::size_t>(k) * slice, static_cast<std::size_t>(k + 1) * slice);
  });
}

template <class T>
Result<Samples> blur_dense(const ScalarField& field, const DenseSamples& data, const glm::dvec3& sigma,
                           const Context& context) {
  using Out = Blurred<T>;
  const auto* from = static_cast<const T*>(data.data);
  auto made = make_reserved_buffer<Out>(data.count(), context, work_on(field));
  if (!made) return tl::unexpected(made.error());
  const auto scratch = context.reserve(threads_at_most() * DensePasses<Out>::scratch_bytes(data.dims), work_on(field));
  if (!scratch) return tl::unexpected(scratch.error());
  Out* const values = (*made)->values.data();
  std::atomic<bool> all_finite{true};
  for_slices(data, context, [&](int, std::size_t first, std::size_t end) {
    bool finite = true;
    for (std::size_t i = first; i < end; ++i) {
      finite = finite && is_known_number(from[i]);
      values[i] = is_known_number(from[i]) ? static_cast<Out>(from[i]) : Out{0};
    }
    if (!finite) all_finite.store(false, std::memory_order_relaxed);
  });
  std::shared_ptr<ReservedBuffer<float>> known;
  if (!all_finite) {
    auto mask = make_reserved_buffer<float>(data.count(), context, work_on(field));
    if (!mask) return tl::unexpected(mask.error());
    known = std::move(*mask);
    for_slices(data, context, [&](int, std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) known->values[i] = is_known_number(from[i]) ? 1.0F : 0.0F;
    });
  }
  DensePasses<Out> passes(values, known ? known->values.data() : nullptr, data.dims, context);
  for (int axis = 0; axis < 3; ++axis) {
    if (sigma[axis] > 0) passes.pass(axis, gaussian_weights(sigma[axis]));
    if (auto go_on = context.check(); !go_on) return tl::unexpected(std::move(go_on.error()));
  }
  if (known) {
    for_slices(data, context, [&](int, std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) {
        if (!is_known_number(from[i])) values[i] = static_cast<Out>(from[i]);
      }
    });
  }
  DenseSamples blurred;
  blurred.type = sample_type_of<Out>();
  blurred.dims = data.dims;
  blurred.data = values;
  blurred.owner = std::move(*made);
  return blurred;
}

// A block of a sparse grid with what is around it, z fastest.
template <class T>
class Surroundings {
 public:
  Surroundings(const SparseSamples& samples, const SparseLookup& lookup, const glm::ivec3& reach)
      : samples_(samples), lookup_(lookup), reach_(reach), dims_(kBlurBlockSide + 2 * reach) {}

  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(dims_.x) * static_cast<std::size_t>(dims_.y) * static_cast<std::size_t>(dims_.z);
  }
  [[nodiscard]] const glm::ivec3& dims() const { return dims_; }

  // Of the block at `origin`.
  void gather(const glm::ivec3& origin, double* values) const {
    const glm::ivec3 low = origin - reach_;
    const glm::ivec3 high = low + dims_;  // exclusive
    for (int x = block_origin(low).x; x < high.x; x += kBlurBlockSide) {
      for (int y = block_origin(low).y; y < high.y; y += kBlurBlockSide) {
        for (int z = block_origin(low).z; z < high.z; z += kBlurBlockSide) {
          const glm::ivec3 place(x, y, z);
          take(place, glm::max(place, low), glm::min(place + kBlurBlockSide, high), low, values);
        }
      }
    }
  }

 private:
  void take(const glm::ivec3& place, const glm::ivec3& from, const glm::ivec3& to, const glm::ivec3& low,
            double* values) const {
    const std::int32_t stored = lookup_.place(place);
    const T* block =
        stored >= 0 ? static_cast<const T*>(samples_.blocks[static_cast<std::size_t>(stored)].values) : nullptr;
    const double constant = block != nullptr ? 0 : lookup_.constant_of(stored);
    for (int x = from.x; x < to.x; ++x) {
      for (int y = from.y; y < to.y; ++y) {
        const glm::ivec3 at = glm::ivec3(x, y, from.z) - low;
        double* row =
            values +
            (static_cast<std::size_t>(at.x) * static_cast<std::size_t>(dims_.y) + static_cast<std::size_t>(at.y)) *
                static_cast<std::size_t>(dims_.z) +
            at.z;
        const std::size_t count = static_cast<std::size_t>(to.z - from.z);
        if (block == nullptr) {
          std::fill_n(row, count, constant);
        } else {
          const T* values_of = block + block_offset({x, y, from.z});
          std::transform(values_of, values_of + count, row, [](T value) { return static_cast<double>(value); });
        }
      }
    }
  }

  const SparseSamples& samples_;
  const SparseLookup& lookup_;
  glm::ivec3 reach_;
  glm::ivec3 dims_;
};

// fill(origin, values, scratch) makes the values of a block, with `scratch_size` numbers for itself.
template <class T, class Out, class Fill>
Result<Samples> blur_sparse(const ScalarField& field, const SparseSamples& data, const glm::ivec3& reach,
                            std::size_t scratch_per_sample, const Context& context, const Fill& fill) {
  const std::string what = work_on(field);
  const auto lookup_memory =
      context.reserve(SparseLookup::node_origins(data).size() * sizeof(SparseLookup::Node), what);
  if (!lookup_memory) return tl::unexpected(lookup_memory.error());
  const SparseLookup lookup(data);
  auto places = find_blurred_blocks(data, lookup, std::max({reach.x, reach.y, reach.z}), what, context);
  if (!places) return tl::unexpected(std::move(places.error()));
  const Surroundings<T> around(data, lookup, reach);
  const std::size_t scratch_size = scratch_per_sample * around.size();
  const auto scratch_memory = context.reserve(threads_at_most() * scratch_size * sizeof(double), what);
  if (!scratch_memory) return tl::unexpected(scratch_memory.error());
  const std::size_t count = places->origins.size();
  auto made = make_reserved_buffer<Out>(count * kBlurBlockSamples, context, what);
  if (!made) return tl::unexpected(made.error());
  Out* const values = (*made)->values.data();
  tbb::enumerable_thread_specific<std::vector<double>> scratch([&] { return std::vector<double>(scratch_size); });
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t b) {
    if (context.cancelled()) return;
    std::vector<double>& own = scratch.local();
    around.gather(places->origins[b], own.data());
    fill(around.dims(), own.data(), own.data() + around.size(), values + b * kBlurBlockSamples);
    context.progress().advance(1);
  });
  if (auto go_on = context.check(); !go_on) return tl::unexpected(std::move(go_on.error()));
  SparseSamples blurred;
  blurred.type = sample_type_of<Out>();
  blurred.background = data.background;
  blurred.active_box = data.active_box;
  blurred.active_voxels = data.active_voxels;
  blurred.tiles = std::move(places->tiles);
  blurred.blocks.reserve(count);
  for (std::size_t b = 0; b < count; ++b)
    blurred.blocks.push_back({places->origins[b], values + b * kBlurBlockSamples});
  blurred.owner = std::move(*made);
  return blurred;
}

// Along x, y and z of a block's surroundings; what is beyond the block along an axis is gone after its pass.
template <class Out>
void blur_block(const std::array<std::vector<double>, 3>& weights, glm::ivec3 dims, double* values, double* scratch,
                Out* block) {
  std::size_t size =
      static_cast<std::size_t>(dims.x) * static_cast<std::size_t>(dims.y) * static_cast<std::size_t>(dims.z);
  double* means = scratch;
  double* known = scratch + size;
  double* means_known = scratch + 2 * size;
  std::array<double, kBlurBlockSamples> stays{};
  const glm::ivec3 middle = (dims - kBlurBlockSide) / 2;
  const bool all_known = std::all_of(values, values + size, [](double value) { return std::isfinite(value); });
  if (!all_known) {
    std::size_t v = 0;
    for (int x = 0; x < kBlurBlockSide; ++x) {
      for (int y = 0; y < kBlurBlockSide; ++y) {
        for (int z = 0; z < kBlurBlockSide; ++z) {
          const glm::ivec3 at = glm::ivec3(x, y, z) + middle;
          stays[v++] = values[(static_cast<std::size_t>(at.x) * static_cast<std::size_t>(dims.y) +
                               static_cast<std::size_t>(at.y)) *
                                  static_cast<std::size_t>(dims.z) +
                              static_cast<std::size_t>(at.z)];
        }
      }
    }
    for (std::size_t i = 0; i < size; ++i) {
      known[i] = std::isfinite(values[i]) ? 1 : 0;
      if (known[i] == 0) values[i] = 0;
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& own = weights[static_cast<std::size_t>(axis)];
    const int reach = static_cast<int>(own.size()) - 1;
    std::size_t outer = 1;
    std::size_t inner = 1;
    for (int a = 0; a < axis; ++a) outer *= static_cast<std::size_t>(dims[a]);
    for (int a = axis + 1; a < 3; ++a) inner *= static_cast<std::size_t>(dims[a]);
    const auto length = static_cast<std::size_t>(dims[axis]);
    for (std::size_t o = 0; o < outer; ++o) {
      const Rows rows{values + o * length * inner, all_known ? nullptr : known + o * length * inner, inner};
      for (int i = 0; i < kBlurBlockSide; ++i) {
        const std::size_t to = (o * kBlurBlockSide + static_cast<std::size_t>(i)) * inner;
        weigh_rows(own, rows, i, i + reach, i + 2 * reach, means + to, means_known + to);
      }
    }
    dims[axis] = kBlurBlockSide;
    std::swap(values, means);
    std::swap(known, means_known);
  }
  for (std::size_t v = 0; v < kBlurBlockSamples; ++v) {
    const bool keeps = !all_known && !std::isfinite(stays[v]);
    block[v] = static_cast<Out>(keeps ? stays[v] : values[v]);
  }
}

// The lower median of what is no NaN; there is one.
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
Result<Samples> median_dense(const ScalarField& field, const DenseSamples& data, int width, const Context& context) {
  auto made = make_reserved_buffer<T>(data.count(), context, work_on(field));
  if (!made) return tl::unexpected(made.error());
  T* const values = (*made)->values.data();
  const auto* from = static_cast<const T*>(data.data);
  const glm::i64vec3 dims(data.dims);
  tbb::enumerable_thread_specific<std::vector<T>> windows;
  for_slices(data, context, [&](int k, std::size_t first, std::size_t) {
    std::vector<T>& window = windows.local();
    T* to = values + first;
    for (int j = 0; j < data.dims.y; ++j) {
      for (int i = 0; i < data.dims.x; ++i, ++to) {
        const glm::ivec3 at(i, j, k);
        const glm::ivec3 low = glm::max(at - width, glm::ivec3(0));
        const glm::ivec3 high = glm::min(at + width, data.dims - 1);
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
  if (auto go_on = context.check(); !go_on) return tl::unexpected(std::move(go_on.error()));
  DenseSamples blurred;
  blurred.type = data.type;
  blurred.dims = data.dims;
  blurred.data = values;
  blurred.owner = std::move(*made);
  return blurred;
}

// Of a number that was one.
template <class T>
T sample_of(double value) {
  if constexpr (std::is_same_v<T, Half>)
    return Half(static_cast<float>(value));
  else
    return static_cast<T>(value);
}

template <class T>
void median_block(int width, const glm::ivec3& dims, const double* values, T* block) {
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
        const double here = *value(x + width, y + width, z + width);
        *block = sample_of<T>(here);
        if (std::isnan(here)) continue;
        window.clear();
        for (int i = x; i <= x + 2 * width; ++i) {
          for (int j = y; j <= y + 2 * width; ++j) {
            std::copy_if(value(i, j, z), value(i, j, z + 2 * width + 1), std::back_inserter(window),
                         [](double v) { return !std::isnan(v); });
          }
        }
        *block = sample_of<T>(median_of(window));
      }
    }
  }
}

}  // namespace

Result<ScalarField> blur_gaussian(const ScalarField& field, const glm::dvec3& sigma, const Context& context) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(sigma[axis] >= 0 && sigma[axis] <= kMaxBlurSigma)) {
      return fail(ErrorKind::usage,
                  fmt::format("{}: a Gaussian of {:.6g} x {:.6g} x {:.6g} voxels, at most {} are taken", field.source,
                              sigma.x, sigma.y, sigma.z, kMaxBlurSigma));
    }
  }
  context.progress().begin("blurring", 0);
  auto samples = visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) -> Result<Samples> {
    if (const auto* dense = std::get_if<DenseSamples>(&field.samples))
      return blur_dense<T>(field, *dense, sigma, context);
    std::array<std::vector<double>, 3> weights;
    glm::ivec3 reach(0);
    for (int axis = 0; axis < 3; ++axis) {
      weights[static_cast<std::size_t>(axis)] =
          sigma[axis] > 0 ? gaussian_weights(sigma[axis]) : std::vector<double>{1};
      reach[axis] = static_cast<int>(weights[static_cast<std::size_t>(axis)].size()) - 1;
    }
    return blur_sparse<T, Blurred<T>>(field, std::get<SparseSamples>(field.samples), reach, 4, context,
                                      [&](const glm::ivec3& dims, double* values, double* scratch, auto* block) {
                                        blur_block(weights, dims, values, scratch, block);
                                      });
  });
  if (!samples) return tl::unexpected(samples.error());
  ScalarField blurred = without_samples(field);
  blurred.samples = std::move(*samples);
  return blurred;
}

Result<ScalarField> blur_median(const ScalarField& field, int width, const Context& context) {
  if (width < 1 || width > kMaxMedianWidth) {
    return fail(ErrorKind::usage, fmt::format("{}: a median of {} voxels on either side, from 1 to {} are taken",
                                              field.source, width, kMaxMedianWidth));
  }
  context.progress().begin("blurring", 0);
  auto samples = visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) -> Result<Samples> {
    if (const auto* dense = std::get_if<DenseSamples>(&field.samples)) {
      return median_dense<T>(field, *dense, width, context);
    }
    return blur_sparse<T, T>(field, std::get<SparseSamples>(field.samples), glm::ivec3(width), 1, context,
                             [&](const glm::ivec3& dims, const double* values, double*, T* block) {
                               median_block(width, dims, values, block);
                             });
  });
  if (!samples) return tl::unexpected(samples.error());
  ScalarField blurred = without_samples(field);
  blurred.samples = std::move(*samples);
  return blurred;
}

}  // namespace isoextract::field
