#include "field/statistics.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "base/parallel.hpp"
#include "field/demo_field.hpp"
#include "field/detail/sample_passes.hpp"
#include "field/detail/value_tally.hpp"

namespace isoextract::field {
namespace {

constexpr std::size_t kBins = 1024;
constexpr std::size_t kLanes = 8;  // independent accumulators, so that the compiler can vectorize the loops

// First pass: range of the values, and counts of NaN and infinities.
struct Range {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  std::uint64_t finite = 0;
  std::uint64_t nan = 0;
  std::uint64_t infinite = 0;

  void add(double value, std::uint64_t times) {
    if (std::isnan(value)) {
      nan += times;
    } else if (std::isinf(value)) {
      infinite += times;
    } else {
      min = std::min(min, value);
      max = std::max(max, value);
      finite += times;
    }
  }
};

Range join_ranges(const Range& a, const Range& b) {
  return {std::min(a.min, b.min), std::max(a.max, b.max), a.finite + b.finite, a.nan + b.nan, a.infinite + b.infinite};
}

// float for the types that it represents exactly, double for the others.
template <class T>
using Work = std::conditional_t<std::is_same_v<T, double> || (std::is_integral_v<T> && sizeof(T) == 4), double, float>;

template <class T>
void add_range_unscaled(Range& range, std::span<const T> values) {
  using W = Work<T>;
  constexpr W kInfinity = std::numeric_limits<W>::infinity();
  std::array<W, kLanes> low;
  std::array<W, kLanes> high;
  std::array<std::uint32_t, kLanes> finite{};
  std::array<std::uint32_t, kLanes> nan{};
  low.fill(kInfinity);
  high.fill(-kInfinity);
  const std::size_t whole = values.size() / kLanes * kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const W value = static_cast<W>(values[i + lane]);
      // Comparisons with NaN are false, so NaN never enters. An infinity becomes the neutral value of both sides.
      const bool is_finite = std::abs(value) < kInfinity;
      const W for_low = is_finite ? value : kInfinity;
      const W for_high = is_finite ? value : -kInfinity;
      low[lane] = for_low < low[lane] ? for_low : low[lane];
      high[lane] = for_high > high[lane] ? for_high : high[lane];
      finite[lane] += is_finite ? 1U : 0U;
      nan[lane] += value != value ? 1U : 0U;
    }
  }
  std::uint64_t others = whole;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    range.min = std::min(range.min, static_cast<double>(low[lane]));
    range.max = std::max(range.max, static_cast<double>(high[lane]));
    range.finite += finite[lane];
    range.nan += nan[lane];
    others -= std::uint64_t{finite[lane]} + nan[lane];
  }
  range.infinite += others;
  for (const T value : values.subspan(whole)) range.add(static_cast<double>(value), 1);
}

template <class T>
Range measure_range(const ScalarField& field, Progress* progress) {
  const ValueScale scale = field.scale;
  Range range = reduce_samples<T>(
      field, Range{},
      [&](Range& partial, std::span<const T> values) {
        if (scale.is_identity()) {
          add_range_unscaled(partial, values);
        } else {
          for (const T value : values) partial.add(scale(static_cast<double>(value)), 1);
        }
      },
      join_ranges, progress);
  for_each_tile(field, [&](double value, std::uint64_t voxels) { range.add(scale(value), voxels); });
  return range;
}

// Second pass: the position of the values within the range. Positions are in [0, 1], so that no sum overflows for any
// range; the mean is computed from them.
class RangeMap {
 public:
  RangeMap(double min, double max)
      : half_(std::isinf(max - min) ? 0.5 : 1), min_(min * half_), width_(max * half_ - min_) {}

  // Returns a position in [0, 1] for a finite value of the range.
  [[nodiscard]] double operator()(double value) const { return width_ > 0 ? (value * half_ - min_) / width_ : 0; }

 private:
  double half_;  // scales down a range whose width exceeds the largest double
  double min_;
  double width_;
};

std::size_t bin_of(double position) {
  return std::min(kBins - 1, static_cast<std::size_t>(position * static_cast<double>(kBins)));
}

struct Histogram {
  std::array<std::uint64_t, kBins> bins{};
  double position_sum = 0;

  void add(double position, std::uint64_t times) {
    bins[bin_of(position)] += times;
    position_sum += position * static_cast<double>(times);
  }
};

void join_histograms(Histogram& into, const Histogram& from) {
  for (std::size_t i = 0; i < kBins; ++i) into.bins[i] += from.bins[i];
  into.position_sum += from.position_sum;
}

