// Transfer functions: the color of a value, and how much light it absorbs per unit of length.
//
// The input is control points: a value, a color, and the opacity of a layer one unit thick. Renderers use a table of
// kEntries entries at equal steps of value from the first to the last control point: linear color and the extinction
// per unit length, sigma = -ln(1 - opacity).
// Opacities are clamped to kMaxOpacity, so that sigma is finite. A layer of length l has the opacity 1 - exp(-sigma l)
// = 1 - (1 - opacity)^l, independent of the number of steps.
//
// Both backends look up values in the same way. position() first maps each sample to a table position, in double.
// Positions are interpolated between samples in float. lookup() clamps the result to [0, kEntries - 1] and interpolates
// entries floor(p) and floor(p) + 1 as a + t * (b - a).
// Since positions are linear in the value, this equals interpolating values, but fields with a large offset lose no
// precision. Values outside of the table get its first or last entry. If one of the eight samples is NaN, sigma is 0.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "base/enum_words.hpp"
#include "base/error.hpp"

namespace isoextract::render {

struct ControlPoint {
  double value = 0;
  glm::dvec3 color{0.0};  // linear light, each channel from 0 to 1
  double opacity = 0;     // of a layer one unit thick, from 0 to 1

  friend bool operator==(const ControlPoint&, const ControlPoint&) = default;
};

class TransferFunction {
 public:
  static constexpr int kEntries = 1024;
  static constexpr double kMaxOpacity = 1 - 0x1p-24;

  // Makes a function with which every value is invisible.
  TransferFunction();
  // Makes a function of at least two control points with finite values in ascending order; equal values make a step.
  // First and last value must differ; colors and opacities must be in range. Otherwise fails with ErrorCode::usage.
  [[nodiscard]] static Result<TransferFunction> create(std::span<const ControlPoint> points);
  using Table = std::array<glm::vec4, kEntries>;
  // Makes a function of the entries themselves, at equal steps of value from `min` to `max`. Fails with
  // ErrorCode::usage if `min` and `max` are not finite, or not in ascending order.
  [[nodiscard]] static Result<TransferFunction> of_table(double min, double max, const Table& table);

  // Returns the entries red, green, blue, sigma. Sigma is exactly 0 where the opacity is 0.
  [[nodiscard]] const Table& table() const { return table_; }
  [[nodiscard]] double min() const { return min_; }
  [[nodiscard]] double max() const { return max_; }

  // position() clamps to +-kFarthest, so that differences of positions are finite.
  static constexpr double kFarthest = 1e30;
  [[nodiscard]] float position(double value) const {
    return static_cast<float>(std::clamp((value - min_) * per_value_, -kFarthest, kFarthest));
  }
  // Returns (kEntries - 1) / (max - min).
  [[nodiscard]] double positions_per_value() const { return per_value_; }

  [[nodiscard]] glm::vec4 lookup(float position) const;

  // Returns whether sigma can be above 0 for samples whose positions lie in [low, high]. If low and high differ, widens
  // the range by the rounding of the interpolation. Neither may be NaN.
  [[nodiscard]] bool is_visible_between(float low, float high) const;

 private:
  [[nodiscard]] Result<void> set_range(double min, double max);
  void count_visible();  // sets visible_before_

  Table table_{};
  std::array<int, kEntries + 1> visible_before_{};  // how many of the first n entries have a sigma above 0
  double min_ = 0;
  double max_ = 1;
  double per_value_ = kEntries - 1;
};

// Built-in transfer functions over a range of values. `blackbody` has the colors of 1000 K at the beginning of the
// range to 3000 K at its end.
enum class BuiltInTransfer { gray, smoke, fire, bone, rainbow, blackbody };
constexpr auto words_of(BuiltInTransfer /*type*/) {
  return std::array{Word{BuiltInTransfer::gray, "gray"},       Word{BuiltInTransfer::smoke, "smoke"},
                    Word{BuiltInTransfer::fire, "fire"},       Word{BuiltInTransfer::bone, "bone"},
                    Word{BuiltInTransfer::rainbow, "rainbow"}, Word{BuiltInTransfer::blackbody, "blackbody"}};
}
// Returns the control points of a built-in function, which is transparent at `min`. Requires finite min < max.
[[nodiscard]] std::vector<ControlPoint> built_in_points(BuiltInTransfer name, double min, double max);

// Parses lines of "VALUE RED GREEN BLUE OPACITY", separated by blanks; `#` starts a comment. Red, green and blue are
// sRGB from 0 to 1 and are converted to linear light. Fails with ErrorCode::input; the message names `source` and the
// line.
[[nodiscard]] Result<std::vector<ControlPoint>> parse_transfer_function(std::string_view text,
                                                                        const std::string& source);

}  // namespace isoextract::render
