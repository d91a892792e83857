// What `info` tells of a field's values: range, percentiles, histogram, a suggested iso value.
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

// Dense: over all samples. Sparse: over the samples of blocks and tiles (a tile counts as all its voxels) that are not
// the background, nor its negative in a level set. Values are scaled (ValueScale); NaN and infinities are counted and
// otherwise left out.
struct FieldStatistics {
  std::uint64_t samples = 0;  // finite ones
  std::uint64_t nan = 0;
  std::uint64_t infinite = 0;
  double min = 0;
  double max = 0;
  double mean = 0;
  // Each value and how often it occurs, in rising order: of integers that have up to 16 bits, or 32 and are stored as
  // their values and less than 2^16 apart, where there are at most kMostValues of them. Empty of all else.
  std::vector<std::pair<double, std::uint64_t>> values;
  static constexpr std::size_t kMostValues = 256;
  std::vector<std::uint64_t> histogram;  // 1024 equal bins over [min, max]; empty if there is no finite sample

  // By kPercents: the least of the samples that so many percent of them do not exceed.
  static constexpr std::array kPercents{1, 5, 25, 50, 75, 95, 99};
  std::array<double, kPercents.size()> percentiles{};
};

// Percentiles of samples of 32 and 64 bits take passes of their own; where they are left out they are 0.
enum class WithPercentiles { yes, no };

[[nodiscard]] FieldStatistics measure_statistics(const ScalarField& field, Progress* progress = nullptr,
                                                 WithPercentiles percentiles = WithPercentiles::yes);

// The values that a field's surface may pass: those of its samples, and the background of a sparse field, which
// surrounds them.
struct SurfaceRange {
  double min = 0;
  double max = 0;
  FieldKind kind = FieldKind::density;

  // Whether there are values on both sides of `iso`, and so a surface.
  [[nodiscard]] bool has_surface(double iso) const {
    return kind == FieldKind::level_set ? min < iso && iso <= max : min <= iso && iso < max;  // iso itself is outside
  }
};
// `statistics` must be of `field`. Nothing where no value is finite.
[[nodiscard]] std::optional<SurfaceRange> surface_range(const ScalarField& field, const FieldStatistics& statistics);

struct IsoSuggestion {
  double iso;
  std::string method;      // "the zero of the level set", "Otsu's threshold (1979) of the histogram"
  bool separates = false;  // there are samples inside and outside, and so a surface
};

// What the kind of a field says without a look at its samples: for level sets 0, for demo fields their own.
struct KnownIso {
  double iso;
  std::string method;  // as in IsoSuggestion
};
[[nodiscard]] std::optional<KnownIso> known_iso(const ScalarField& field);

// A value that separates the field in two, if there is one: the known one, or else by the histogram. `statistics` must
// be of `field`, with percentiles or without.
[[nodiscard]] IsoSuggestion suggest_iso(const ScalarField& field, const FieldStatistics& statistics);

}  // namespace isoextract::field