template <class T>
Histogram measure_histogram(const ScalarField& field, const Range& range, Progress* progress) {
  const ValueScale scale = field.scale;
  const RangeMap position_of(range.min, range.max);
  Histogram histogram = reduce_samples<T>(
      field, Histogram{},
      [&](Histogram& partial, std::span<const T> values) {
        double sum = 0;
        for (const T stored : values) {
          const double value = scale(static_cast<double>(stored));
          if (!std::isfinite(value)) continue;
          const double position = position_of(value);
          ++partial.bins[bin_of(position)];
          sum += position;
        }
        partial.position_sum += sum;
      },
      [](Histogram a, const Histogram& b) {
        join_histograms(a, b);
        return a;
      },
      progress);
  for_each_tile(field, [&](double stored, std::uint64_t voxels) {
    const double value = scale(stored);
    if (!std::isfinite(value)) return;
    histogram.add(position_of(value), voxels);
  });
  return histogram;
}

// The widest range of 32-bit integers whose values are counted one by one, like those of 16 bits.
constexpr double kCountedWidth = 0x1p16;

// Counts each value of integers with a narrow range.
template <class T>
std::vector<CountedValue> count_values(const ScalarField& field, const Range& range, Progress* progress) {
  const auto size = static_cast<std::size_t>(range.max - range.min) + 1;
  const auto place = [&](double value) { return static_cast<std::size_t>(value - range.min); };
  std::vector<std::uint64_t> counts = count_samples<T>(
      field, size,
      [&](std::vector<std::uint64_t>& part, std::span<const T> values) {
        for (const T value : values) ++part[place(static_cast<double>(value))];
      },
      progress);
  for_each_tile(field, [&](double value, std::uint64_t voxels) { counts[place(value)] += voxels; });
  std::vector<CountedValue> values;
  for (std::size_t n = 0; n < size; ++n) {
    if (counts[n] > 0) values.emplace_back(range.min + static_cast<double>(n), counts[n]);
  }
  return values;
}

double interpolate(double min, double max, double position) { return min * (1 - position) + max * position; }

void describe(const Range& range, const Histogram& histogram, FieldStatistics& statistics) {
  statistics.min = range.min + 0.0;  // -0 is 0
  statistics.max = range.max + 0.0;
  statistics.mean =
      interpolate(statistics.min, statistics.max, histogram.position_sum / static_cast<double>(range.finite));
  statistics.histogram.assign(histogram.bins.begin(), histogram.bins.end());
}

std::array<Percent, FieldStatistics::kPercents.size()> statistics_percents() {
  std::array<Percent, FieldStatistics::kPercents.size()> percents;
  std::ranges::transform(FieldStatistics::kPercents, percents.begin(),
                         [](int whole) { return Percent(static_cast<std::uint32_t>(whole)); });
  return percents;
}

FieldStatistics statistics_of(std::vector<CountedValue> values, bool are_integers) {
  FieldStatistics statistics;
  Range range;
  for (const auto& [value, count] : values) range.add(value, count);
  statistics.samples = range.finite;
  statistics.nan = range.nan;
  statistics.infinite = range.infinite;
  if (range.finite == 0) return statistics;
  keep_finite_sorted(values);
  const RangeMap position_of(range.min, range.max);
  Histogram histogram;
  for (const auto& [value, count] : values) histogram.add(position_of(value), count);
  describe(range, histogram, statistics);
  std::ranges::copy(percentiles_of(values, range.finite, statistics_percents()), statistics.percentiles.begin());
  if (are_integers && values.size() <= FieldStatistics::kMaxListedValues) statistics.values = std::move(values);
  return statistics;
}

// Returns the cut between two bins that maximizes Otsu's criterion, the variance between the classes, as a position in
// (0, 1). If an empty gap makes several cuts equally good, returns the middle of them.
double otsu_position(const std::vector<std::uint64_t>& histogram) {
  double total = 0;
  double total_moment = 0;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    total += static_cast<double>(histogram[i]);
    total_moment += static_cast<double>(histogram[i]) * static_cast<double>(i);
  }
  double below = 0;
  double below_moment = 0;
  double best = -1;
  std::size_t first = 1;
  std::size_t last = 1;
  for (std::size_t cut = 1; cut < histogram.size(); ++cut) {  // classes: bins < cut, bins >= cut
    below += static_cast<double>(histogram[cut - 1]);
    below_moment += static_cast<double>(histogram[cut - 1]) * static_cast<double>(cut - 1);
    if (below == 0 || below == total) continue;
    const double difference = below_moment / below - (total_moment - below_moment) / (total - below);
    const double variance = below * (total - below) * difference * difference;
    if (variance > best) {
      best = variance;
      first = cut;
    }
    if (variance == best) last = cut;
  }
  return 0.5 * static_cast<double>(first + last) / static_cast<double>(histogram.size());
}

