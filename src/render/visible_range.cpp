#include "render/visible_range.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>

#include "field/percentiles.hpp"

namespace isoextract::render {
namespace {

constexpr double kNoise = 1.3;        // end of noise above the median, in distances from 1st percentile to median
constexpr double kTop = 0.999;        // share of samples below the end of the range
constexpr double kMostOfMean = 8;     // largest end of the range, in means
constexpr double kOneBin = 0.9;       // share of samples in one bin that the histogram does not resolve
constexpr double kManyPowers = 3;     // least ratio of mean to median of densities over many powers of ten
constexpr double kUnlikeSides = 0.3;  // largest difference of the tails' lengths, in lengths of both
constexpr double kOffMiddle = 0.05;   // largest distance of the median from 0, in lengths of both tails
constexpr double kLongTails = 4;      // least length of both tails, in distances between the quartiles

class Histogram {
 public:
  explicit Histogram(const field::FieldStatistics& statistics)
      : bins_(statistics.histogram),
        min_(statistics.min),
        width_((statistics.max - statistics.min) / static_cast<double>(bins_.size())) {}

  [[nodiscard]] double value(double bin) const { return min_ + bin * width_; }
  [[nodiscard]] std::size_t bin_of(double value) const {
    return static_cast<std::size_t>(std::clamp((value - min_) / width_, 0.0, static_cast<double>(bins_.size() - 1)));
  }
  [[nodiscard]] std::uint64_t count(std::size_t begin, std::size_t end) const {
    const auto part = bins_.subspan(begin, end - begin);
    return std::accumulate(part.begin(), part.end(), std::uint64_t{0});
  }
  [[nodiscard]] std::uint64_t fullest() const { return *std::ranges::max_element(bins_); }

  // Returns the value below which this share of the samples in the bins [begin, end) lies.
  [[nodiscard]] double quantile(double share, std::size_t begin, std::size_t end) const {
    const double wanted = share * static_cast<double>(count(begin, end));
    double before = 0;
    for (std::size_t bin = begin; bin < end; ++bin) {
      const auto here = static_cast<double>(bins_[bin]);
      if (here > 0 && before + here >= wanted) return value(static_cast<double>(bin) + (wanted - before) / here);
      before += here;
    }
    return value(static_cast<double>(end));
  }
  [[nodiscard]] double quantile(double share) const { return quantile(share, 0, bins_.size()); }

  // Returns the mean of the samples in the bins from `begin` on, each at the middle of its bin.
  [[nodiscard]] double mean_from(std::size_t begin) const {
    double sum = 0;
    double samples = 0;
    for (std::size_t bin = begin; bin < bins_.size(); ++bin) {
      const auto here = static_cast<double>(bins_[bin]);
      sum += here * (static_cast<double>(bin) + 0.5);
      samples += here;
    }
    return value(sum / std::max(samples, 1.0));
  }

  // Returns the distance from `middle` within which this share of the samples lies.
  [[nodiscard]] double distance_quantile(double share, double middle) const {
    std::vector<std::pair<double, std::uint64_t>> distances;
    for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
      distances.emplace_back(std::abs(value(static_cast<double>(bin) + 0.5) - middle), bins_[bin]);
    }
    std::ranges::sort(distances);
    const double wanted = share * static_cast<double>(count(0, bins_.size()));
    double before = 0;
    for (const auto& [distance, samples] : distances) {
      before += static_cast<double>(samples);
      if (before >= wanted) return distance;
    }
    return distances.back().first;
  }

  [[nodiscard]] std::size_t size() const { return bins_.size(); }

 private:
  std::span<const std::uint64_t> bins_;
  double min_;
  double width_;
};

std::optional<VisibleRange> range_of_both_sides(const Histogram& histogram, const field::FieldStatistics& statistics) {
  if (!(statistics.min < 0 && statistics.max > 0)) return std::nullopt;
  const double low = histogram.quantile(0.01);
  const double high = histogram.quantile(0.99);
  const double median = histogram.quantile(0.5);
  const double quartiles = histogram.quantile(0.75) - histogram.quantile(0.25);
  const double tails = high - low;
  const bool is_alike = std::abs(low + high) < kUnlikeSides * tails && std::abs(median) < kOffMiddle * tails;
  if (!is_alike || !(tails > kLongTails * quartiles)) return std::nullopt;
  return VisibleRange{quartiles, histogram.distance_quantile(kTop, median), true, median};
}

// Returns the range of densities over many powers of ten, which the histogram does not resolve.
std::optional<VisibleRange> range_of_many_powers(const field::ScalarField& field,
                                                 const field::FieldStatistics& statistics) {
  constexpr std::array kMedian{field::Percent(50)};
  const auto median = field::measure_percentiles(field, kMedian);
  if (!median) return std::nullopt;
  const double typical = median->front() - statistics.min;
  const double mean = statistics.mean - statistics.min;
  if (!(typical > 0 && mean > kManyPowers * typical)) return std::nullopt;
  return VisibleRange{statistics.min, statistics.min + kMostOfMean * mean};
}

VisibleRange range_of_values(const field::ScalarField& field, const field::FieldStatistics& statistics) {
  if (field.kind == field::FieldKind::level_set) return {statistics.min, std::min(statistics.max, 0.0)};
  if (!(statistics.max > statistics.min)) return {statistics.min, statistics.max};
  const Histogram histogram(statistics);
  if (const auto both = range_of_both_sides(histogram, statistics)) return *both;
  if (static_cast<double>(histogram.fullest()) > kOneBin * static_cast<double>(statistics.samples)) {
    if (const auto many = range_of_many_powers(field, statistics)) return *many;
  }
  const double threshold = field::suggest_iso(field, statistics).iso;
  const std::size_t end = histogram.bin_of(threshold);
  if (end == 0 || histogram.count(0, end) == 0) return {statistics.min, statistics.max};
  const double median = histogram.quantile(0.5, 0, end);
  const double noise = median - histogram.quantile(0.01, 0, end);
  const double low = std::min(threshold, median + kNoise * noise);
  const std::size_t begin = histogram.bin_of(low);
  const double top = histogram.quantile(kTop, begin, histogram.size());
  return {low, std::min(top, low + kMostOfMean * (histogram.mean_from(begin) - low))};
}

}  // namespace

VisibleRange visible_range(const field::ScalarField& field, const field::FieldStatistics& statistics) {
  VisibleRange range = range_of_values(field, statistics);
  // Any range will do if all samples are equal: nothing is visible.
  if (!(range.high > range.low)) range.high = range.low + std::max(std::abs(range.low), 1.0);
  return range;
}

std::vector<ControlPoint> built_in_points(BuiltInTransfer name, const VisibleRange& range, field::FieldKind kind) {
  const auto turned = [](std::vector<ControlPoint> points) {
    for (ControlPoint& point : points) point.value = -point.value;
    std::ranges::reverse(points);
    return points;
  };
  if (kind == field::FieldKind::level_set) return turned(built_in_points(name, -range.high, -range.low));
  if (!range.both_sides) return built_in_points(name, range.low, range.high);
  const std::vector<ControlPoint> above = built_in_points(name, range.low, range.high);
  std::vector<ControlPoint> points = turned(above);
  points.insert(points.end(), above.begin(), above.end());
  for (ControlPoint& point : points) point.value += range.middle;
  return points;
}

}  // namespace isoextract::render
