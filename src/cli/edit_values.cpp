#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cli/values.hpp"
#include "field/blur.hpp"

namespace isoextract::cli {
namespace {

struct Measure {
  double amount = 0;
  bool in_world_units = false;
};

constexpr std::string_view kVoxels = "voxels";  // another spelling of the unit in 3voxel

// Removes `unit` from the end of the text.
bool take_unit(std::string_view& text, std::string_view unit) {
  if (!text.ends_with(unit)) return false;
  text.remove_suffix(unit.size());
  return true;
}

// Parses a number above 0 with its unit: voxels, or world units with the suffix "world".
std::optional<Measure> measure_of(std::string_view text) {
  const bool in_world_units = take_unit(text, convert::kWorldUnit);
  if (!in_world_units && !take_unit(text, convert::kVoxelUnit)) take_unit(text, kVoxels);
  const auto amount = parse_positive(text);
  if (!amount) return std::nullopt;
  return Measure{*amount, in_world_units};
}

}  // namespace

Result<convert::MinComponentSize> parse_min_component_size(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) {
    if (const auto triangles = parse_positive_count(text)) {
      return convert::MinComponentSize{edit::ComponentMeasure::triangles, static_cast<double>(*triangles), false};
    }
  } else if (const auto measure = value_of<edit::ComponentMeasure>(text.substr(0, colon))) {
    const auto least = measure_of(text.substr(colon + 1));
    if (least && *measure != edit::ComponentMeasure::triangles) {
      return convert::MinComponentSize{*measure, least->amount, least->in_world_units};
    }
  }
  return fail(
      ErrorCode::usage,
      fmt::format(
          "expected a number of triangles such as 100, or area:40 or volume:5 in voxels, or volume:5world in the "
          "units of the written mesh, found '{}'",
          text));
}

Result<convert::SimplifyBound> parse_simplify_bound(std::string_view text) {
  if (const auto distance = measure_of(text)) return convert::SimplifyBound{distance->amount, distance->in_world_units};
  return fail(ErrorCode::usage,
              fmt::format("expected a distance above 0, in voxels such as 0.1 or in the units of the written "
                          "mesh such as 0.5world, found '{}'",
                          text));
}

Result<convert::SmoothChoice> parse_smoothing(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::string_view rest = text;;) {
    const std::size_t colon = rest.find(':');
    parts.push_back(rest.substr(0, colon));
    if (colon == std::string_view::npos) break;
    rest.remove_prefix(colon + 1);
  }
  convert::SmoothChoice choice;
  const auto passes = parse_positive_count(parts[0]);
  bool fits = passes && *passes <= edit::kMaxSmoothPasses && parts.size() <= 3;
  if (fits && parts.size() > 1) {
    const auto method = value_of<edit::SmoothMethod>(parts[1]);
    fits = method.has_value();
    choice.method = method.value_or(choice.method);
  }
  if (fits && parts.size() > 2) {
    const auto band = parse_positive(parts[2]);
    fits = band && *band < 1 && choice.method != edit::SmoothMethod::weighted;
    choice.pass_band = fits ? *band : choice.pass_band;
  }
  if (!fits) {
    return fail(
        ErrorCode::usage,
        fmt::format(
            "expected 1 to {} passes, such as 20, 20:taubin, 20:sinc or 25:weighted; after taubin or sinc also a "
            "pass band between 0 and 1, such as 20:sinc:0.05; found '{}'",
            edit::kMaxSmoothPasses, text));
  }
  choice.passes = *passes;
  return choice;
}

Result<convert::HollowChoice> parse_hollow(std::string_view text) {
  const std::size_t end = text.find_last_of("0123456789.");
  std::string_view unit = end == std::string_view::npos ? text : text.substr(end + 1);
  const auto thickness = parse_positive(text.substr(0, text.size() - unit.size()));
  if (unit == kVoxels) unit = convert::kVoxelUnit;
  if (thickness && (unit == convert::kVoxelUnit || unit == convert::kWorldUnit)) {
    return convert::HollowChoice{*thickness, std::string(unit)};
  }
  if (const auto known = convert::find_length_unit(unit); thickness && known) {
    return convert::HollowChoice{*thickness, std::string(known->name)};
  }
  return fail(ErrorCode::usage,
              fmt::format("expected a thickness above 0 with its unit, such as 2mm, 2world in the units of the "
                          "written mesh, or 3voxel, found '{}'",
                          text));
}

Result<convert::RepairChoice> parse_repair(std::string_view text) {
  const auto edges = parse_count(text);
  if (edges && *edges <= edit::kMostHoleEdges) return convert::RepairChoice{*edges};
  return fail(ErrorCode::usage,
              fmt::format("expected a number of edges from 0 to {}, found '{}'", edit::kMostHoleEdges, text));
}

Result<HeightBase> parse_height_base(std::string_view text) {
  if (text == "none") return HeightBase();
  const auto height = parse_number(text);
  if (!height) return fail(ErrorCode::usage, fmt::format("expected a height, or none, found '{}'", text));
  return HeightBase{*height};
}

Result<convert::BlurStep> parse_blur(std::string_view text) {
  constexpr std::string_view kMedian = "median:";
  if (text.starts_with(kMedian)) {
    const auto width = parse_positive_count(text.substr(kMedian.size()));
    if (width && *width <= static_cast<std::uint64_t>(field::kMaxMedianRadius)) {
      return convert::BlurStep{convert::BlurKind::median, static_cast<double>(*width), false};
    }
  } else if (const auto sigma = measure_of(text);
             sigma && (sigma->in_world_units || sigma->amount <= field::kMaxBlurSigma)) {
    return convert::BlurStep{convert::BlurKind::gaussian, sigma->amount, sigma->in_world_units};
  }
  return fail(
      ErrorCode::usage,
      fmt::format(
          "expected the standard deviation of a Gaussian, above 0 and at most {} voxels such as 1.5, or in units "
          "of the input such as 0.7world; or median:1 to median:{}, found '{}'",
          field::kMaxBlurSigma, field::kMaxMedianRadius, text));
}

}  // namespace isoextract::cli