// Returns the two cuts between bins that maximize the variance between three classes, as otsu_position() does for two;
// nothing if fewer than three bins from `start` on have samples.
std::optional<std::pair<double, double>> multi_otsu_positions(const std::vector<std::uint64_t>& histogram,
                                                              std::size_t start) {
  const std::size_t bins = histogram.size();
  std::vector<double> counts(bins + 1);  // [i]: of the bins start to i - 1
  std::vector<double> moments(bins + 1);
  for (std::size_t i = start; i < bins; ++i) {
    counts[i + 1] = counts[i] + static_cast<double>(histogram[i]);
    moments[i + 1] = moments[i] + static_cast<double>(histogram[i]) * static_cast<double>(i);
  }
  // The cuts with the largest sum of spread() over the classes have the largest variance between the classes.
  const auto spread = [&](std::size_t from, std::size_t to) {
    const double count = counts[to] - counts[from];
    const double moment = moments[to] - moments[from];
    return count > 0 ? moment * moment / count : -1;
  };
  double best = -1;
  std::pair<std::size_t, std::size_t> first;
  std::pair<std::size_t, std::size_t> last;
  for (std::size_t low = start + 1; low + 1 < bins; ++low) {  // classes: bins < low, bins < high, bins >= high
    const double below = spread(start, low);
    if (below < 0) continue;
    for (std::size_t high = low + 1; high < bins; ++high) {
      const double middle = spread(low, high);
      const double above = spread(high, bins);
      if (middle < 0 || above < 0) continue;
      const double sum = below + middle + above;
      if (sum > best) first = {low, high};
      if (sum >= best) last = {low, high};
      best = std::max(best, sum);
    }
  }
  if (best < 0) return std::nullopt;
  const auto position = [&](std::size_t a, std::size_t b) {
    return 0.5 * static_cast<double>(a + b) / static_cast<double>(bins);
  };
  return std::pair{position(first.first, last.first), position(first.second, last.second)};
}

// Rounds `value` to the digits that the width of a histogram bin justifies.
double rounded_to_bin(double value, double bin_width) {
  if (!std::isfinite(bin_width) || bin_width < std::numeric_limits<double>::min()) return value;
  const double exponent = std::floor(std::log10(bin_width));
  // A power of ten below one is not a double; its reciprocal is.
  const double rounded = exponent < 0 ? std::round(value * std::pow(10.0, -exponent)) / std::pow(10.0, -exponent)
                                      : std::round(value / std::pow(10.0, exponent)) * std::pow(10.0, exponent);
  return std::isfinite(rounded) ? rounded : value;
}

template <class T>
FieldStatistics statistics_of_samples(const ScalarField& field, Progress* progress, WithPercentiles percentiles) {
  if constexpr (kIsCountable<T>) {
    return statistics_of(Tally<T>(field, progress).values(field.scale), std::is_integral_v<T>);
  } else {
    FieldStatistics statistics;
    const Range range = measure_range<T>(field, progress);
    if constexpr (std::is_integral_v<T>) {
      const bool is_narrow = range.finite > 0 && range.max - range.min < kCountedWidth;
      if (is_narrow && field.scale.is_identity()) {
        return statistics_of(count_values<T>(field, range, progress), true);
      }
    }
    statistics.samples = range.finite;
    statistics.nan = range.nan;
    statistics.infinite = range.infinite;
    if (range.finite == 0) return statistics;
    const Histogram histogram = measure_histogram<T>(field, range, progress);
    describe(range, histogram, statistics);
    if (percentiles == WithPercentiles::yes) {
      std::ranges::copy(percentiles_of(field, statistics.samples, statistics_percents(), progress),
                        statistics.percentiles.begin());
    }
    return statistics;
  }
}

// Returns whether a sparse level set has samples that are far inside.
template <class T>
bool has_far_inside(const ScalarField& field) {
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  if (sparse == nullptr) return false;
  const FarValues far(field, *sparse);
  if (far.inside == far.background) return false;
  if (std::ranges::find(sparse->tiles, far.inside, &SparseTile::value) != sparse->tiles.end()) return true;
  std::atomic<bool> found{false};
  for_each_index(sparse->blocks.size(), [&](std::size_t b) {
    if (found) return;
    const std::span values(static_cast<const T*>(sparse->blocks[b].values), kBlockSamples);
    if (std::ranges::any_of(values, [&](T value) { return static_cast<double>(value) == far.inside; })) found = true;
  });
  return found;
}

