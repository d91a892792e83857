// Transfer functions: which colour a value has, and how much light it takes on a unit of length.
//
// What is given are control points: a value, a colour, and the opacity of a layer one unit thick. What is drawn is a
// table of kEntries entries at equal steps of value from the first control point to the last: linear colour, and the
// extinction per unit length, sigma = -ln(1 - opacity). Opacities count as at most kMaxOpacity, so that sigma is
// finite. A layer of length l then has the opacity 1 - exp(-sigma l) = 1 - (1 - opacity)^l, however it is cut into
// steps.
//
// Both backends look values up alike. Each sample becomes a position in the table first, in double: position(). What is
// interpolated between samples is these positions, in float; lookup() clamps the result to [0, kEntries - 1] and reads
// the entries floor(p) and that + 1 linearly, a + t * (b - a). As positions are linear in the value, this is what the
// interpolated value has, but fields with a large offset lose nothing. Values beyond the table have its ends. NaN, at
// any of the eight samples that count, has sigma 0.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "base/words.hpp"

namespace isoextract::render {

struct ControlPoint {
  double value = 0;
  glm::dvec3 colour{0.0};  // linear light, each channel from 0 to 1
  double opacity = 0;      // of a layer of one unit of length, from 0 to 1

  friend bool operator==(const ControlPoint&, const ControlPoint&) = default;
};

class TransferFunction {
 public:
  static constexpr int kEntries = 1024;
  static constexpr double kMaxOpacity = 1 - 0x1p-24;

  // Nothing is seen.
  TransferFunction();
  // At least two control points, values increasing (equal ones make a step), finite, first and last apart, colours and
  // opacities in range. ErrorCode::usage tells which is not.
  [[nodiscard]] static Result<TransferFunction> create(std::span<const ControlPoint> points);

  // Red, green, blue, sigma. Sigma of an entry is 0 exactly where the opacity there is.
  [[nodiscard]] const std::array<glm::vec4, kEntries>& table() const { return table_; }
  [[nodiscard]] double min() const { return min_; }
  [[nodiscard]] double max() const { return max_; }

  // Positions that are beyond +-kFarthest, infinite ones too, count as that: differences of two are finite.
  static constexpr double kFarthest = 1e30;
  [[nodiscard]] float position(double value) const {
    return static_cast<float>(std::clamp((value - min_) * per_value_, -kFarthest, kFarthest));
  }
  // (kEntries - 1) / (max - min)
  [[nodiscard]] double per_value() const { return per_value_; }

  [[nodiscard]] glm::vec4 lookup(float position) const;

  // Whether a position interpolated between some in [low, high] can have a sigma that is not 0; rounding, where the two
  // differ, is allowed for. Neither is NaN.
  [[nodiscard]] bool seen_between(float low, float high) const;

 private:
  std::array<glm::vec4, kEntries> table_{};
  std::array<int, kEntries + 1> seen_before_{};  // how many of the first n entries have a sigma
  double min_ = 0;
  double max_ = 1;
  double per_value_ = kEntries - 1;
};

// The built-in ones, over a range of values.
enum class BuiltInTransfer { grey, smoke, fire, bone, rainbow };
constexpr auto words_of(BuiltInTransfer /*type*/) {
  return std::array{Word{BuiltInTransfer::grey, "grey"}, Word{BuiltInTransfer::smoke, "smoke"},
                    Word{BuiltInTransfer::fire, "fire"}, Word{BuiltInTransfer::bone, "bone"},
                    Word{BuiltInTransfer::rainbow, "rainbow"}};
}
// Transparent at `min`. Max above min; both finite.
[[nodiscard]] std::vector<ControlPoint> built_in(BuiltInTransfer name, double min, double max);

// Lines of "VALUE RED GREEN BLUE OPACITY", by white space; `#` starts a comment. Red, green and blue are from 0 to 1 as
// screens have them (sRGB); they become linear light. ErrorCode::input names `source`, the line, and what was expected.
[[nodiscard]] Result<std::vector<ControlPoint>> parse_transfer_function(std::string_view text,
                                                                        const std::string& source);

}  // namespace isoextract::render
