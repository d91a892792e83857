#include "render/transfer_function.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "base/srgb.hpp"

namespace isoextract::render {
namespace {

bool in_unit(double v) { return v >= 0 && v <= 1; }

glm::dvec3 linear(const glm::dvec3& srgb) {
  return {srgb_to_linear(srgb.x), srgb_to_linear(srgb.y), srgb_to_linear(srgb.z)};
}

struct Stop {
  double place;  // 0 .. 1 of the range
  glm::dvec3 srgb;
  double opacity;
};

// Opacities are for a layer of about 1/100 of the volume's side: at 0.05, half of the side hides over 90 % of the light
// behind it.
std::span<const Stop> stops_of(BuiltInTransfer name) {
  static constexpr std::array kGray{Stop{0, {0, 0, 0}, 0}, Stop{1, {1, 1, 1}, 0.08}};
  static constexpr std::array kSmoke{Stop{0, {0.75, 0.77, 0.8}, 0}, Stop{0.05, {0.75, 0.77, 0.8}, 0.004},
                                     Stop{1, {0.93, 0.93, 0.95}, 0.15}};
  static constexpr std::array kFire{Stop{0, {0, 0, 0}, 0}, Stop{0.1, {0.35, 0.05, 0.02}, 0.005},
                                    Stop{0.4, {0.9, 0.25, 0.05}, 0.05}, Stop{0.75, {1, 0.7, 0.2}, 0.1},
                                    Stop{1, {1, 1, 0.85}, 0.15}};
  static constexpr std::array kBone{Stop{0, {0.6, 0.3, 0.2}, 0}, Stop{0.25, {0.6, 0.3, 0.2}, 0},
                                    Stop{0.4, {0.85, 0.55, 0.45}, 0.01}, Stop{0.6, {0.95, 0.9, 0.8}, 0.1},
                                    Stop{1, {1, 1, 0.97}, 0.4}};
  static constexpr std::array kRainbow{Stop{0, {0.1, 0.2, 0.9}, 0}, Stop{0.25, {0, 0.8, 0.9}, 0.01},
                                       Stop{0.5, {0.1, 0.8, 0.2}, 0.03}, Stop{0.75, {0.95, 0.85, 0.1}, 0.06},
                                       Stop{1, {0.9, 0.1, 0.1}, 0.12}};
  // Blackbody colors of 1000, 1500, 2000, 2500 and 3000 K (Charity, "What color is a blackbody?", 2001). Their
  // brightness rises with the temperature, as far as sRGB shows it.
  static constexpr std::array kBlackbody{Stop{0, {0.35, 0.08, 0}, 0}, Stop{0.25, {0.7, 0.3, 0}, 0.02},
                                         Stop{0.5, {0.9, 0.48, 0.06}, 0.05}, Stop{0.75, {1, 0.63, 0.28}, 0.1},
                                         Stop{1, {1, 0.71, 0.42}, 0.15}};
  switch (name) {
    case BuiltInTransfer::blackbody: return kBlackbody;
    case BuiltInTransfer::smoke: return kSmoke;
    case BuiltInTransfer::fire: return kFire;
    case BuiltInTransfer::bone: return kBone;
    case BuiltInTransfer::rainbow: return kRainbow;
    case BuiltInTransfer::gray: break;
  }
  return kGray;
}

tl::unexpected<Error> refuse_function(const std::string& found) {
  return fail(ErrorCode::usage, "the transfer function: " + found);
}

}  // namespace

TransferFunction::TransferFunction() { table_.fill(glm::vec4(0)); }

Result<TransferFunction> TransferFunction::create(std::span<const ControlPoint> points) {
  if (points.size() < 2)
    return refuse_function(fmt::format("expected at least two control points, found {}", points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ControlPoint& p = points[i];
    if (!std::isfinite(p.value)) return refuse_function(fmt::format("expected finite values, found {:g}", p.value));
    if (i > 0 && p.value < points[i - 1].value) {
      return refuse_function(
          fmt::format("the values must not decrease, found {:g} after {:g}", p.value, points[i - 1].value));
    }
    if (!in_unit(p.color.r) || !in_unit(p.color.g) || !in_unit(p.color.b) || !in_unit(p.opacity)) {
      return refuse_function(fmt::format("expected a color and an opacity from 0 to 1 at the value {:g}", p.value));
    }
  }
  TransferFunction made;
  TRY(made.set_range(points.front().value, points.back().value));
  std::size_t next = 1;  // the control point above the value
  for (int i = 0; i < kEntries; ++i) {
    const double share = double(i) / (kEntries - 1);
    const double value = (1 - share) * made.min_ + share * made.max_;
    while (next + 1 < points.size() && points[next].value <= value) ++next;
    const ControlPoint& a = points[next - 1];
    const ControlPoint& b = points[next];
    const double between = b.value > a.value ? std::clamp((value - a.value) / (b.value - a.value), 0.0, 1.0) : 1;
    const double opacity = std::min(a.opacity + between * (b.opacity - a.opacity), kMaxOpacity);
    const double sigma = opacity > 0 ? -std::log1p(-opacity) : 0;
    made.table_[static_cast<std::size_t>(i)] = glm::vec4(glm::dvec4(a.color + between * (b.color - a.color), sigma));
  }
  made.count_visible();
  return made;
}

Result<TransferFunction> TransferFunction::of_table(double min, double max, const Table& table) {
  TransferFunction made;
  TRY(made.set_range(min, max));
  made.table_ = table;
  made.count_visible();
  return made;
}

Result<void> TransferFunction::set_range(double min, double max) {
  min_ = min;
  max_ = max;
  per_value_ = (kEntries - 1) / (max - min);
  if (!(max > min) || !std::isfinite(per_value_) || !(per_value_ > 0)) {
    return refuse_function(fmt::format("the first and the last value must differ, found {:g} and {:g}", min, max));
  }
  return {};
}

void TransferFunction::count_visible() {
  for (std::size_t i = 0; i < table_.size(); ++i) {
    visible_before_[i + 1] = visible_before_[i] + (table_[i].a > 0 ? 1 : 0);
  }
}

glm::vec4 TransferFunction::lookup(float position) const {
  const float p = std::clamp(position, 0.0F, static_cast<float>(kEntries - 1));
  if (!(p >= 0)) return glm::vec4(0);  // NaN
  const auto below = static_cast<std::size_t>(p);
  const glm::vec4& a = table_[below];
  const glm::vec4& b = table_[std::min(below + 1, table_.size() - 1)];
  return a + (p - static_cast<float>(below)) * (b - a);
}

bool TransferFunction::is_visible_between(float low, float high) const {
  // Interpolation rounds three times per axis; this allows for one more.
  constexpr float kRounding = 0x1p-20F;
  const float slack = low < high ? kRounding * std::max(std::abs(low), std::abs(high)) : 0;
  const auto entry = [](float position) {
    return static_cast<std::size_t>(std::clamp(position, 0.0F, static_cast<float>(kEntries - 1)));
  };
  const float last = high + slack;
  const std::size_t first_entry = entry(low - slack);
  // A position exactly on an entry does not use the next one.
  const std::size_t last_entry = std::min(entry(std::ceil(last)), std::size_t{kEntries - 1});
  return visible_before_[last_entry + 1] > visible_before_[first_entry];
}

std::vector<ControlPoint> built_in_points(BuiltInTransfer name, double min, double max) {
  std::vector<ControlPoint> points;
  for (const Stop& stop : stops_of(name)) {
    points.push_back({(1 - stop.place) * min + stop.place * max, linear(stop.srgb), stop.opacity});
  }
  return points;
}

Result<std::vector<ControlPoint>> parse_transfer_function(std::string_view text, const std::string& source) {
  constexpr std::string_view kBlank = " \t\r";
  std::vector<ControlPoint> points;
  for (int line_number = 1; !text.empty(); ++line_number) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    line = line.substr(0, line.find('#'));
    const auto refuse = [&](const std::string& found) {
      return fail(
          ErrorCode::input,
          fmt::format("{}: line {}: expected a value, red, green, blue and opacity, the last four from 0 to 1, {}",
                      source, line_number, found));
    };
    std::vector<double> numbers;
    while (true) {
      line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
      if (line.empty()) break;
      const std::string_view word = line.substr(0, line.find_first_of(kBlank));
      double number = 0;
      const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), number);
      if (problem != std::errc() || end != word.data() + word.size() || !std::isfinite(number)) {
        return refuse(fmt::format("found '{}'", word));
      }
      numbers.push_back(number);
      line.remove_prefix(word.size());
    }
    if (numbers.empty()) continue;
    if (numbers.size() != 5) return refuse(fmt::format("found {} numbers", numbers.size()));
    const ControlPoint point{numbers[0], {numbers[1], numbers[2], numbers[3]}, numbers[4]};
    const auto outside = std::find_if_not(numbers.begin() + 1, numbers.end(), in_unit);
    if (outside != numbers.end()) return refuse(fmt::format("found {:g}", *outside));
    points.push_back({point.value, linear(point.color), point.opacity});
  }
  return points;
}

}  // namespace isoextract::render