// Returns the range of `statistics`, extended by the far values of a sparse field, which `statistics` leaves out.
Range whole_range(const ScalarField& field, const FieldStatistics& statistics) {
  Range range;
  if (statistics.samples > 0) {
    range.add(statistics.min, 1);
    range.add(statistics.max, 1);
  }
  if (const auto* sparse = std::get_if<SparseSamples>(&field.samples)) {
    const FarValues far(field, *sparse);
    range.add(field.scale(far.background), 1);
    if (statistics.far_inside) range.add(field.scale(far.inside), 1);
  }
  return range;
}

}  // namespace

FieldStatistics measure_statistics(const ScalarField& field, Progress* progress, WithPercentiles percentiles) {
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    FieldStatistics statistics = statistics_of_samples<T>(field, progress, percentiles);
    statistics.far_inside = has_far_inside<T>(field);
    return statistics;
  });
}

std::optional<DefaultIso> default_iso(const ScalarField& field) {
  if (field.kind == FieldKind::level_set) return DefaultIso{0, "the zero of the level set"};
  for (const DemoDescription& demo : demo_fields()) {
    if (field.source.starts_with(kDemoPrefix) && field.name == demo.name) {
      return DefaultIso{demo.iso, "the iso value of the demo field"};
    }
  }
  return std::nullopt;
}

std::optional<SurfaceRange> surface_range(const ScalarField& field, const FieldStatistics& statistics) {
  const Range range = whole_range(field, statistics);
  if (range.finite == 0) return std::nullopt;
  return SurfaceRange{range.min, range.max, field.kind};
}

IsoSuggestion suggest_iso(const ScalarField& field, const FieldStatistics& statistics) {
  const Range range = whole_range(field, statistics);
  const auto passed = surface_range(field, statistics);
  const auto suggestion = [&](double iso, std::string method) {
    return IsoSuggestion{iso, std::move(method), passed && passed->has_surface(iso)};
  };
  if (const auto known = default_iso(field)) return suggestion(known->iso, known->method);
  if (statistics.samples == 0 && range.finite > 0 && statistics.nan + statistics.infinite == 0) {
    return suggestion(range.min, "the only value of a constant field");
  }
  if (statistics.samples == 0) return suggestion(0, "no finite sample to go by");
  if (statistics.min == statistics.max && range.min < range.max) {
    return suggestion(interpolate(range.min, range.max, 0.5), "halfway between the only value and the background");
  }
  if (statistics.min == statistics.max) return suggestion(statistics.min, "the only value of a constant field");
  const double iso = interpolate(statistics.min, statistics.max, otsu_position(statistics.histogram));
  const double bin_width = (statistics.max / kBins - statistics.min / kBins);
  return suggestion(rounded_to_bin(iso, bin_width), "Otsu's threshold (1979) of the histogram");
}

std::optional<CtIsos> suggest_ct_isos(const ScalarField& field, const FieldStatistics& statistics) {
  constexpr double kLowestAir = -1100;
  constexpr double kHighestAir = -900;
  constexpr std::uint64_t kAirShare = 100;
  const bool is_16_bits = field.type() == SampleType::i16 || field.type() == SampleType::u16;
  if (!is_16_bits || field.kind != FieldKind::density || default_iso(field)) return std::nullopt;
  if (statistics.samples == 0 || statistics.min > kHighestAir || statistics.max <= 1000) return std::nullopt;
  const double bin_width = (statistics.max - statistics.min) / kBins;
  const auto bin_at = [&](double value) {
    return static_cast<std::size_t>(std::clamp((value - statistics.min) / bin_width, 0.0, kBins - 1.0));
  };
  const auto from = statistics.histogram.begin() + static_cast<std::ptrdiff_t>(bin_at(-1200));
  const auto to = statistics.histogram.begin() + static_cast<std::ptrdiff_t>(bin_at(-500));
  const auto air = std::max_element(from, to);
  const double value = statistics.min + bin_width * (0.5 + static_cast<double>(air - statistics.histogram.begin()));
  if (value < kLowestAir || value > kHighestAir || *air * kAirShare < statistics.samples) return std::nullopt;
  const auto cuts = multi_otsu_positions(statistics.histogram, bin_at(kLowestAir));
  if (!cuts) return std::nullopt;
  const auto iso_at = [&](double position) {
    return rounded_to_bin(interpolate(statistics.min, statistics.max, position), bin_width);
  };
  return CtIsos{iso_at(cuts->first), iso_at(cuts->second)};
}

}  // namespace isoextract::field
