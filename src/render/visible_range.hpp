// Chooses the values that a built-in transfer function shows, so that it shows the object and not the noise around it.
#pragma once

#include <vector>

#include "field/scalar_field.hpp"
#include "field/statistics.hpp"
#include "render/transfer_function.hpp"

namespace isoextract::render {

// The function is transparent at `low` and covers the values to `high`. With `both_sides` it covers these distances
// above and below `middle`.
struct VisibleRange {
  double low = 0;
  double high = 1;  // above low
  bool both_sides = false;
  double middle = 0;
};

// Chooses the range by the histogram. `statistics` must be of `field`; percentiles are not needed.
//
// A level set is visible from 0 inwards. In other fields, the background are the samples up to the iso value t that
// field::suggest_iso() gives (Otsu's threshold). With their median m and their 1st percentile p, the range begins at
// min(t, m + 1.3 (m - p)), the upper end of a symmetric noise. It ends at the 99.9th percentile of the samples above,
// but at most 8 times as far from the beginning as their mean, so that a few large values do not hide the others.
// Densities over many powers of ten get the range from the least value to 8 times the mean above it. They are fields
// with 90 % of the samples in one bin of the histogram, and a mean over 3 times as far above the least value as the
// median.
//
// Seismic amplitudes and wave functions have values on both sides of 0, alike and with long tails. Such a field is
// visible on both sides of its median: from the distance between the quartiles to the 99.9th percentile of distances.
[[nodiscard]] VisibleRange visible_range(const field::ScalarField& field, const field::FieldStatistics& statistics);

// Returns the control points of a built-in function over the range. For a level set, values fall inwards.
[[nodiscard]] std::vector<ControlPoint> built_in_points(BuiltInTransfer name, const VisibleRange& range,
                                                        field::FieldKind kind);

}  // namespace isoextract::render
