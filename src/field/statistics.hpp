// The statistics that `info` shows: range, percentiles, histogram and a suggested iso value.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/progress.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// Statistics of the scaled values (ValueScale) of all samples. Of a sparse field they cover blocks and tiles (a tile
// counts as all its voxels), but not samples equal to the background, nor to its negative in a level set. NaN and
// infinities are counted and otherwise left out.
struct FieldStatistics {
  std::uint64_t samples = 0;  // number of finite samples
  std::uint64_t nan = 0;
  std::uint64_t infinite = 0;
  bool far_inside = false;  // whether a sparse level set has samples equal to the negative of its background
  double min = 0;
  double max = 0;
  double mean = 0;
  // Each distinct value and its count, in ascending order, if there are at most kMaxListedValues. Only for integer
  // samples of up to 16 bits, and for those of 32 bits with an identity scale and a range below 2^16; else empty.
  std::vector<std::pair<double, std::uint64_t>> values;
  static constexpr std::size_t kMaxListedValues = 256;
  std::vector<std::uint64_t> histogram;  // 1024 equal bins over [min, max]; empty if no sample is finite

  // percentiles[n] is the smallest sample that at least kPercents[n] percent of the samples do not exceed.
  static constexpr std::array kPercents{1, 5, 25, 50, 75, 95, 99};
  std::array<double, kPercents.size()> percentiles{};
};

// Percentiles of samples of 32 and 64 bits take extra passes; `no` skips these and leaves such percentiles 0. Integers
// whose values are all counted (see FieldStatistics::values), and f16 samples, get percentiles anyway.
enum class WithPercentiles { yes, no };

// Reads all samples, in parallel. Reserves no memory; see statistics_bytes() (percentiles.hpp).
[[nodiscard]] FieldStatistics measure_statistics(const ScalarField& field, Progress* progress = nullptr,
                                                 WithPercentiles percentiles = WithPercentiles::yes);

// The range of iso values that have a surface. It covers the samples, the background of a sparse field and, if
// FieldStatistics::far_inside, the negative of the background.
struct SurfaceRange {
  double min = 0;
  double max = 0;
  FieldKind kind = FieldKind::density;

  // Returns whether `iso` has values on both sides, so that a surface exists.
  [[nodiscard]] bool has_surface(double iso) const {
    return kind == FieldKind::level_set ? min < iso && iso <= max : min <= iso && iso < max;  // iso itself is outside
  }
};
// `statistics` must be of `field`. Returns nothing if no value is finite.
[[nodiscard]] std::optional<SurfaceRange> surface_range(const ScalarField& field, const FieldStatistics& statistics);

struct IsoSuggestion {
  double iso;
  std::string method;      // "the zero of the level set", "Otsu's threshold (1979) of the histogram"
  bool separates = false;  // samples exist inside and outside, so that a surface exists
};

// The iso value that the kind of a field implies without reading samples: 0 for level sets, a fixed one for demo
// fields.
struct DefaultIso {
  double iso;
  std::string method;  // as in IsoSuggestion
};
[[nodiscard]] std::optional<DefaultIso> default_iso(const ScalarField& field);

// Suggests the iso value of default_iso(), else Otsu's threshold of the histogram. If all samples have one value,
// suggests this value, or halfway between it and the background of a sparse field. Suggests 0 if no sample is finite.
// `statistics` must be of `field`; percentiles are not needed.
[[nodiscard]] IsoSuggestion suggest_iso(const ScalarField& field, const FieldStatistics& statistics);

// The iso values of skin and bone in a CT scan, in Hounsfield units.
struct CtIsos {
  double skin = 0;
  double bone = 0;
};

// Returns the two thresholds of Otsu's method for three classes (multi-Otsu; Otsu 1979, section IV) of the histogram
// from -1100 up: scanners write lower values outside their circle of view. Returns nothing if no two thresholds
// separate three classes, and for fields that are no CT scans. A CT scan is a density with 16-bit integer samples and
// values above 1000. In its histogram, the fullest bin between -1200 and -500 is air: it lies between -1100 and -900
// and has at least 1 % of the samples. `statistics` must be of `field`; percentiles are not needed.
[[nodiscard]] std::optional<CtIsos> suggest_ct_isos(const ScalarField& field, const FieldStatistics& statistics);

}  // namespace isoextract::field
