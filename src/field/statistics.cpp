#include "field/statistics.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "field/demo_field.hpp"
#include "field/detail/sample_passes.hpp"

namespace isoextract::field {
namespace {

constexpr std::size_t kBins = 1024;
constexpr std::size_t kLanes = 8;  // independent accumulators, so that the loops vectorise

// First pass: range and counts of what is not finite.
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

// float for everything a float holds exactly, double for the rest.
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
      // Comparisons with NaN are false, so NaN never enters; an infinity enters only the side that ignores it.
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
      field.samples, Range{},
      [&](Range& partial, std::span<const T> values) {
        if (scale.is_identity()) {
          add_range_unscaled(partial, values);
        } else {
          for (const T value : values) partial.add(scale(static_cast<double>(value)), 1);
        }
      },
      join_ranges, progress);
  for_each_tile(field.samples, [&](double value, std::uint64_t voxels) { range.add(scale(value), voxels); });
  return range;
}

// Second pass: where in the range the values lie. Positions are in [0, 1], so nothing overflows however wide the
// range is, and the mean is taken of them.
class RangeMap {
 public:
  RangeMap(double min, double max)
      : half_(std::isinf(max - min) ? 0.5 : 1), min_(min * half_), width_(max * half_ - min_) {}

  // In [0, 1] for finite values of the range.
  [[nodiscard]] double operator()(double value) const { return width_ > 0 ? (value * half_ - min_) / width_ : 0; }

 private:
  double half_;  // scales a range whose width exceeds the largest double
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
      field.samples, Histogram{},
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
  for_each_tile(field.samples, [&](double stored, std::uint64_t voxels) {
    const double value = scale(stored);
    if (!std::isfinite(value)) return;
    histogram.add(position_of(value), voxels);
  });
  return histogram;
}

double interpolate(double min, double max, double position) { return min * (1 - position) + max * position; }

void describe(const Range& range, const Histogram& histogram, FieldStatistics& statistics) {
  statistics.min = range.min;
  statistics.max = range.max;
  statistics.mean = interpolate(range.min, range.max, histogram.position_sum / static_cast<double>(range.finite));
  statistics.histogram.assign(histogram.bins.begin(), histogram.bins.end());
}

// How many samples come before the one that a percentile is.
std::uint64_t rank_of(int percent, std::uint64_t samples) {
  const std::uint64_t hundredths = samples % 100 * static_cast<std::uint64_t>(percent);
  return samples / 100 * static_cast<std::uint64_t>(percent) + (hundredths + 99) / 100 - 1;
}

// Types whose numbers are few enough to count how often each occurs.
template <class T>
inline constexpr bool kCountable = sizeof(T) <= 2;

// How often each number of a small type occurs.
template <class T>
class Tally {
 public:
  Tally(const Samples& samples, Progress* progress) {
    counts_ = count_samples<T>(
        samples, kNumbers,
        [](std::vector<std::uint64_t>& counts, std::span<const T> values) {
          for (const T value : values) ++counts[std::bit_cast<Bits>(value)];
        },
        progress);
    for_each_tile(samples, [&](double value, std::uint64_t voxels) {
      counts_[std::bit_cast<Bits>(static_cast<T>(static_cast<WorkOf>(value)))] += voxels;
    });
  }

  // Each value that occurs, scaled, and how often.
  [[nodiscard]] std::vector<std::pair<double, std::uint64_t>> values(const ValueScale& scale) const {
    std::vector<std::pair<double, std::uint64_t>> values;
    for (std::size_t bits = 0; bits < kNumbers; ++bits) {
      if (counts_[bits] == 0) continue;
      const auto stored = static_cast<double>(std::bit_cast<T>(static_cast<Bits>(bits)));
      values.emplace_back(scale(stored), counts_[bits]);
    }
    return values;
  }

 private:
  using Bits = std::conditional_t<sizeof(T) == 1, std::uint8_t, std::uint16_t>;
  using WorkOf = std::conditional_t<std::is_integral_v<T>, T, float>;
  static constexpr std::size_t kNumbers = std::size_t{1} << (8 * sizeof(T));
  std::vector<std::uint64_t> counts_;
};

