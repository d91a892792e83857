// Filters axis by axis, because a Gaussian is the product of one Gaussian per axis. The weighted mean of the known
// samples is normalized convolution (H. Knutsson and C.-F. Westin, Normalized and differential convolution. CVPR 1993).
// It also works axis by axis if each pass hands on how much of each sample was known.
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

#include "base/parallel.hpp"
#include "field/detail/blurred_samples.hpp"

namespace isoextract::field {
namespace {

template <class T>
using Blurred =
    std::conditional_t<std::is_same_v<T, double> || std::is_same_v<T, std::uint32_t> || std::is_same_v<T, std::int32_t>,
                       double, float>;

// Returns the weight at the center and the weights on one side.
std::vector<double> gaussian_weights(double sigma) {
  std::vector<double> weights{1};
  for (int i = 1; i <= static_cast<int>(std::ceil(3 * sigma)); ++i)
    weights.push_back(std::exp(-i * i / (2 * sigma * sigma)));
  return weights;
}

// Consecutive rows of the same length, and how much of each number is known; null means all.
struct Rows {
  const double* values;
  const double* known;
  std::size_t length;
};

// Computes the weighted mean of the rows `first` to `last` around the row `middle`. It sums differences to that row, so
// that constants come out exactly.
void average_rows(const std::vector<double>& weights, const Rows& rows, int first, int middle, int last, double* means,
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
  // Differences can overflow where the values themselves do not.
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

// Number of adjacent lines along an axis that are filtered together.
constexpr std::int64_t kLines = 32;

template <class Out>
class DensePasses {
 public:
  DensePasses(Out* values, float* known, const glm::ivec3& dims, const Context& context)
      : values_(values), known_(known), dims_(dims), context_(context) {}

  void pass(int axis, const std::vector<double>& weights) {
    const std::array<std::int64_t, 3> strides{1, dims_.x, dims_.x * dims_.y};
    const std::int64_t step = strides[static_cast<std::size_t>(axis)];
    // Lines lie side by side along a second axis, and groups of them along the third.
    const int beside = axis == 0 ? 1 : 0;
    const int groups = axis == 2 ? 1 : 2;
    const std::int64_t beside_step = strides[static_cast<std::size_t>(beside)];
    const std::int64_t group_step = strides[static_cast<std::size_t>(groups)];
    tbb::enumerable_thread_specific<std::vector<double>> scratch;
    for_each_index(std::int64_t{dims_[groups]}, [&](std::int64_t group) {
      if (context_.cancelled()) return;
      for (std::int64_t line = 0; line < dims_[beside]; line += kLines) {
        const std::int64_t lines = std::min(kLines, dims_[beside] - line);
        filter(group * group_step + line * beside_step, step, beside_step, dims_[axis], lines, weights,
               scratch.local());
      }
      context_.progress().advance(1);
    });
  }

  // Returns the scratch bytes of one thread.
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
      average_rows(weights, {values, known, width}, std::max(0, at - reach), at,
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

template <class T>
Result<Samples> blur_dense(const ScalarField& field, const DenseSamples& data, const glm::dvec3& sigma,
                           const Context& context) {
  using Out = Blurred<T>;
  const auto* from = static_cast<const T*>(data.data);
  auto made = TRY(make_reserved_buffer<Out>(data.count(), context, memory_label(field)));
  const auto scratch =
      TRY(context.reserve(max_threads() * DensePasses<Out>::scratch_bytes(data.dims), memory_label(field)));
  Out* const values = made->values.data();
  std::atomic<bool> all_finite{true};
  for_each_slice(data, 0, context, [&](int, std::size_t first, std::size_t end) {
    bool finite = true;
    for (std::size_t i = first; i < end; ++i) {
      finite = finite && is_known_number(from[i]);
      values[i] = is_known_number(from[i]) ? static_cast<Out>(from[i]) : Out{0};
    }
    if (!finite) all_finite.store(false, std::memory_order_relaxed);
  });
  std::shared_ptr<ReservedBuffer<float>> known;
  if (!all_finite) {
    known = TRY(make_reserved_buffer<float>(data.count(), context, memory_label(field)));
    for_each_slice(data, 0, context, [&](int, std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) known->values[i] = is_known_number(from[i]) ? 1.0F : 0.0F;
    });
  }
  DensePasses<Out> passes(values, known ? known->values.data() : nullptr, data.dims, context);
  for (int axis = 0; axis < 3; ++axis) {
    if (sigma[axis] > 0) passes.pass(axis, gaussian_weights(sigma[axis]));
    TRY(context.check());
  }
  if (known) {
    for_each_slice(data, 0, context, [&](int, std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) {
        if (!is_known_number(from[i])) values[i] = static_cast<Out>(from[i]);
      }
    });
  }
  DenseSamples blurred;
  blurred.type = sample_type_of<Out>();
  blurred.dims = data.dims;
  blurred.data = values;
  blurred.owner = std::move(made);
  return blurred;
}

// Filters a block and its surroundings along x, y and z. Each pass drops the surroundings along its axis.
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
        average_rows(own, rows, i, i + reach, i + 2 * reach, means + to, means_known + to);
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

}  // namespace

Result<ScalarField> blur_gaussian(const ScalarField& field, const glm::dvec3& sigma, const Context& context) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(sigma[axis] >= 0 && sigma[axis] <= kMaxBlurSigma)) {
      return fail(
          ErrorCode::usage,
          fmt::format("{}: Gaussian blur: expected standard deviations of 0 to {} voxels, found {:.6g} x {:.6g} "
                      "x {:.6g}",
                      field.source, kMaxBlurSigma, sigma.x, sigma.y, sigma.z));
    }
  }
  context.progress().begin("blurring", 0);
  auto samples = TRY(visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) -> Result<Samples> {
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
  }));
  ScalarField blurred = without_samples(field);
  blurred.samples = std::move(samples);
  return blurred;
}

}  // namespace isoextract::field
