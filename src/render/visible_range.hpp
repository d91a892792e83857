// Chooses the range of values for a built-in transfer function, to show the object without the noise around it.
#pragma once

#include <vector>

#include "field/scalar_field.hpp"
#include "field/statistics.hpp"
#include "render/transfer_function.hpp"

namespace isoextract::render {

// The values from `low` to `high`. The function is transparent at `low`, for level sets at `high`. With `both_sides`,
// `low` and `high` are distances above and below `middle`.
struct VisibleRange {
  double low = 0;
  double high = 1;  // above low
  bool both_sides = false;
  double middle = 0;
};

// Chooses the range from the histogram. `statistics` must be of `field`; percentiles are not needed. There are four
// cases; the first that applies decides:
//
//   - Level sets: from the least value to 0, or to the greatest value if it is below 0.
//   - Values on both sides of 0 with similar, long tails, such as seismic amplitudes and wave functions. The range has
//     both sides of the median: from the distance between the quartiles to the 99.9th percentile of the distances.
//   - Densities over many powers of ten: over 90 % of the samples are in one bin of the histogram, and the mean is more
//     than 3 times as far above the least value as the median. The range begins at the least value and ends 8 times as
//     far above it as the mean.
//   - All other fields: the background is the samples below the iso value t of field::suggest_iso() (Otsu's threshold).
//     With their median m and 1st percentile p, the range begins at min(t, m + 1.3 (m - p)), the upper end of a
//     symmetric noise. The range ends at the 99.9th percentile of the samples above its beginning, but at most 8 times
//     as far from the beginning as the mean of these samples. So a few large values do not hide the smaller ones.
[[nodiscard]] VisibleRange visible_range(const field::ScalarField& field, const field::FieldStatistics& statistics);

// Returns the control points of a built-in function over the range. For a level set, the function runs from high to low
// values, because values fall inwards.
[[nodiscard]] std::vector<ControlPoint> built_in_points(BuiltInTransfer name, const VisibleRange& range,
                                                        field::FieldKind kind);

}  // namespace isoextract::render