FieldStatistics statistics_of(std::vector<std::pair<double, std::uint64_t>> values) {
  FieldStatistics statistics;
  Range range;
  for (const auto& [value, count] : values) range.add(value, count);
  statistics.samples = range.finite;
  statistics.nan = range.nan;
  statistics.infinite = range.infinite;
  if (range.finite == 0) return statistics;
  std::erase_if(values, [](const auto& value) { return !std::isfinite(value.first); });
  std::ranges::sort(values);
  const RangeMap position_of(range.min, range.max);
  Histogram histogram;
  for (const auto& [value, count] : values) histogram.add(position_of(value), count);
  describe(range, histogram, statistics);
  auto value = values.begin();
  std::uint64_t upto = value->second;
  for (std::size_t p = 0; p < statistics.percentiles.size(); ++p) {
    const std::uint64_t rank = rank_of(FieldStatistics::kPercents[p], range.finite);
    while (upto <= rank) upto += (++value)->second;
    statistics.percentiles[p] = value->first;
  }
  return statistics;
}

// Numbers of T as unsigned ones of the same size and order.
template <class T>
class OrderedKeys {
 public:
  using Key = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;

  [[nodiscard]] static Key of(T value) {
    const auto bits = std::bit_cast<Key>(value);
    if constexpr (std::is_floating_point_v<T>) return (bits & kSign) != 0 ? ~bits : bits | kSign;
    return std::is_signed_v<T> ? bits ^ kSign : bits;
  }

  [[nodiscard]] static T value(Key key) {
    if constexpr (std::is_floating_point_v<T>) return std::bit_cast<T>((key & kSign) != 0 ? key & ~kSign : ~key);
    return std::bit_cast<T>(std::is_signed_v<T> ? key ^ kSign : key);
  }

 private:
  static constexpr Key kSign = Key{1} << (8 * sizeof(Key) - 1);
};

// The samples of some ranks, found 16 bits of their keys at a time, in the order of the scaled values: each pass counts
// the next bits of those samples whose bits before are the ones that were found.
template <class T>
std::array<double, FieldStatistics::kPercents.size()> exact_percentiles(const ScalarField& field, std::uint64_t finite,
                                                                        Progress* progress) {
  using Key = typename OrderedKeys<T>::Key;
  constexpr std::size_t kPercents = FieldStatistics::kPercents.size();
  constexpr int kDigitBits = 16;
  constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
  const ValueScale scale = field.scale;
  const auto key_of = [falling = scale.slope < 0](T stored) {
    const Key key = OrderedKeys<T>::of(stored);
    return falling ? static_cast<Key>(~key) : key;
  };
  std::array<std::uint64_t, kPercents> ranks{};
  for (std::size_t p = 0; p < kPercents; ++p) ranks[p] = rank_of(FieldStatistics::kPercents[p], finite);
  std::array<Key, kPercents> found{};  // the bits so far
  for (int shift = 8 * static_cast<int>(sizeof(Key)) - kDigitBits; shift >= 0; shift -= kDigitBits) {
    const bool first = shift + kDigitBits == 8 * static_cast<int>(sizeof(Key));
    std::vector<Key> prefixes;  // each once
    for (const Key prefix : found) {
      if (prefixes.empty() || prefixes.back() != prefix) prefixes.push_back(prefix);
    }
    const auto add = [&](std::vector<std::uint64_t>& counts, T stored, std::uint64_t times) {
      if (!std::isfinite(scale(static_cast<double>(stored)))) return;
      const Key key = key_of(stored);
      const Key before = first ? 0 : key >> (shift + kDigitBits) % (8 * sizeof(Key));
      for (std::size_t slot = 0; slot < prefixes.size(); ++slot) {
        if (prefixes[slot] == before) counts[slot * kDigits + (key >> shift) % kDigits] += times;
      }
    };
    std::vector<std::uint64_t> counts = count_samples<T>(
        field.samples, prefixes.size() * kDigits,
        [&](std::vector<std::uint64_t>& part, std::span<const T> values) {
          for (const T stored : values) add(part, stored, 1);
        },
        progress);
    for_each_tile(field.samples,
                  [&](double stored, std::uint64_t voxels) { add(counts, static_cast<T>(stored), voxels); });
    for (std::size_t p = 0; p < kPercents; ++p) {
      const auto slot = static_cast<std::size_t>(std::ranges::find(prefixes, found[p]) - prefixes.begin());
      // Samples of a file that somebody writes to may have become others since they were counted.
      Key digit = 0;
      for (; digit + 1 < kDigits && ranks[p] >= counts[slot * kDigits + digit]; ++digit) {
        ranks[p] -= counts[slot * kDigits + digit];
      }
      found[p] = (first ? 0 : found[p] << kDigitBits) | digit;
    }
  }
  std::array<double, kPercents> percentiles{};
  for (std::size_t p = 0; p < kPercents; ++p) {
    const Key key = scale.slope < 0 ? static_cast<Key>(~found[p]) : found[p];
    percentiles[p] = scale(static_cast<double>(OrderedKeys<T>::value(key))) + 0.0;  // -0 is 0
  }
  return percentiles;
}

// Between which two bins Otsu's criterion, the variance between the classes, is largest: in (0, 1) of the range.
// Where an empty gap makes several thresholds equally good, the middle of them.
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

// `value` with no more digits than the width of a histogram bin justifies.
double rounded_to_bin(double value, double bin_width) {
  if (!std::isfinite(bin_width) || bin_width < std::numeric_limits<double>::min()) return value;
  const double exponent = std::floor(std::log10(bin_width));
  // A power of ten below one is not a double; its reciprocal is.
  const double rounded = exponent < 0 ? std::round(value * std::pow(10.0, -exponent)) / std::pow(10.0, -exponent)
                                      : std::round(value / std::pow(10.0, exponent)) * std::pow(10.0, exponent);
  return std::isfinite(rounded) ? rounded : value;
}

// With the background of a sparse field, which is no part of the statistics but surrounds what is.
Range whole_range(const ScalarField& field, const FieldStatistics& statistics) {
  Range range;
  if (statistics.samples > 0) {
    range.add(statistics.min, 1);
    range.add(statistics.max, 1);
  }
  if (const auto* sparse = std::get_if<SparseSamples>(&field.samples)) range.add(field.scale(sparse->background), 1);
  return range;
}

}  // namespace

FieldStatistics measure_statistics(const ScalarField& field, Progress* progress) {
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    if constexpr (kCountable<T>) {
      return statistics_of(Tally<T>(field.samples, progress).values(field.scale));
    } else {
      FieldStatistics statistics;
      const Range range = measure_range<T>(field, progress);
      statistics.samples = range.finite;
      statistics.nan = range.nan;
      statistics.infinite = range.infinite;
      if (range.finite == 0) return statistics;
      const Histogram histogram = measure_histogram<T>(field, range, progress);
      describe(range, histogram, statistics);
      statistics.percentiles = exact_percentiles<T>(field, statistics.samples, progress);
      return statistics;
    }
  });
}

IsoSuggestion suggest_iso(const ScalarField& field, const FieldStatistics& statistics) {
  const Range range = whole_range(field, statistics);
  const auto suggestion = [&](double iso, std::string method) {
    const bool level_set = field.kind == FieldKind::level_set;  // a value equal to iso is outside
    const bool separates = level_set ? range.min < iso && iso <= range.max : range.min <= iso && iso < range.max;
    return IsoSuggestion{iso, std::move(method), separates};
  };
  if (field.kind == FieldKind::level_set) return suggestion(0, "the zero of the level set");
  for (const DemoDescription& demo : demo_fields()) {
    if (field.source.starts_with(kDemoPrefix) && field.name == demo.name) {
      return suggestion(demo.iso, "the demo field's own");
    }
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

}  // namespace isoextract::field
